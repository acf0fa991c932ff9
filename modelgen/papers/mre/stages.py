"""The MRE paper's estimation of the modified Dahl model in four stages (Fig. 14), on a record of t, z, F.

Stage 1 takes amplitude, frequency, time shift and offset from the record, 2 the best of 100 random sets, 3
the best of 10⁵ random changes, 4 least squares. J_e (14) is the rms of F_r − F_m over one cycle; J_es (15) is
scaled by s_c = (|sin 2πft| + 1)/2. As printed s_c stands beside the squared error ("outside"); the published
tables follow only with s_c inside the square ("inside", J_es² = mean (s_c (F_r − F_m))²).
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Literal

import numpy as np

from modelgen.codegen import Function, build
from modelgen.errors import InputError
from modelgen.fit import GaussNewton
from modelgen.fit.experiment import Experiment, experiment
from modelgen.fit.method import Method
from modelgen.fit.problem import Problem
from modelgen.fit.random import RandomChanges, RandomSets
from modelgen.fit.series import make_series
from modelgen.fit.whitener import Whitener
from modelgen.models.modified_dahl import modified_dahl
from modelgen.recordings import Case, Noise, Recording

Array = np.ndarray[Any, np.dtype[np.float64]]
Reading = Literal["inside", "outside"]
FOUR = ("k_D", "c_D", "h_D", "rho")
RANGES = {"k_D": (0.0, 1.2), "c_D": (0.0, 1.8), "h_D": (0.0, 0.7), "rho": (1.0, 2.0)}
"""Of stage 2. Later stages leave them: signs alone are kept."""
LATER = {"k_D": (0.0, 1e3), "c_D": (0.0, 1e3), "h_D": (0.0, 1e3), "rho": (1e-3, 1e3)}
UNEVEN = 0.01  # part of a time step
WINDOW = 20  # samples of the moving average (sec. 3.3)


@dataclass(frozen=True)
class Cycle:
    """What stage 1 finds: amplitude [mm], frequency [Hz], offset [N], time shift [s], and the force of one
    cycle F (n,) at t (n,), brought to z_D = −A cos 2πft."""

    A: float
    f: float
    F_0: float
    shift: float
    t: Array
    F: Array


@dataclass(frozen=True)
class StageFound:
    """What a stage found: k_D, c_D, h_D, ρ by name, J_e and J_es [N], and how long it took [s]."""

    values: Mapping[str, float]
    J_e: float
    J_es: float
    seconds: float


@dataclass(frozen=True)
class Estimated:
    """Stage 1, and stages 2 to 4."""

    cycle: Cycle
    seconds: float
    stages: tuple[StageFound, StageFound, StageFound]


def moving_average(x: Array, window: int = WINDOW) -> Array:
    """Mean of `window` samples around each, fewer at the ends: shape (n,)."""
    total = np.concatenate([[0.0], np.cumsum(x)])
    at = np.arange(x.size)
    low, high = np.maximum(at - window // 2, 0), np.minimum(at - window // 2 + window, x.size)
    return np.asarray((total[high] - total[low]) / (high - low))


def first_stage(t: Array, z: Array, F: Array, samples: int = 2000) -> Cycle:
    """Stage 1: A_zD = (max − min)/2, f by the autocorrelation of z, the shift of z against −A cos 2πft by
    their cross-correlation, F_0 by the mean of F over one cycle.

    Raises InputError for few samples, for t not in equal steps, and for less than two cycles.
    """
    if t.size < 2 * WINDOW:
        raise InputError(f"{t.size} samples, at least {2 * WINDOW} wanted")
    dt = (t[-1] - t[0]) / (t.size - 1)
    if np.max(np.abs(np.diff(t) - dt)) > UNEVEN * dt:
        raise InputError("the samples are not in equal steps of time, which a correlation wants")
    z, F = moving_average(z), moving_average(F)
    A = float(np.ptp(z)) / 2
    period = _period(z - z.mean()) * dt
    wave = np.exp(2j * np.pi * (t - t[0]) / period)
    whole = slice(0, round(int((t[-1] - t[0]) / period) * period / dt))
    # the cross-correlation with −cos is greatest where its phase at the fundamental is that of the record
    phase = float(np.angle(-np.sum((z[whole] - z[whole].mean()) * wave[whole].conj())))
    shift = (-phase / (2 * np.pi) * period) % period
    at = np.linspace(0.0, period, samples, endpoint=False)
    cycle = np.interp(t[0] + shift + at, t, F)
    return Cycle(A, 1 / period, float(cycle.mean()), shift, at, cycle)


def _period(z: Array) -> float:
    """In samples: where the normalised autocorrelation, after it was negative, first has its maximum of 1.

    Normalised by the parts that overlap, it has no bias by the ends of the record.
    """
    n, square = z.size, np.concatenate([[0.0], np.cumsum(z**2)])
    lags = np.arange(n // 2 + 1)
    product = np.fft.irfft(np.abs(np.fft.rfft(z, 2 * n)) ** 2)[lags]
    r = product / np.sqrt(square[n - lags] * (square[n] - square[lags]))
    after = int(np.argmax(r < 0))
    k = after + int(np.argmax(r[after : 5 * after]))
    wide = max(after // 8, 1)  # the top is flat: a parabola through a sixteenth of a cycle
    if not r[after] < 0 or k + wide >= r.size:
        raise InputError("less than two cycles of the displacement, which an autocorrelation wants")
    at = np.arange(max(k - wide, 0), min(k + wide + 1, r.size))
    a, b, _ = np.polyfit(at - k, r[at], 2)
    return float(k - b / (2 * a))


def scale(cycle: Cycle) -> Array:
    """s_c (15) at each sample of the cycle."""
    return np.asarray(0.5 * (np.abs(np.sin(2 * np.pi * cycle.f * cycle.t)) + 1))


@cache
def function() -> Function:
    """The model with derivatives by the four parameters."""
    return build(modified_dahl, FOUR, wait=True)


def fitted_to(cycle: Cycle) -> Experiment:
    """The cycle as an experiment with unit weights; r(0) = −1 (sec. 4)."""
    w = 2 * np.pi * cycle.f
    z, v = -cycle.A * np.cos(w * cycle.t), cycle.A * w * np.sin(w * cycle.t)
    inputs = {"t": cycle.t, "z": z, "v": v, "a": w**2 * -z}
    known = {"F_0": cycle.F_0, "r_0": -1.0}
    record = Recording("cycle", None, "fit", inputs, {"F": cycle.F})
    case = Case(None, modified_dahl.id, (record,), (), known, LATER, Noise(sigma={"F": 1.0}))
    return experiment(modified_dahl, case, [make_series(modified_dahl, case, record)], function())


def weighted(ex: Experiment, weight: Array) -> Problem:
    """The problem whose r·r is the sum of squares of weight × error."""
    return ex.problem(whiteners=[Whitener(weight[None, :])])


def estimate(
    t: Array,
    z: Array,
    F: Array,
    seed: int = 0,
    reading: Reading = "inside",
    samples: int = 2000,
    changes: int = 100_000,
) -> Estimated:
    """All four stages on a record of t [s], z [mm], F [N] (n,) with two cycles at least, fitted at `samples`
    points of a cycle; `changes`, of stage 3, may be 0. Raises InputError as `first_stage` does."""
    began = time.perf_counter()
    cycle = first_stage(t, z, F, samples)
    ex = fitted_to(cycle)
    s_c = scale(cycle)
    merit = weighted(ex, s_c if reading == "inside" else np.sqrt(s_c))
    first = time.perf_counter() - began
    low, high = (np.array([RANGES[n][k] for n in merit.names]) for k in (0, 1))
    rng = np.random.default_rng(seed)
    in_ranges = replace(merit, lower=low, upper=high, start=(low + high) / 2)
    two = _stage(ex, merit, RandomSets(), in_ranges, in_ranges.start, rng)
    three = _stage(ex, merit, RandomChanges(changes), merit, _point(merit, two), rng) if changes else two
    # lsqcurvefit took the weighted force: J_e of M1 rises in stage 4, as no unweighted fit could make it
    four = _stage(ex, merit, GaussNewton(), merit, _point(merit, three), rng)
    return Estimated(cycle, first, (two, three, four))


def _point(problem: Problem, stage: StageFound) -> Array:
    return np.array([stage.values[n] for n in problem.names])


def _stage(
    ex: Experiment, merit: Problem, method: Method, problem: Problem, start: Array, rng: Any
) -> StageFound:
    began = time.perf_counter()
    theta = method.run(problem, start, seed=rng).theta
    seconds = time.perf_counter() - began
    error = ex.raw(theta, 0)[0]
    return StageFound(
        dict(zip(merit.names, theta.tolist(), strict=True)),
        float(np.sqrt(np.mean(error**2))),
        float(np.sqrt(merit.value(theta) / error.size)),
        seconds,
    )


def quality(error: Array, s_c: Array, reading: Reading) -> float:
    """J_es (15) of an error F_r − F_m (n,) over one cycle, in its unit."""
    return float(np.sqrt(np.mean((s_c * error) ** 2 if reading == "inside" else s_c * error**2)))
