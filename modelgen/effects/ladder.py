"""Memories with many relaxation times, in the time domain: a ladder of Maxwell arms at fixed rates.

Arm i is a spring whose foot p_i follows z at the rate s_i; its stretch z − p_i is jω/(jω + s_i) z. The
rates are constants, s_i = s_0 e^(STEP i), so the arms depend on the record alone (computed once);
parameters enter by the arms' weights.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import exp as number_exp
from math import expm1 as number_expm1
from typing import Any

from sympy import Symbol

from modelgen.effects.effect import unit_of
from modelgen.effects.start import at_start
from modelgen.language import Equation, Model, Parameter, Port, State, cos, exp, expm1, log, pi, sin

ARMS = 14
STEP = 1.5
"""The trapezoidal rule in ln s over the power law's relaxations errs by 2 sin(πα) e^(−π²/STEP) <= 0.28 %.
Slower arms act as a spring, faster ones as a dashpot, each with a part of the outermost arm so that the
next order is right, too: the sum errs by less than 0.3 % from 4 × the lowest to 1/4 of the highest rate,
over 7.2 decades."""

BEYOND = 8
"""Arms on each side of the ladder whose weights are summed up one by one."""

MEMORY = ("z", "z_prev", "v", "t", "t_prev")
TINY = 1e-30  # keeps (1 − e^(−x))/x finite at the first sample, where no time has passed


def z_rest(unit: str) -> Parameter:
    """The constant `z_rest`: at which displacement the arms were at rest when the record began."""
    return Parameter(
        "z_rest", unit, 0.0, text="displacement at which the sample rested before the record", known=True
    )


def past(id: str) -> tuple[Parameter, Parameter]:
    """What a sample had been through before a record, two numbers of each record's own: how fast it moved,
    and where it had rested, as a sample that is strained first and recorded then."""
    moved = "1/ω² of a steady motion before the record; 0: the sample rested"
    rested = "where it rested: from z_rest, 0, to where the record begins, 1"
    return (
        Parameter(f"{id}_past", "s**2", 0.0, (0.0, float("inf")), moved),
        Parameter(f"{id}_held", "1", 0.0, (0.0, 1.0), rested),
    )


def first_foot(
    first: tuple[Any, Any], rate: Any, rest: Parameter, before: tuple[Parameter, Parameter]
) -> Any:
    """Where the foot of a Maxwell arm is at the first sample, z and v there being `first`, if the sample
    moved and rested as `before` (see `past`) says: Re(Z/(1 + jω/rate)) about the place of rest, with z = Re Z
    and v = Re jωZ."""
    (z, v), (moved, held) = first, before
    place = rest + held * (z - rest)
    return place + (z - place - v / rate) * moved / (moved + rate**-2)


def first_motion(model: Model, at: Port) -> tuple[Any, Any]:
    """z and v of a port at the first sample."""
    return at_start(model, at["z"]), at_start(model, at["v"])


def arm(name: str, rate: Any, at: Port, rest: Parameter, first: Any = None) -> State:
    """The foot of a Maxwell arm of a relaxation `rate`; `first`: where it is when a record begins (none: at
    rest).

    The stretch q = z − p obeys q' = z' − rate·q, solved exactly for z linear between samples.
    """
    x = rate * (at["t"] - at["t_prev"])
    faded = -expm1(-x)
    kept = (at["z_prev"] - Symbol(name, real=True)) * (1 - faded)
    new = (at["z"] - at["z_prev"]) * faded / (x + TINY)
    start = rest if first is None else first
    return State(name, start, at["z"] - kept - new, unit=rest.unit, text="foot of a Maxwell arm")


@dataclass(frozen=True)
class Ladder:
    """Arms at a port with variables z, z_prev, v, t, t_prev; names of what it adds to the model start with
    `id`."""

    id: str
    model: Model
    port: Port
    count: int = ARMS
    step: float = STEP
    before: tuple[Parameter, Parameter] | None = None
    """How the sample moved and where it rested before the record (`past`); none: at `rest`."""
    feet: tuple[Parameter, ...] = ()
    """Or how far from `rest` the feet are when it begins, at rates that are as far apart as these are; the
    others between them."""

    @property
    def rate(self) -> Parameter:
        """s_0. By default the ladder is right from 1.2e-3 to 2e4 rad/s."""
        text = "lowest relaxation rate of the ladder, a quarter of the lowest angular frequency"
        return Parameter(f"{self.id}_s_0", "1/s", 3e-4, (1e-12, 1e12), text, known=True)

    @property
    def rest(self) -> Parameter:
        return z_rest(unit_of(self.model, self.port["z"]))

    def stretch(self, i: int) -> Any:
        return self.port["z"] - Symbol(f"{self.id}_z{i}", real=True)

    def power_law(self, alpha: Any) -> Any:
        """(jω/unit_omega)^α z: weights (sin πα/π) step s_i^α, and geometric sums for what lies beyond the
        ladder."""
        reach = self.step * (self.count - 1)
        lowest = sin(pi * alpha) / pi * self.step * (self.rate / Symbol("unit_omega", real=True)) ** alpha
        highest = lowest * exp(alpha * reach)
        slower = [lowest / (exp((n + alpha) * self.step) - 1) for n in (0, 1)]
        faster = [highest / (exp((n - alpha) * self.step) - 1) for n in (1, 2)]
        total = self.stretch(self.count - 1)
        for i in reversed(range(self.count - 1)):  # Horner's scheme: one exponential
            total = total * exp(alpha * self.step) + self.stretch(i)
        return lowest * total + self._beyond(slower, faster)

    def _beyond(self, slower: list[Any], faster: list[Any]) -> Any:
        """What the arms beyond both ends add: Σ w and Σ w s/s_0 of the `slower` ones, Σ w s_top/s and
        Σ w (s_top/s)² of the `faster` ones."""
        top = self.rate * number_exp(self.step * (self.count - 1))
        return (
            slower[1] * self.stretch(0)
            + faster[1] * self.stretch(self.count - 1)
            + (slower[0] - slower[1]) * (self.port["z"] - self.rest)
            + (faster[0] - faster[1]) / top * self.port["v"]
        )

    def logarithm(self) -> Any:
        """ln(jω/unit_omega) z: equal weights, the power law's rule at α → 0."""
        ends = [1 / number_expm1(n * self.step) for n in (1, 2)]
        top = self.rate * number_exp(self.step * (self.count - 1))
        below = log(self.rate / Symbol("unit_omega", real=True)) / self.step - 0.5 - ends[0]
        total = (
            sum(self.stretch(i) for i in range(self.count))
            + ends[0] * self.stretch(0)
            + ends[1] * self.stretch(self.count - 1)
        )
        total += below * (self.port["z"] - self.rest) + (ends[0] - ends[1]) / top * self.port["v"]
        return self.step * total

    def relaxation(self, alpha: Any, tau: Any) -> Any:
        """x/(1 + x) z with x = (jωτ)^α, by its spectrum over ln s: sin πα/π / ((sτ)^α + (sτ)^−α + 2 cos πα).

        The rule errs by some 2 e^(−2π² (1/α − 1)/STEP), 3 % at α = 3/4. The spectrum goes on for BEYOND arms
        on both sides of the ladder, and as powers of s from there, e^(±α ln s).
        """

        def weight(i: int) -> Any:
            x = (self.rate * number_exp(self.step * i) * tau) ** alpha
            return 1 / (x + 1 / x + 2 * cos(pi * alpha))

        def beyond(edge: int, way: int, moment: int) -> Any:
            """Σ w e^(−moment STEP n), n = 1 … ∞ steps from the arm at the `edge`."""
            last = weight(edge + way * BEYOND) * number_exp(-moment * BEYOND * self.step)
            near = (
                weight(edge + way * n) * number_exp(-moment * n * self.step) for n in range(1, BEYOND + 1)
            )
            return sum(near) + last / (exp((moment + alpha) * self.step) - 1)

        total = sum(weight(i) * self.stretch(i) for i in range(self.count))
        slower = [beyond(0, -1, moment) for moment in (0, 1)]
        faster = [beyond(self.count - 1, 1, moment) for moment in (1, 2)]
        return self.step * sin(pi * alpha) / pi * (total + self._beyond(slower, faster))

    def add(self, force: Any, text: str) -> Model:
        """The model with the arms and their `force` at the port."""
        at, before = self.port, self.before or ()
        first = first_motion(self.model, at) if before else None
        arms = [self._arm(i, first) for i in range(self.count)]
        term = Equation(f"{self.id}_F", force, self.model[at.equation].unit, text=text)
        model = self.model.with_parameters(self.rate, self.rest, *before, *self.feet)
        return model.extend(
            at.equation, lambda F: F + term, statements=(*arms, term), text=f"with the {text}"
        )

    def _arm(self, i: int, first: tuple[Any, Any] | None) -> State:
        rate, foot = self.rate * number_exp(self.step * i), None
        if first is not None and self.before is not None:
            foot = first_foot(first, rate, self.rest, self.before)
        elif self.feet:
            k, part = divmod(i * (len(self.feet) - 1) / (self.count - 1), 1)
            near = self.feet[int(k) : int(k) + 2]
            foot = self.rest + sum(w * x for w, x in zip((1 - part, part), near, strict=False) if w)
        return replace(arm(f"{self.id}_z{i}", rate, self.port, self.rest, foot), ref=f"arm {i}")
