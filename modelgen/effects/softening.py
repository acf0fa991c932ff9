"""Springs that remember how far they have moved: Payne and Mullins effect of filled elastomers."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from sympy import Symbol

from modelgen.effects.effect import Effect, Shape, Strength, Values, add, at_start, unit_of
from modelgen.errors import InputError
from modelgen.language import (
    Abs,
    Input,
    Max,
    Min,
    Model,
    Parameter,
    Port,
    State,
    amplitude_of,
    exp,
    j,
    quadrature_of,
    sqrt,
    tanh,
)

PAYNE = "A. R. Payne, J. Appl. Polym. Sci. 6 (1962) 57; G. Kraus, Appl. Polym. Symp. 39 (1984) 75"
KRAUS = 1.6  # 2m in Kraus' law: 1.1 to 1.2 for carbon black, 2 in the form that is often used
MULLINS = "L. Mullins, Rubber Chem. Technol. 42 (1969) 339"
SOFTENS = "the stiffness falls with the amplitude of the motion, as a network of filler breaks and mends"


def moved_input(model: Model) -> Input:
    """The recorded displacement of a time model."""
    rate = moved_rate(model)
    return next(i for i in model.inputs if rate.derived and i.name == rate.derived[1])


def moved_rate(model: Model) -> Input:
    """The rate of the recorded displacement of a time model. Raises InputError where none is recorded."""
    rates = [i for i in model.inputs if i.derived and i.derived[0] == "rate"]
    if not rates:
        raise InputError(f"model '{model.id}' has no input that is the rate of another")
    return rates[0]


def way(port: Port) -> Any:
    """The way there and back since the sample before."""
    return Abs(port["z_turn"] - port["z_prev"]) + Abs(port["z"] - port["z_turn"])


def _payne(model: Model, port: Port, p: Values) -> Model:
    A = amplitude_of(moved_input(model))
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
    moved = moved_input(model)
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
    softer = p["k_l"] / (1 + (peak.symbol / p["A_l"]) ** p["n_l"])
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


def _mullins(model: Model, port: Port, p: Values, left: Parameter | float = 1) -> Model:
    name = f"stress_softening_by_path{'' if left == 1 else '_on'}"
    whole = State(name, left, Symbol(name, real=True) * exp(-way(port) / p["s_c"]), text="share not lost yet")
    return model.extend(port.equation, lambda k: k + p["k_0"] * whole, statements=(whole,))


stress_softening = Effect(
    "stress_softening",
    ("spring",),
    "the virgin material softens with the path that it has travelled, as bonds break that do not mend "
    "(Mullins)",
    MULLINS,
    (Strength("k_0", "{port}", text="stiffness that is lost for good"),),
    _mullins,
    (Shape("s_c", "{z}", "displacement", 1.0, 300.0, 8, text="path over which it falls to 1/e"),),
    needs=("z", "z_prev", "z_turn"),
)


def _stretched(model: Model, port: Port, p: Values) -> Model:
    """What is left of k_m is exp(−(s/s_m)^m) after a way s."""
    name = Symbol("stress_softening_way", real=True)
    gone = State(name.name, 0, name + way(port), unit=unit_of(model, port["z"]), text="way so far")
    left = exp(-((gone.symbol / p["s_m"] + START) ** p["m"]))
    return model.extend(port.equation, lambda k: k + p["k_m"] * left, statements=(gone,))


START = 1e-9  # the power's derivative by m stays finite where the way begins

stretched_softening = replace(
    stress_softening,
    says="the virgin material softens with the path that it has travelled, fast at first and ever slower, as "
    "bonds of many strengths break that do not mend (Mullins)",
    source=MULLINS + "; stretched exponential: R. Kohlrausch, Ann. Phys. 91 (1854) 179",
    strengths=(replace(stress_softening.strengths[0], name="k_m"),),
    apply=_stretched,
    shapes=(
        replace(stress_softening.shapes[0], name="s_m", points=4),
        Shape("m", "1", "1", 0.3, 0.9, 2, log=False, text="1 for bonds of one strength"),
    ),
    common=0.5,
)


def _peak(model: Model, port: Port, p: Values, left: Parameter | float = 1) -> Model:
    """What is left of k_p is exp(−z_max/z_c), and less where a record begins with less."""
    name = f"stress_softening_by_peak{'' if left == 1 else '_on'}"
    start = left * exp(-Abs(at_start(model, port["z"])) / p["z_c"])
    held = Min(Symbol(name, real=True), exp(-Abs(port["z"]) / p["z_c"]))
    whole = State(name, start, held, text="share not lost yet")
    return model.extend(port.equation, lambda k: k + p["k_p"] * whole, statements=(whole,))


softening_by_peak = Effect(
    "stress_softening",
    ("spring",),
    "the virgin material softens up to the greatest deflection that it has seen (Mullins)",
    MULLINS,
    (Strength("k_p", "{port}", text="stiffness that is lost for good"),),
    _peak,
    (Shape("z_c", "{z}", "displacement", 0.1, 2.0, 5, text="deflection by which it falls to 1/e"),),
    needs=("z",),
)


def _reloaded(model: Model, port: Port, p: Values) -> Model:
    """Stiffness times 1 − q tanh((z_max² − z²)/w²): whole where the greatest deflection is reached again."""
    name = "stress_softening_reached"
    start, unit = Abs(at_start(model, port["z"])), unit_of(model, port["z"])
    peak = State(
        name, start, Max(Symbol(name, real=True), Abs(port["z"])), unit=unit, text="greatest deflection"
    )
    lost = p["q"] * tanh((peak.symbol**2 - port["z"] ** 2) / p["w"] ** 2)
    return model.extend(port.equation, lambda k: k * (1 - lost), statements=(peak,))


softening_below_peak = Effect(
    "stress_softening",
    ("spring",),
    "the virgin material is softer below the greatest deflection that it has seen, and itself again where it "
    "gets there (Mullins)",
    "R. W. Ogden, D. G. Roxburgh, Proc. R. Soc. A 455 (1999) 2861; A. Dorfmann, R. W. Ogden, Int. J. Solids "
    "Struct. 41 (2004) 1855: η = 1 − tanh((W_m − W)/m)/r with W ∝ z²",
    (Strength("q", "1", bounds=(0.0, 1.0), text="share of the stiffness that is lost far below the peak"),),
    _reloaded,
    (Shape("w", "{z}", "displacement", 0.1, 2.0, 4, text="deflection that tells how far below"),),
    needs=("z",),
)

# -- the same after motion that was not recorded -------------------------------------------------------------
# but not softening_below_peak: with its peak at will it is a cubic spring

LEFT = Parameter(
    "stress_softening_left",
    "1",
    0.5,
    (0.0, 1.0),
    "share of what can be lost that earlier motion has left when the record begins",
)


def _after_motion(law: Effect, says: str) -> Effect:
    """The law for a material that has moved before each record, no one knows how far: a law of its own, as a
    virgin one needs not be asked for its past and its strength is known."""
    quantities: tuple[Strength | Shape, ...] = (*law.strengths, *law.shapes)
    own = {q.name: f"{q.name}_on" for q in quantities}
    apply: Callable[..., Model] = law.apply

    def applied(model: Model, port: Port, p: Values) -> Model:
        return apply(model.with_parameters(LEFT), port, {k: p[n] for k, n in own.items()}, LEFT)

    return replace(
        law,
        says=says,
        apply=applied,
        strengths=tuple(replace(q, name=own[q.name]) for q in law.strengths),
        shapes=tuple(replace(q, name=own[q.name]) for q in law.shapes),
        instead=("payne_softening",),
        common=0.5,
    )


softened_on = _after_motion(
    stress_softening,
    "the material softens with the path that it travels, as bonds break that do not mend (Mullins); some had "
    "broken before the record",
)
softened_by_peak_on = _after_motion(
    softening_by_peak,
    "the material softens up to the greatest deflection that it has seen, be it before the record (Mullins)",
)

EFFECTS = (
    payne_softening, payne_followed, payne_of_late, payne_in_a_cycle, payne_with_loss,
    stress_softening, stretched_softening, softening_by_peak, softening_below_peak,
    softened_on, softened_by_peak_on,
)  # fmt: skip
