"""Physics in a steady cycle z = −A cos θ: forces that are no complex stiffness, and channels that are late.

A force acts on the greatest force, on where that is, and on the force where z = 0 is shown; so it enters
stiffness and loss angle exactly, whatever else acts.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from modelgen.effects.damping import DRAG
from modelgen.effects.damping import TEXTBOOK as JACOBSEN
from modelgen.effects.effect import ANY, Apply, Effect, Shape, Strength, Values
from modelgen.effects.friction import DAHL, dahl_exponent, second_dahl_element
from modelgen.effects.nonlinear_spring import HARDENS, quintic_stiffness
from modelgen.effects.nonlinear_spring import TEXTBOOK as NAYFEH
from modelgen.effects.sensor import FILTER, LAG, LATE
from modelgen.language import (
    Abs,
    Implicit,
    Max,
    Min,
    Model,
    Port,
    Symbol,
    cos,
    dahl_step,
    exp,
    j,
    pi,
    powdiff,
    sin,
    tanh,
)

SLIPPED = 1e-300
"""The least 1 − r whose power is taken: for exponents below one, slip is complete at a finite way."""


@dataclass(frozen=True)
class Force:
    """A force at one phase of the cycle [N], its derivatives by z and by v there, and the energy that it
    takes up in a cycle."""

    value: Any
    stiffness: Any = 0
    damping: Any = 0
    loss: Any = 0


Law = Callable[[Port, Values, Any, Any, Any], Force]
"""law(port, p, z, v, d) → Force at displacement z and speed v; d = 1 while z grows, −1 while it falls."""


def in_the_cycle(law: Law) -> Apply:
    """An `apply` that adds a force to that of the cycle; it must be odd: F(−z, −v, −d) = −F(z, v, d)."""

    def apply(model: Model, port: Port, p: Values) -> Model:
        A, omega = port["amplitude"], port["omega"]

        def at(c: Any, s: Any, d: Any) -> Force:
            return law(port, p, -A * c, omega * A * s, d)

        theta = port["theta"]
        peak, middle = at(cos(theta), sin(theta), 1), at(port["cos_0"], port["sin_0"], port["direction_0"])
        slope = A * (peak.stiffness * sin(theta) + omega * peak.damping * cos(theta))
        root = model[theta.name]
        assert isinstance(root, Implicit)
        low, high = root.bracket
        low = Min(low, 9 * pi / 20) if peak.damping != 0 else low  # drag has its own peak at π/2
        root = replace(root, residual=root.residual + slope, bracket=(low, high))
        model = replace(model, statements=tuple(root if s.name == root.name else s for s in model.statements))
        model = model.extend(port.equation, lambda F: F + peak.value)
        model = model.extend(port["F_mid"].name, lambda F: F + middle.value)
        return model.extend(port["energy"].name, lambda E: E + peak.loss) if peak.loss != 0 else model

    return apply


def _cubic(at: Port, p: Values, z: Any, v: Any, d: Any) -> Force:
    return Force(p["k_3"] * z**3, 3 * p["k_3"] * z**2)


def _quintic(at: Port, p: Values, z: Any, v: Any, d: Any) -> Force:
    return Force(p["k_30"] * z**3 + p["k_5"] * z**5, 3 * p["k_30"] * z**2 + 5 * p["k_5"] * z**4)


def _drag(at: Port, p: Values, z: Any, v: Any, d: Any) -> Force:
    greatest = at["omega"] * at["amplitude"]
    return Force(
        p["c_2"] * v * Abs(v),
        damping=2 * p["c_2"] * Abs(v),
        loss=p["c_2"] * greatest**2 * at["amplitude"] * 8 / 3,
    )


def _second_dahl(at: Port, p: Values, z: Any, v: Any, d: Any) -> Force:
    """Dahl's force with b = 1 on the half cycle from ∓tanh(A/z_2)."""
    h, A, z_2 = p["h_2"], at["amplitude"], p["z_2"]
    r_m = tanh(A / z_2)
    u = (1 + r_m) * exp(-(A + d * z) / z_2)
    return Force(d * h * (1 - u), h * u / z_2, loss=4 * h * (A - r_m * z_2))


def _exponent(model: Model, port: Port, p: Values) -> Model:
    """The model's friction with u = 1 − r sgn v from du/dx = −ρ u^b in place of b = 1.

    The steady half cycle runs from u = 1 + r_m over 2ρA to u = 1 − r_m.
    """
    h, rho, A, b = port["h"], port["rho"], port["amplitude"], p["b"]
    r = Symbol("dahl_exponent_r_m", real=True)
    r_b = Implicit(
        r.name, dahl_step(1 + r, 2 * rho * A, b) - (1 - r), (0, 1.1), text="friction state where z turns"
    )

    def law(at: Port, p: Values, z: Any, v: Any, d: Any) -> Force:
        x = rho * (A + d * z)
        u, u_1 = dahl_step(1 + r, x, b), (1 + tanh(rho * A)) * exp(-x)
        stiffness = h * rho * (Max(u, SLIPPED) ** b - u_1)
        passed = powdiff(1 + r, Max(1 - r, SLIPPED), 2 - b)  # ρ ∫ u dz over half a cycle; 2 tanh(ρA) at b = 1
        return Force(d * h * (u_1 - u), stiffness, loss=2 * h * (2 * tanh(rho * A) - passed) / rho)

    return in_the_cycle(law)(model.before(port["theta"].name, r_b), port, p)


def _late(gain: Callable[[Any], Any]) -> Apply:
    """The force is shown as by a channel of the complex gain gain(ωτ) at the cycle's frequency."""

    def apply(model: Model, port: Port, p: Values) -> Model:
        g = gain(port["omega"] * p["tau"])
        model = model.extend(port["phase_0"].name, lambda e: e * g / Abs(g))
        for name in (port.equation, port["h_s"].name):
            model = model.extend(name, lambda F: F * Abs(g))
        return model

    return apply


cubic_in_a_cycle = Effect(
    "cubic_stiffness",
    ("cycle",),
    HARDENS,
    NAYFEH,
    (Strength("k_3", "{port}/{amplitude}**3", bounds=ANY, text="positive for a hardening spring"),),
    in_the_cycle(_cubic),
    needs=("amplitude",),
)

quintic_in_a_cycle = replace(
    quintic_stiffness,
    kinds=("cycle",),
    strengths=tuple(
        replace(q, unit="{port}/{amplitude}**" + n)
        for q, n in zip(quintic_stiffness.strengths, "35", strict=True)
    ),
    apply=in_the_cycle(_quintic),
    needs=("amplitude",),
)

quadratic_in_a_cycle = Effect(
    "quadratic_damping",
    ("cycle",),
    DRAG,
    JACOBSEN,
    (Strength("c_2", "{port}*s**2/{amplitude}**2", text="drag over speed squared"),),
    in_the_cycle(_drag),
    needs=("omega", "amplitude"),
)

second_dahl_in_a_cycle = Effect(
    "second_dahl_element",
    ("cycle",),
    second_dahl_element.says,
    DAHL + "; MRE paper, eq. 12",
    (Strength("h_2", "{port}", text="friction force of the second element"),),
    in_the_cycle(_second_dahl),
    (Shape("z_2", "{amplitude}", "1", 0.01, 3.0, 6, text="slip length 1/ρ of the second element"),),
    needs=("amplitude",),
)

exponent_in_a_cycle = Effect(
    "dahl_exponent",
    ("cycle",),
    dahl_exponent.says,
    DAHL,
    (Strength("b", "1", 1.0, (0.2, 5.0), text="exponent over that of the model"),),
    _exponent,
    needs=("amplitude", "h", "rho"),
)

delay_in_a_cycle = Effect(
    "sensor_delay",
    ("shown_cycle",),
    LATE,
    "Fourier's shift theorem",
    (Strength("tau", "s", bounds=ANY, text="delay of the force"),),
    _late(lambda x: exp(-j * x)),
    needs=("omega",),
)

lag_in_a_cycle = Effect(
    "force_sensor_lag",
    ("shown_cycle",),
    LAG,
    FILTER + "; all of the force as its fundamental",
    (Strength("tau", "s", text="time constant", scale="1/max(omega)", low=0.1, high=3.0),),
    _late(lambda x: 1 / (1 + j * x)),
    needs=("omega",),
    secant=True,  # stiffness alone, without the angle, shows it but by its square
)

EFFECTS = (
    cubic_in_a_cycle, quintic_in_a_cycle, quadratic_in_a_cycle, second_dahl_in_a_cycle, exponent_in_a_cycle,
    delay_in_a_cycle, lag_in_a_cycle,
)  # fmt: skip
