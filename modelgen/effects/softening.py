"""Springs that remember how far they have moved: Payne and Mullins effect of filled elastomers."""

from typing import Any

from sympy import Symbol

from modelgen.effects.effect import Effect, Shape, Strength, Values, add, unit_of
from modelgen.language import Abs, Equation, Max, Model, Piecewise, Port, State

PAYNE = "A. R. Payne, J. Appl. Polym. Sci. 6 (1962) 57; G. Kraus, J. Appl. Polym. Sci. Appl. Polym. Symp. 39 (1984) 75"
KRAUS = 1.2  # 2m in Kraus' law: 1.1 to 1.2 for all fillers
MULLINS = "L. Mullins, Rubber Chem. Technol. 42 (1969) 339"
SOFTENS = "the stiffness falls with the amplitude of the motion, as a network of filler breaks and mends"

REVERSAL = 0.2
"""A way back of this share of the swing makes a reversal, so that noise makes none."""


def half_swing(name: str, at: Port, unit: str) -> tuple[Equation | State, ...]:
    """Statements after which the equation `name` is half the running swing, or half the one before if that was more.

    Whatever the offset and the frequency; a growing motion counts at once, a shrinking one at its next reversal.
    """
    begun, way, tip, foot, old = (Symbol(f"{name}_{n}", real=True) for n in ("begun", "way", "tip", "foot", "old"))
    turned = Equation(f"{name}_turned", Piecewise((1, way * (tip - at["z"]) > REVERSAL * Abs(tip - foot)), (0, True)))
    first, back = begun < 0.5, turned.symbol > 0.5

    def state(symbol: Any, initial: Any, update: Any, unit: str, text: str) -> State:
        return State(symbol.name, initial, update, unit=unit, text=text)

    return (
        turned,
        state(old, 0, Piecewise((at["z_prev"], first), (foot, back), (old, True)), unit, "where the swing before began"),
        state(foot, 0, Piecewise((at["z_prev"], first), (tip, back), (foot, True)), unit, "where the swing began"),
        state(way, 0, Piecewise((Piecewise((1, at["z"] >= at["z_prev"]), (-1, True)), first), (-way, back), (way, True)), "1", "its direction"),
        state(tip, 0, Piecewise((at["z"], first), (at["z"], back), (way * Max(way * tip, way * at["z"]), True)), unit, "its extreme so far"),
        state(begun, 0, 1, "1", "0 at the first sample"),
        Equation(name, Max(Abs(tip - foot), Abs(foot - old)) / 2, unit, text="amplitude of the motion"),
    )


def _payne(model: Model, port: Port, p: Values) -> Model:
    name = "payne_softening_A"
    statements = half_swing(name, port, unit_of(model, port["z"]))
    A = Symbol(name, real=True)
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
    needs=("z", "z_prev"),
)

payne_in_a_cycle = Effect(
    "payne_softening",
    ("stiffness",),
    SOFTENS,
    PAYNE,
    (Strength("k_0", "{port}", text="stiffness that large amplitudes take away"),),
    add(lambda at, p: p["k_0"] / (1 + (at["amplitude"] / p["A_c"]) ** KRAUS)),
    (Shape("A_c", "{amplitude}", "displacement", 0.1, 2.0, 6, text="amplitude that takes half of it"),),
    needs=("amplitude",),
)


def _mullins(model: Model, port: Port, p: Values) -> Model:
    from modelgen.language import exp

    name = "stress_softening_path"
    way = Abs(port["z_turn"] - port["z_prev"]) + Abs(port["z"] - port["z_turn"])
    path = State(name, 0, Symbol(name, real=True) + way, unit=unit_of(model, port["z"]), text="path travelled")
    return model.extend(port.equation, lambda k: k + p["k_0"] * exp(-path / p["s_c"]), statements=(path,))


stress_softening = Effect(
    "stress_softening",
    ("spring",),
    "the virgin material softens with the path that it has travelled, as bonds break that do not mend (Mullins)",
    MULLINS,
    (Strength("k_0", "{port}", text="stiffness that is lost for good"),),
    _mullins,
    (Shape("s_c", "{z}", "displacement", 1.0, 300.0, 8, text="path over which it falls to 1/e"),),
    needs=("z", "z_prev", "z_turn"),
)

EFFECTS = (payne_softening, payne_in_a_cycle, stress_softening)
