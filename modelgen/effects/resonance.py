"""More than one degree of freedom: a resonator hung on, a joint."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from sympy import Symbol

from modelgen.effects.effect import BEFORE, RARER, Effect, Shape, Strength, Values, add_impedance, unit_of
from modelgen.effects.start import at_start
from modelgen.language import Model, Port, State, cos, exp, j, sin, sqrt

Law = Callable[[Port, Values], Any]
HEAVY = 10.0
"""Times the moving mass that a resonator hung on it has at most: with more it is no addition, it takes the
mass' place, and a mass that is known says nothing any more."""


def _hung(n: int, says: str, source: str, law: Law, loss: Shape, common: float = 1.0) -> Effect:
    """Another resonator of mass M_n; `law`: its impedance."""
    return Effect(
        "second_mode",
        ("mechanical_impedance", "stiffness"),
        f"another resonator hangs on the moving side{says}",
        source,
        (
            Strength(
                f"M_{n}", "{impedance}*s", text="mass of the resonator", scale="median(mass)", high=HEAVY
            ),
        ),
        add_impedance(law),
        (
            Shape(f"omega_{n}", "rad/s", "omega", 0.7, 1.5, 160, text="its resonance when its foot is held"),
            loss,
        ),
        needs=("omega",),
        common=common,
    )


def _viscous(at: Port, p: Values) -> Any:
    """A mass on a spring and a damper, 1/(1/(jωM) + 1/(K/(jω) + R)) with K = M ω_2², R = M ω_2/Q."""
    u = at["omega"] / p["omega_2"]
    link = 1 + j * u / p["Q"]
    return j * at["omega"] * p["M_2"] * link / (link - u**2)


def _grounded(at: Port, p: Values) -> Any:
    """A spring, and behind it a mass whose damper stands on the ground, 1/(jω/K + 1/(jωM + R))."""
    u = at["omega"] / p["omega_3"]
    return p["M_3"] * p["omega_3"] * (1 / p["Q_3"] + j * u) / (1 + j * u / p["Q_3"] - u**2)


def _hysteretic(at: Port, p: Values) -> Any:
    """A mass on a spring that loses energy, 1/(1/(jωM) + jω/(K (1 + jη)))."""
    u, spring = at["omega"] / p["omega_4"], 1 + j * p["eta_4"]
    return j * at["omega"] * p["M_4"] * spring / (spring - u**2)


def _within(at: Port, p: Values) -> Any:
    """Of the mass that is there the part M_5 on a spring and a damper: what `_viscous` adds, less jωM_5."""
    u = at["omega"] / p["omega_5"]
    return j * at["omega"] * p["M_5"] * u**2 / (1 + j * u / p["Q_5"] - u**2)


second_mode = _hung(
    2,
    ": a part of it, or of the housing, swings at its own frequency",
    "J. P. Den Hartog, Mechanical Vibrations (1956), sec. 3.2",
    _viscous,
    Shape("Q", "1", "1", 1.0, 500.0, 3, text="its quality factor"),
)

MODES = (
    second_mode,
    _hung(
        3,
        ", its mass rubbing at what stands still: the air in a box's port, a passive radiator",
        "L. L. Beranek, Acoustics (1954), sec. 8.14: bass-reflex enclosure",
        _grounded,
        Shape("Q_3", "1", "1", 3.0, 100.0, 3, text="its quality factor; with less it is a relaxation"),
        RARER,
    ),
    _hung(
        4,
        ", on a spring of lossy material",
        "L. Cremer, M. Heckl, B. Petersson, Structure-Borne Sound (2005), ch. 3: loss factor",
        _hysteretic,
        Shape("eta_4", "1", "1", 0.01, 0.5, 3, text="loss factor of its spring"),
        RARER,
    ),
    _hung(
        5,
        ": a part of the mass itself, which swings at its own frequency",
        second_mode.source,
        _within,
        Shape("Q_5", "1", "1", 1.0, 500.0, 3, text="its quality factor"),
    ),
)


LOSS = Shape("eta", "1", "1", 0.003, 0.5, 2, text="loss factor")


def _joint(spring: str, lossy: bool) -> Effect:
    """A joint in the moving side; before it a mass, and with `spring` also the model's own spring."""
    mark = spring + ("_eta" if lossy else "")
    s, m, eta = f"s{mark}", f"m{mark}", f"eta{spring}"

    def behind(model: Model, port: Port, p: Values) -> Model:
        w = port["omega"]
        near = j * w * p[m]
        if spring:
            near += model[next(q.equation for q in model.ports if q.kind == "stiffness")] / (j * w)
        give = j * w * p[s] / (1 + j * p[eta]) if lossy else j * w * p[s]
        return model.extend(port.equation, lambda Z: near + (Z - near) / (1 + give * (Z - near)))

    before = "a mass and the spring" if spring else "a mass"
    loss = "; loss factor: L. Cremer, M. Heckl, B. Petersson, Structure-Borne Sound (2005), ch. 3"
    return Effect(
        "contact_compliance",
        ("mechanical_impedance",),
        f"a joint gives{' and rubs' if lossy else ''}: all but {before} hangs behind a spring in series, and "
        "has a second resonance on it",
        "J. P. Den Hartog, Mechanical Vibrations (1956), sec. 3.2: two masses on a spring" + loss * lossy,
        (
            Strength(
                s, "1/({stiffness})", text="compliance", scale="1/(omega*port)", low=0.02, high=8.0,
                points=30 if lossy else 80,
            ),
        ),
        behind,
        (
            Shape(
                m, "{impedance}*s", "median(port/omega)", 0.1, 1.0, 3 if lossy else 5,
                text="mass before the joint",
            ),
            *([replace(LOSS, name=eta)] if lossy else []),
        ),
        needs=("omega",),
        also=("stiffness",) if spring else (),
        secant=True,  # the derivative at null knows nothing of the resonance
        acts=BEFORE,
    )  # fmt: skip


JOINTS = tuple(_joint(spring, lossy) for lossy in (False, True) for spring in ("", "_k"))

# -- time domain: the mass is driven by the acceleration of its foot, which runs linearly between samples ----


def _swinging(model: Model, port: Port, p: Values) -> Model:
    """Force of a mass whose motion y against its foot obeys y'' + (ω_2/Q) y' + ω_2² y = −a, each step
    exact."""
    a, unit, start = port["a"], unit_of(model, port["a"]), at_start(model, port["a"])
    Y, V, before, old = (Symbol(f"second_mode_{n}", real=True) for n in ("Y", "V", "a", "Y_old"))
    zeta = 1 / (2 * p["Q"])
    x, beta = p["omega_2"] * (port["t"] - port["t_prev"]), sqrt(1 - zeta**2)
    slope = (a - before) / x  # a' / ω_2
    held = 2 * zeta * slope  # steadily accelerated, ω_2² y = held − a, ω_2 y' = −slope
    c, s = exp(-zeta * x) * cos(beta * x), exp(-zeta * x) * sin(beta * x) / beta

    def stretch(Y: Any) -> Any:
        return Y + before - held

    states = (
        State(
            Y.name, -start, held - a + (c + zeta * s) * stretch(Y) + s * (V + slope), unit=unit, text="ω_2² y"
        ),
        State(V.name, 0, -slope - s * stretch(old) + (c - zeta * s) * (V + slope), unit=unit, text="ω_2 y'"),
        State(old.name, -start, Y, unit=unit, text="ω_2² y, for the next sample"),
        State(before.name, start, a, unit=unit, text="acceleration of the foot, for the next sample"),
    )
    return model.extend(port.equation, lambda F: F - p["M_2"] * (Y + V / p["Q"]), statements=states)


swinging_mass = Effect(
    "second_mode",
    ("force",),
    second_mode.says,
    second_mode.source,
    (Strength("M_2", "{port}/({a})", text="mass of the resonator"),),
    _swinging,
    (
        Shape("omega_2", "rad/s", "omega", 3.0, 1.5, 16, text="its resonance when its foot is held"),
        Shape("Q", "1", "1", 3.0, 50.0, 3, text="its quality factor"),
    ),
    needs=("a", "t", "t_prev"),
)

EFFECTS = (*MODES, *JOINTS, swinging_mass)
