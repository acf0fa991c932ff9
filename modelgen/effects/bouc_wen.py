"""Friction that comes into slip, and goes back from it, by Bouc's and Wen's law instead of Dahl's."""

from typing import Any

from sympy import Symbol

from modelgen.effects.effect import RARER, Effect, Strength, Values
from modelgen.effects.motion import partner
from modelgen.effects.start import at_start
from modelgen.language import Abs, Equation, Max, Model, Piecewise, Port, State, Statement, exp, log

PARTS = 2
"""Steps of a monotonic displacement."""
NONE = 1e-12
"""What is nothing beside a state between −1 and 1."""
LEAST = 1e-30
"""Of a state whose powers have derivatives."""


def _bouc_wen(model: Model, port: Port, p: Values) -> Model:
    """The friction's state r by dr/dz = ρ (1 − |r|ⁿ (β sgn(v r) + γ)) with β + γ = 1, and β − γ = q.

    With u = r sgn v, and y = −ln(1 − u), dy = ρ |dz| g(u): Dahl's law is g = 1, for which Runge's and Kutta's
    scheme is exact. A model with Dahl's exponent b keeps it: the law's bracket to the power of b.
    """
    h, rho, b, F_r = (_quantity(model, port, kind) for kind in ("friction", "slip", "dahl", "force"))
    old = port["r"]
    name = "bouc_wen_r"

    def rate(y: Any, left: Any) -> Any:
        """dy by ρ |dz|; left: exp(−y), which is 1 − u."""
        size = (Abs(1 - left) + LEAST) ** p["n"]
        slope = Piecewise((1 - size, left < 1), (1 + p["q"] * size, True)) / _no_less(left)
        return exp(-(b - 1) * y) * Piecewise((p["n"], left < 1e-7), (slope, True)) ** b

    def stroke(r: Any, dz: Any, mark: str) -> tuple[list[Equation], Any]:
        """Equations of the way from state r by a displacement dz, and the state there. Short ones: what
        stands in a larger one is looked through again and again."""
        way = Equation(f"{name}_{mark}", Piecewise((1, dz >= 0), (-1, True)))
        length = Equation(f"{name}_{mark}_step", rho * Abs(dz) / PARTS)
        done = [way, length, Equation(f"{name}_{mark}_0", -log(_no_less(1 - way.symbol * r)))]
        step = length.symbol
        for k in range(PARTS):
            y = done[-1].symbol
            slopes: list[Any] = []
            for part in (0, 1, 1, 2):
                stage = f"{name}_{mark}_{k}_{len(slopes)}"
                at = Equation(f"{stage}_y", y + step * slopes[-1] * part / 2 if slopes else y)
                left = Equation(f"{stage}_left", exp(-at.symbol))
                done += [at, left, Equation(stage, rate(at.symbol, left.symbol))]
                slopes.append(done[-1].symbol)
            one, two, three, four = slopes
            done.append(Equation(f"{name}_{mark}_{k + 1}", y + step * (one + 2 * two + 2 * three + four) / 6))
        return done, way.symbol * (1 - exp(-done[-1].symbol))

    to_turn, turned = stroke(Symbol(name, real=True), port["z_turn"] - port["z_prev"], "turn")
    turn = Equation(f"{name}_turned", turned, text="friction state where it turns")
    from_turn, now = stroke(turn.symbol, port["z"] - port["z_turn"], "end")
    r = State(name, at_start(model, old), now, text="friction state by Bouc and Wen")
    statements: tuple[Statement, ...] = (*to_turn, turn, *from_turn, r)
    return model.extend(F_r.name, lambda F: F + h * (r.symbol - old), statements=statements)


def _no_less(x: Any) -> Any:
    """x, no less than NONE; sympy need not find out which it is."""
    return Max(x, NONE, evaluate=False)


def _quantity(model: Model, port: Port, kind: str) -> Any:
    """What the port of this kind, or its partner of it, changes."""
    found = port if port.kind == kind else partner(model, port, kind)
    return Symbol(found.equation, real=True)


bouc_wen = Effect(
    "dahl_exponent",
    ("friction",),
    "the friction's way into slip has another shape than an exponential, and another one back from it: "
    "dr/dz = ρ(1 − |r|ⁿ(β sgn(v r) + γ)), n ≠ 1 or γ ≠ 0",
    "R. Bouc, Proc. 4th Conf. Nonlinear Oscillation (1967) 315; Y.-K. Wen, J. Eng. Mech. Div. ASCE 102 "
    "(1976) 249",
    (
        Strength("n", "1", 1.0, (0.3, 6.0), text="exponent of the state"),
        Strength("q", "1", 1.0, (-0.5, 2.0), text="β − γ: how much steeper the way back from slip is"),
    ),
    _bouc_wen,
    needs=("z", "z_prev", "z_turn", "r"),
    also=("force", "slip", "dahl"),
    common=RARER,
)

EFFECTS = (bouc_wen,)
