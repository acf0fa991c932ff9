"""Springs that lose stiffness for good the farther they move: the Mullins effect of filled elastomers."""

from collections.abc import Callable
from dataclasses import replace

from sympy import Symbol

from modelgen.effects.effect import RARER, Effect, Shape, Strength, Values, unit_of
from modelgen.effects.motion import way
from modelgen.effects.start import at_start
from modelgen.language import Abs, Max, Min, Model, Parameter, Port, State, exp, tanh

MULLINS = "L. Mullins, Rubber Chem. Technol. 42 (1969) 339"


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
        common=RARER,  # samples are worked before they are measured, farther than in a record
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
    stress_softening, stretched_softening, softening_by_peak, softening_below_peak,
    softened_on, softened_by_peak_on,
)  # fmt: skip
