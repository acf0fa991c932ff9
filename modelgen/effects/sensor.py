"""The measuring chain: channels that are late, one that loses the sign, one that creeps."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from sympy import Rational, Symbol

from modelgen.effects.effect import ANY, RARER, Apply, Effect, Shape, Strength, Values, change
from modelgen.effects.start import at_start
from modelgen.language import Abs, Max, Model, Port, State, cos, exp, j, sin, sqrt

LATE = "one channel is recorded later than the other"
LAG = "the channel that shows the force, or what else was measured, has a low-pass filter"
FILTER = "first-order filter, e.g. A. V. Oppenheim, A. S. Willsky, Signals and Systems (1997), sec. 6.5"

delay_of_response = Effect(
    "sensor_delay",
    ("sensor", "terminals"),
    LATE,
    "Fourier's shift theorem",
    (Strength("tau", "s", bounds=ANY, text="delay"),),
    change(lambda Z, at, p: Z * exp(-j * at["omega"] * p["tau"])),
    needs=("omega",),
)

lag_of_response = Effect(
    "force_sensor_lag",
    ("sensor",),
    LAG,
    FILTER,
    (Strength("tau", "s", text="time constant"),),
    change(lambda K, at, p: K / (1 + j * at["omega"] * p["tau"])),
    needs=("omega",),
)

SECOND_ORDER = (
    "the channel that shows the force, or what else was measured, has a low-pass filter of second order, or "
    "gives the mean over a window that ends now"
)
BESSEL = (
    "W. E. Thomson, Proc. IEE 96 (1949) 487: Bessel's filter 1/P, P = 1 + jωτ/2 − (ωτ)²/12; with Padé's "
    "P(−)/P for e^(−jωτ) it is the mean (1 − e^(−jωτ))/(jωτ) over τ, right to (ωτ)⁴/720"
)


def _bessel(x: Any) -> Any:
    return 1 + x / 2 + x**2 / 12


smoothed_response = Effect(
    "force_sensor_lag",
    ("sensor",),
    SECOND_ORDER,
    BESSEL,
    (Strength("window", "s", text="window of the mean"),),
    change(lambda K, at, p: K / _bessel(j * at["omega"] * p["window"])),
    needs=("omega",),
    common=RARER,
)

rectified_sensor = Effect(
    "rectified_sensor",
    ("sensor",),
    "the sensor shows how large the signal is and not its sign, as a counter of pulses does",
    "T. Wigren, M. Schoukens, Coupled Electric Drives Data Set and Reference Models, Uppsala Univ. (2017), "
    "sec. 2: pulse transducers that are insensitive to the sign of the speed",
    (Strength("share", "1", bounds=(0.0, 1.0), text="1 where no sign is left"),),
    change(lambda y, at, p: y + p["share"] * (Abs(y) - y)),
    needs=("t",),
)


def _creeping(model: Model, port: Port, p: Values) -> Model:
    """F + c y with τ y' = F − y, F held over a step; the cell has had its first load for long."""
    F, y = model[port.equation], Symbol("sensor_creep_y", real=True)
    kept = exp(-(port["t"] - port["t_prev"]) / p["tau"])

    def memory(shown: Any) -> tuple[State, ...]:
        update = shown + (y - shown) * kept
        return (State(y.name, at_start(model, F), update, unit=F.unit, text="what the cell has taken up"),)

    return model.extend(port.equation, lambda shown: shown + p["c"] * y, statements=memory)


sensor_creep = Effect(
    "sensor_creep",
    ("sensor",),
    "the load cell creeps: under a load its reading goes on for a while, as its spring or its glue gives",
    "K. Hoffmann, An Introduction to Stress Analysis and Transducer Design using Strain Gauges (1989), "
    "sec. 3.3: creep of measuring springs and gauges",
    (Strength("c", "1", bounds=(0.0, 0.3), text="what is added in the long run, over what is shown"),),
    _creeping,
    (Shape("tau", "s", "time", 3.0, 0.3, 4, text="time in which it is added"),),
    needs=("t", "t_prev"),
    units=("N", "N*m", "Pa"),
    common=0.3,
)

# In time, the recorded force is F − y, with y the rate of F, filtered, times τ. F is a parabola through the
# last three samples (as far apart as the last two), each step of y is exact: for τ far below the sampling
# interval F − τ dF/dt is left, and at τ = 0 F itself.

GONE = 40.0
"""Transients that are shorter than 1/GONE of a sampling interval have gone by the next sample: e^(−40) <
1e-17."""

Filter = Callable[[str, Any, Any, Any, Any], tuple[State, ...]]


def _late(id: str, states: Filter, share: float, y: tuple[tuple[str, Any], ...] = (("y", 1),)) -> Apply:
    """F less the sum `y` of so much of each of these `states`.

    They get the id, what y would be at the step's start and end if it had settled on the ramp u = τ dF/dt,
    which is u − share·τ u', what τ y' would be, and Δt/τ.
    """

    def apply(model: Model, port: Port, p: Values) -> Model:
        (tau,) = p.values()
        dt, unit = port["t"] - port["t_prev"], model[port.equation].unit
        start = at_start(model, model[port.equation])
        before = State(f"{id}_F", start, 0, unit=unit, text="force at the sample before")
        rise = State(f"{id}_rise", 0, 0, unit=unit, text="its rise to that sample")

        def memory(F: Any) -> tuple[State, ...]:
            now = F - before
            mean, bend = now / dt * tau, (now - rise) / (2 * dt) * tau  # of u, and half its change
            ramp = 2 * bend / dt * tau
            first, last = (mean + side * bend - share * ramp for side in (-1, 1))
            filtered = states(id, first, last, ramp, dt / Max(tau, dt / GONE))
            made = tuple(replace(s, unit=unit) for s in filtered)
            return (*made, replace(rise, update=now), replace(before, update=F))

        kept = sum(part * Symbol(f"{id}_{name}", real=True) for name, part in y)
        return model.extend(port.equation, lambda F: F - kept, statements=memory)

    return apply


def _low_pass(id: str, first: Any, last: Any, ramp: Any, x: Any) -> tuple[State, ...]:
    """τ y' + y = τ F'."""
    y = Symbol(f"{id}_y", real=True)
    return (State(y.name, 0, last + (y - first) * exp(-x), text="what the filter keeps back"),)


def _all_pass(id: str, first: Any, last: Any, ramp: Any, x: Any) -> tuple[State, ...]:
    """τ² y''/12 + τ y'/2 + y = τ F': F − y is F by Padé's (2, 2) approximation of e^(−jωτ), right to
    (ωτ)⁵/720."""
    y, y_rate, old = (Symbol(f"{id}_{n}", real=True) for n in ("y", "rate", "old"))
    fading = exp(-3 * x)
    c, s = fading * cos(sqrt(3) * x), fading * sin(sqrt(3) * x) / sqrt(3)
    off = y_rate - ramp
    return (
        State(y.name, 0, last + (c + 3 * s) * (y - first) + s * off, text="force less what is shown late"),
        State(y_rate.name, 0, ramp - 12 * s * (old - first) + (c - 3 * s) * off, text="τ times its rate"),
        State(old.name, 0, y, text="its value, for the next sample"),
    )


sensor_delay = Effect(
    "sensor_delay",
    ("sensor",),
    LATE,
    "H. Padé, Ann. Sci. ENS 9 (1892); G. H. Golub, C. F. Van Loan, Matrix Computations, sec. 9.3",
    (Strength("tau", "s", text="delay of the force"),),
    _late("sensor_delay", _all_pass, 0.5),
    needs=("t", "t_prev"),
    common=2.0,
)

force_sensor_lag = Effect(
    "force_sensor_lag",
    ("sensor",),
    LAG,
    FILTER,
    (Strength("tau", "s", text="time constant"),),
    _late("force_sensor_lag", _low_pass, 1.0),
    needs=("t", "t_prev"),
)

# With z the all-pass's y, P z = τ F', the mean F/P is F − (P − 1) F/P = F − (z/2 + τ z'/12).

smoothed_force = replace(
    smoothed_response,
    apply=_late("force_sensor_lag", _all_pass, 0.5, (("y", Rational(1, 2)), ("rate", Rational(1, 12)))),
    needs=("t", "t_prev"),
)

EFFECTS = (
    delay_of_response, lag_of_response, smoothed_response, sensor_delay, force_sensor_lag, smoothed_force,
    rectified_sensor, sensor_creep,
)  # fmt: skip
