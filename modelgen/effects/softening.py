"""Springs that remember how far they have moved: Payne and Mullins effect of filled elastomers."""

from sympy import Symbol

from modelgen.effects.effect import Effect, Shape, Strength, Values, add, at_start, unit_of
from modelgen.language import Abs, Equation, Max, Model, Piecewise, Port, State, exp

PAYNE = "A. R. Payne, J. Appl. Polym. Sci. 6 (1962) 57; G. Kraus, Appl. Polym. Symp. 39 (1984) 75"
KRAUS = 1.2  # 2m in Kraus' law: 1.1 to 1.2 for all fillers
MULLINS = "L. Mullins, Rubber Chem. Technol. 42 (1969) 339"
SOFTENS = "the stiffness falls with the amplitude of the motion, as a network of filler breaks and mends"

REVERSAL = 0.2
"""A way back of this share of the swing makes a reversal, so that noise makes none."""


def half_swing(name: str, model: Model, at: Port) -> tuple[Equation | State, ...]:
    """Statements after which the equation `name` is half the running swing, or half the one before if more.

    Whatever the offset and the frequency; a growing motion counts at once, a shrinking one when it turns.
    """
    z, unit, start = at["z"], unit_of(model, at["z"]), at_start(model, at["z"])
    way, tip, foot, old = (Symbol(f"{name}_{n}", real=True) for n in ("way", "tip", "foot", "old"))
    turned = Equation(
        f"{name}_turned", Piecewise((1, way * (tip - z) > REVERSAL * Abs(tip - foot)), (0, True))
    )
    back = turned.symbol > 0.5
    further = Piecewise((z, back), (way * Max(way * tip, way * z), True))
    return (
        turned,
        State(
            old.name,
            start,
            Piecewise((foot, back), (old, True)),
            unit=unit,
            text="where the swing before began",
        ),
        State(
            foot.name, start, Piecewise((tip, back), (foot, True)), unit=unit, text="where the swing began"
        ),
        State(way.name, 1, Piecewise((-way, back), (way, True)), text="its direction"),
        State(tip.name, start, further, unit=unit, text="how far it has come"),
        Equation(name, Max(Abs(tip - foot), Abs(foot - old)) / 2, unit, text="amplitude of the motion"),
    )


def _payne(model: Model, port: Port, p: Values) -> Model:
    A = Symbol("payne_softening_A", real=True)
    statements = half_swing(A.name, model, port)
    return model.extend(
        port.equation, lambda k: k + p["k_0"] / (1 + (A / p["A_c"]) ** KRAUS), statements=statements
    )


payne_softening = Effect(
    "payne_softening",
    ("spring",),
    SOFTENS,
    PAYNE,
    (Strength("k_0", "{port}", text="stiffness that large amplitudes take away"),),
    _payne,
    (Shape("A_c", "{z}", "displacement", 0.1, 2.0, 6, text="amplitude that takes half of it"),),
    needs=("z",),
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


def _mullins(model: Model, port: Port, p: Values) -> Model:
    name = "stress_softening_path"
    way = Abs(port["z_turn"] - port["z_prev"]) + Abs(port["z"] - port["z_turn"])
    path = State(
        name, 0, Symbol(name, real=True) + way, unit=unit_of(model, port["z"]), text="path travelled"
    )
    return model.extend(port.equation, lambda k: k + p["k_0"] * exp(-path / p["s_c"]), statements=(path,))


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


def _peak(model: Model, port: Port, p: Values) -> Model:
    z, name = Abs(port["z"]), "stress_softening_peak"
    start, unit = Abs(at_start(model, port["z"])), unit_of(model, port["z"])
    peak = State(name, start, Max(Symbol(name, real=True), z), unit=unit, text="greatest deflection so far")
    return model.extend(port.equation, lambda k: k + p["k_p"] * exp(-peak / p["z_c"]), statements=(peak,))


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

EFFECTS = (payne_softening, payne_in_a_cycle, stress_softening, softening_by_peak)
