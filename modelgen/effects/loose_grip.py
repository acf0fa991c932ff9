"""A sample that is held with play: it springs back by itself, and is let go where its force changes sign."""

from typing import Any

from sympy import Symbol

from modelgen.effects.clearance import within
from modelgen.effects.effect import UPON, Effect, Shape, Strength, Values
from modelgen.effects.start import at_start, undeflected
from modelgen.language import Abs, Model, Piecewise, Port, State, exp

# Driven at z, the sample is at z + u, |u| ≤ g: at one side of the gap or the other while it is pushed, and
# between them where its force F(z) + K u + c u' is zero. With y = K u, d = K g, T = c/K that is
# T y' = −(F(z) + y) within ±d; the force is F(z) + y while it is pushed, else 0. F is held over a step of y;
# friction follows z, which differs from its own way by 2 g at most. An offset, the force where nothing is
# deflected, is the sensor's, and stays when the sample is let go.


TOUCH = 1 - 1e-9  # of the gap, but for rounding


def _grip(model: Model, port: Port, p: Values) -> Model:
    d, unit = p["d"], model[port.equation].unit
    y = Symbol("loose_grip_y", real=True)
    offset = undeflected(model, port)
    first = offset - at_start(model, model[port.equation])
    start = (Abs(first + d) - Abs(first - d)) / 2  # within ±d; cases of cases, as there are in it, multiply
    fading = exp(-(port["t"] - port["t_prev"]) / p["T"])

    def memory(F: Any) -> tuple[State, ...]:
        update = within((y + F - offset) * fading - F + offset, d)
        return (State(y.name, start, update, unit=unit, text="what the gap takes off the force"),)

    return model.extend(
        port.equation, lambda F: Piecewise((F + y, Abs(y) >= TOUCH * d), (offset, True)), statements=memory
    )


loose_grip = Effect(
    "backlash",
    ("force",),
    "the sample is held with play and springs back by itself: where its force changes sign it is let go, and "
    "nothing is felt until it lies against the other side",
    "R. D. Mindlin, Bell Syst. Tech. J. 24 (1945) 353: items in packages with clearance; here of spring and "
    "dashpot",
    (Strength("d", "{port}", text="stiffness times half of the play", scale="port", low=0.005, high=0.3),),
    _grip,
    (Shape("T", "s", "time", 0.1, 1.0, 4, text="dashpot over stiffness"),),
    needs=("t", "t_prev"),
    secant=True,
    common=0.5,
    acts=UPON,
)

EFFECTS = (loose_grip,)
