"""More than one degree of freedom: a resonator hung on, a joint that gives, waves in the rod. Frequency domain."""

from typing import Any

from modelgen.effects.effect import Effect, Shape, Strength, add_impedance, change
from modelgen.language import Parameter, Port, j


def _resonator(at: Port, p: dict[str, Parameter]) -> Any:
    """jωM and (jωM ω_2²/(jω)² (1 + jω/(Q ω_2)))'s series connection: a mass M on a spring and a damper."""
    u = at["omega"] / p["omega_2"]
    link = 1 + j * u / p["Q"]
    return j * at["omega"] * p["M_2"] * link / (link - u**2)


second_mode = Effect(
    "second_mode",
    ("mechanical_impedance", "stiffness"),
    "another resonator hangs on the moving side: a part of it, or of the housing, swings at its own frequency",
    "J. P. Den Hartog, Mechanical Vibrations (1956), sec. 3.2",
    (Strength("M_2", "{impedance}*s", text="mass of the resonator"),),
    add_impedance(_resonator),
    (
        Shape("omega_2", "rad/s", "omega", 0.7, 1.5, 40, text="its resonance when its foot is held"),
        Shape("Q", "1", "1", 1.0, 500.0, 3, text="its quality factor"),
    ),
    needs=("omega",),
)

contact_compliance = Effect(
    "contact_compliance",
    ("load", "mechanical_impedance"),
    "a joint gives: a share of the moving side hangs behind a spring in series, and moves on its own above a second "
    "resonance",
    "J. P. Den Hartog, Mechanical Vibrations (1956), sec. 2.3; impedances in series as in L. L. Beranek, Acoustics, ch. 3",
    # The share γ of Z lies behind a joint of compliance c/γ. With γ = 1 the whole load does.
    (Strength("gamma", "1", bounds=(0.0, 1.0), text="share of the mechanical load that lies behind the joint"),),
    change(lambda Z, at, p: Z * (1 - p["gamma"] + p["gamma"] / (1 + j * at["omega"] * p["c"] * Z))),
    (Shape("c", "1/({stiffness})", "1/(omega*port)", 0.5, 2.0, 24, text="compliance of the joint, times that share"),),
    needs=("omega",),
)

LEVELS = 16


def xcotx(q: Any) -> Any:
    """√q cot √q by Lambert's continued fraction 1 − q/(3 − q/(5 − …)).

    Meromorphic, finite and smooth at q = 0, poles where they belong; its error is below 1e-9 of max(1, |x cot x|) for
    |q| < 40, where the poles at π² and 4π² lie; below 1e-13 for |q| < 12.
    """
    tail: Any = 2 * LEVELS + 1
    for n in range(2 * LEVELS - 1, 0, -2):
        tail = n - q / tail
    return tail


distributed_rod = Effect(
    "distributed_rod",
    ("stiffness",),
    "waves run in the rod: its own mass makes its stiffness K·kl·cot(kl), with (kl)² = ω²m/K",
    "L. E. Kinsler et al., Fundamentals of Acoustics (2000), sec. 3.6: rod with one end held",
    (Strength("m", "{port}*s**2", text="mass of the rod", scale="min(port)/max(omega)**2", low=0.3, high=30.0, points=8),),
    change(lambda K, at, p: K * xcotx(at["omega"] ** 2 * p["m"] / K)),
    needs=("omega",),
    secant=True,  # a third of the rod's mass at first order, which any moving mass absorbs
)

EFFECTS = (second_mode, contact_compliance, distributed_rod)
