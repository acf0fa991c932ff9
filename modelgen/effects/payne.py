"""Stiffness that falls with the amplitude and comes back: the Payne effect of filled elastomers."""

from dataclasses import replace

from sympy import Symbol

from modelgen.effects.effect import Effect, Shape, Strength, Values, add, unit_of
from modelgen.effects.motion import moved_input
from modelgen.effects.start import at_start
from modelgen.language import Abs, Max, Model, Port, State, amplitude_of, exp, j, quadrature_of, sqrt

PAYNE = "A. R. Payne, J. Appl. Polym. Sci. 6 (1962) 57; G. Kraus, Appl. Polym. Symp. 39 (1984) 75"
KRAUS = 1.6  # 2m in Kraus' law: 1.1 to 1.2 for carbon black, 2 in the form that is often used
SOFTENS = "the stiffness falls with the amplitude of the motion, as a network of filler breaks and mends"


def _payne(model: Model, port: Port, p: Values) -> Model:
    A = amplitude_of(moved_input(model, port))
    ratio = Max(A.symbol / p["A_c"], SLIGHT)
    return model.extend(port.equation, lambda k: k + p["k_0"] / (1 + ratio ** p["n_0"]), inputs=(A,))


SLIGHT = 1e-6  # of the amplitude that takes half: the power's derivative by n stays finite at rest


payne_softening = Effect(
    "payne_softening",
    ("spring",),
    SOFTENS,
    PAYNE,
    (Strength("k_0", "{port}", text="stiffness that large amplitudes take away"),),
    _payne,
    (
        Shape("A_c", "{z}", "displacement", 0.1, 2.0, 5, text="amplitude that takes half of it"),
        Shape("n_0", "1", "1", 0.8, 2.2, 2, log=False, text="Kraus' exponent 2m"),
    ),
    needs=("z",),
)


def _payne_followed(model: Model, port: Port, p: Values) -> Model:
    """a' = (√(z² + ẑ²) − a)/τ with z a quarter of a cycle later, ẑ; exact for an amplitude that is constant
    between samples."""
    moved = moved_input(model, port)
    late, name = quadrature_of(moved), "payne_softening_a"
    now = sqrt(moved.symbol**2 + late.symbol**2)
    kept = exp(-(port["t"] - port["t_prev"]) / p["tau"])
    a = State(
        name,
        now,
        now + (Symbol(name, real=True) - now) * kept,
        unit=moved.unit,
        text="amplitude felt",
    )
    softer = p["k_n"] / (1 + Max(a.symbol / p["A_n"], SLIGHT) ** p["n"])
    return model.extend(port.equation, lambda k: k + softer, statements=(a,), inputs=(late,))


payne_followed = Effect(
    "payne_softening",
    ("spring",),
    "the stiffness falls with the amplitude of the motion, which the network of filler follows in its own "
    "time",
    PAYNE + "; A. Lion, Int. J. Plasticity 14 (1998) 945: the network's own relaxation",
    (Strength("k_n", "{port}", text="stiffness that large amplitudes take away"),),
    _payne_followed,
    (
        Shape("A_n", "{z}", "displacement", 0.1, 2.0, 4, text="amplitude that takes half of it"),
        Shape("n", "1", "1", 1.0, 2.2, 2, log=False, text="Kraus' exponent 2m"),
        Shape("tau", "s", "time", 1.0, 0.1, 3, text="time in which the network follows"),
    ),
    needs=("z", "t", "t_prev"),
    common=0.5,
)


def _payne_kinetic(model: Model, port: Port, p: Values) -> Model:
    """τ N' = 1 − N − (A/A_b)^n N, A = √(z² + ẑ²) with z a quarter of a cycle later, ẑ; exact for an amplitude
    that is constant between samples, from what it is in the long run at the first one's."""
    moved = moved_input(model, port)
    late, name = quadrature_of(moved), "payne_softening_N"
    broken = Max(sqrt(moved.symbol**2 + late.symbol**2) / p["A_b"], SLIGHT) ** p["n_b"]
    settled = 1 / (1 + broken)
    kept = exp(-(1 + broken) * (port["t"] - port["t_prev"]) / p["tau_b"])
    N = State(
        name, settled, settled + (Symbol(name, real=True) - settled) * kept, text="share of the network"
    )
    return model.extend(port.equation, lambda k: k + p["k_b"] * N.symbol, statements=(N,), inputs=(late,))


payne_kinetic = replace(
    payne_followed,
    says="the stiffness falls with the amplitude of the motion: a network of filler breaks the faster the "
    "larger it is, and mends at a rate of its own",
    source=PAYNE + "; G. Huber, T. A. Vilgis, Kautsch. Gummi Kunstst. 52 (1999) 102: its kinetics",
    strengths=(replace(payne_followed.strengths[0], name="k_b"),),
    apply=_payne_kinetic,
    shapes=(
        *(replace(q, name=f"{q.name[0]}_b") for q in payne_followed.shapes[:2]),
        Shape("tau_b", "s", "time", 1.0, 0.3, 3, text="time in which the network mends"),
    ),
)


def _payne_of_late(model: Model, port: Port, p: Values) -> Model:
    """a = max(|z|, a e^(−dt/τ)): the greatest deflection of late."""
    name = "payne_softening_of_late"
    z = Abs(port["z"])
    fading = Symbol(name, real=True) * exp(-(port["t"] - port["t_prev"]) / p["tau_l"])
    peak = State(
        name,
        at_start(model, z),
        Max(z, fading),
        unit=unit_of(model, port["z"]),
        text="its greatest deflection",
    )
    softer = p["k_l"] / (1 + Max(peak.symbol / p["A_l"], SLIGHT) ** p["n_l"])
    return model.extend(port.equation, lambda k: k + softer, statements=(peak,))


payne_of_late = replace(
    payne_followed,
    says="the stiffness falls with the greatest deflection of late, beyond which the network of filler mends "
    "in its own time",
    strengths=(replace(payne_followed.strengths[0], name="k_l"),),
    apply=_payne_of_late,
    shapes=(
        *(replace(q, name=f"{q.name[0]}_l") for q in payne_followed.shapes[:2]),
        Shape("tau_l", "s", "duration", 0.1, 10.0, 2, text="time in which the network mends"),
    ),
    common=0.5,
)

payne_in_a_cycle = Effect(
    "payne_softening",
    ("stiffness",),
    SOFTENS,
    PAYNE,
    (Strength("k_0", "{port}", text="stiffness that large amplitudes take away"),),
    add(lambda at, p: p["k_0"] / (1 + (at["amplitude"] / p["A_c"]) ** KRAUS)),
    (Shape("A_c", "{amplitude}", "1", 0.02, 10.0, 6, text="amplitude that takes half of it"),),
    needs=("amplitude",),
)


def _kraus(at: Port, p: Values) -> object:
    """Storage k_n/(1 + x^n), loss 2 H_n x^(n/2)/(1 + x^n) with x = A/A_n and n = 2m: contacts that break and
    mend in each cycle."""
    root = (at["amplitude"] / p["A_n"]) ** (p["n"] / 2)
    return (p["k_n"] + 2 * j * p["H_n"] * root) / (1 + root**2)


payne_with_loss = Effect(
    "payne_softening",
    ("stiffness",),
    "the stiffness falls with the amplitude of the motion, and its loss has a peak on the way, as a network "
    "of filler breaks and mends in each cycle",
    PAYNE,
    (
        Strength("k_n", "{port}", text="stiffness that large amplitudes take away"),
        Strength("H_n", "{port}", text="greatest loss stiffness of the network, at A_n"),
    ),
    add(_kraus),
    (
        Shape("A_n", "{amplitude}", "1", 0.02, 10.0, 5, text="amplitude that takes half of it"),
        Shape("n", "1", "1", 0.8, 2.2, 2, log=False, text="Kraus' exponent 2m"),
    ),
    needs=("amplitude",),
    common=0.5,
)

EFFECTS = (
    payne_softening, payne_followed, payne_kinetic, payne_of_late, payne_in_a_cycle, payne_with_loss,
)  # fmt: skip
