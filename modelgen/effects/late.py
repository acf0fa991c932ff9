"""Channels that are late, over time: the sample is ahead of the displacement that is shown, or behind it."""

from dataclasses import replace
from typing import Any

from sympy import And, Ne, Symbol

from modelgen.effects.clearance import inner, moved
from modelgen.effects.effect import FIRST, Apply, Strength, Values, unit_of
from modelgen.effects.motion import MOTION
from modelgen.effects.sensor import sensor_delay
from modelgen.effects.start import at_start
from modelgen.language import Abs, Equation, Model, Parameter, Piecewise, Port, State

# A late displacement makes the force early. What it will be is read off Newton's polynomial through its last
# four samples: F + τ F[1] + τ(τ + h₁) F[2] + τ(τ + h₁)(τ + h₁ + h₂) F[3], F[k] divided differences.


def _early(model: Model, port: Port, p: Values) -> Model:
    (tau,) = p.values()
    h, F = port["t"] - port["t_prev"], model[port.equation]
    before, one, two, last, last_but_one = (
        Symbol(f"early_{n}", real=True) for n in ("F", "slope", "bend", "step", "step_before")
    )

    def memory(F: Any) -> tuple[State, ...]:
        slope = (F - before) / h
        bend = Piecewise(((slope - one) / (h + last), last > 0), (0, True))
        twist = Piecewise(((bend - two) / (h + last + last_but_one), last_but_one > 0), (0, True))
        ahead = tau * (slope + (tau + h) * (bend + (tau + h + last) * twist))
        return (
            State(
                "early_y",
                0,
                ahead,
                unit=unit,
                text="how far the force goes on while the displacement is late",
            ),
            State(two.name, 0, bend, unit=f"({unit})/s**2", text="second divided difference of the force"),
            State(one.name, 0, slope, unit=f"({unit})/s", text="its first one"),
            State(last_but_one.name, 0, last, unit="s", text="step of the time before the last"),
            State(last.name, 0, h, unit="s", text="its last step"),
            State(before.name, start, F, unit=unit, text="force at the sample before"),
        )

    start, unit = at_start(model, F), F.unit
    return model.extend(port.equation, lambda F: F + Symbol("early_y", real=True), statements=memory)


early_force = replace(
    sensor_delay,
    says="the displacement is recorded later than the force",
    source="I. Newton, Methodus differentialis (1711): divided differences",
    strengths=(Strength("tau_z", "s", text="delay of the displacement"),),
    apply=_early,
    common=1.0,
)


def _shifted(later: int) -> Apply:
    """The sample moves by z + τ z' + τ² z''/2 of what is recorded (later = 1: the displacement is late) or
    with −τ (−1: the force is), and turns where that does: on a parabola between two samples, or in the same
    step as the record. At rests noise makes turns of its own, which a hysteresis remembers: there the force
    as a whole (`_early`, or a filter that is all-pass) is the better account."""

    def apply(model: Model, port: Port, p: Values) -> Model:
        z, v, z_prev, z_turn = (inner(model, port, k) for k in MOTION)
        a, h, tau = port["a"], port["t"] - port["t_prev"], later * next(iter(p.values()))
        unit, speed = unit_of(model, port["z"]), unit_of(model, port["v"])
        place, rate = z + tau * (v + tau * a / 2), v + tau * a
        symbols = [Symbol(f"shifted_{n}", real=True) for n in ("z", "v", "alike")]
        was, slope, alike = (
            Equation(f"{x.name}_before", x, u, text=f"{text} one sample before")
            for x, u, text in zip(
                symbols,
                (unit, speed, f"({speed})**2"),
                ("where the sample was", "its speed", "below 0 where it and the record went opposite ways"),
                strict=True,
            )
        )
        z_0, v_0 = (at_start(model, port[k]) for k in ("z", "v"))
        rate_0 = v_0 + tau * a
        start = z_0 + tau * (v_0 + tau * a / 2)
        states = (
            State(symbols[0].name, start, place, unit=unit, text="where the sample is"),
            State(symbols[1].name, rate_0, rate, unit=speed, text="its speed"),
            State(symbols[2].name, v_0 * rate_0, v * rate, unit=alike.unit, text=alike.text),
        )
        # of two turns that belong together the sample's is the first one or the second
        first, second = (v * rate < 0, alike.symbol >= 0), (v * rate >= 0, alike.symbol < 0)
        alone = And(slope.symbol * rate < 0, *(first if later > 0 else second))
        still = Parameter("shifted_still", speed, 1e-12, (1e-15, 1.0), "next to no speed", known=True)
        beyond = slope.symbol * Abs(slope.symbol) * h / (Abs(slope.symbol) + Abs(rate) + still) / 2
        together = And(Ne(z_turn, z_prev), v * rate >= 0, alike.symbol >= 0)
        turn = Piecewise((was.symbol + beyond, alone), (z_turn, together), (was.symbol, True))
        motion = {"z": place, "v": rate, "z_prev": was.symbol, "z_turn": turn}
        return moved(model.with_parameters(still), port, (was, slope, alike, *states), motion)

    return apply


late_displacement = replace(
    early_force,
    kinds=("displacement",),
    source="B. Taylor, Methodus incrementorum (1715); exact of a Butterworth filter of second order, "
    "1 + jωτ + (jωτ)²/2",
    strengths=(Strength("tau_d", "s", text="delay of the displacement"),),
    apply=_shifted(1),
    needs=(*MOTION, "a", "t", "t_prev"),
    acts=FIRST,  # others get the motion as it was shifted
)

late_force = replace(
    late_displacement,
    says="the force is recorded later than the displacement",
    strengths=(Strength("tau_b", "s", text="delay of the force"),),
    apply=_shifted(-1),
    common=sensor_delay.common,
)

EFFECTS = (early_force, late_displacement, late_force)
