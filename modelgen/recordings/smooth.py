"""Smoothing on a uniform grid, with a window that adapts to the signal at each sample."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from modelgen.recordings.savgol import LocalFit, local_fit

Array = NDArray[np.float64]

EXACT = 9  # samples of the interpolating polynomial: differences of 8th order
DEGREE = 5
HALF_WIDTHS = (4, 6, 9, 13, 19, 28, 42, 64, 96, 144, 216, 324, 486, 729, 1094, 1641)
# 200 000 samples make some 10⁶ tests, so hardly one in 10⁸ may fail by chance: where a window is refused no
# wider one is tried, and the noise of a small one would look like reversals.
PEAK = 6.0  # largest excess coefficient, in standard deviations
POOL = 12  # half-width of the neighbourhood of a window that is tested together, in half-widths
SPREAD = 0.3  # standard deviation of the mean square of the some 2 POOL windows in it
POOLED = 2.5  # largest mean square excess over it, in variances
CORNER = 30.0  # sum of squares beyond the fit, in variances, from which a corner is seen in it
FAR = 8.0  # standard deviations of the noise that a path goes between turns
PACE = 0.2  # logarithm of the ratio of times between turns that go as fast
ALIKE = 2.5  # three standard deviations of the mean square excess about one turn
SWEPT, NEARBY = 3.0, 13  # steps from sample to sample, in the mean nearby, whose rounding errors are white
FUNDAMENTAL = 0.64  # amplitude of a sawtooth's first harmonic: what rounding makes of a ramp
NARROWER = 7  # samples of the interpolating polynomial before the last one
BENT = (
    20.0  # times the change from it to the last: the error at a corner of any radius up to some samples, and
)
# more than twice that, since all corners of a motion are alike, and err alike
SEEN = 5.0, 2e-4  # changes that count: in standard deviations of what noise makes, and of the greatest value


@dataclass(frozen=True)
class Smooth:
    """value: z, z', z'' per sample step; std: of their errors, what noise leaves and what the polynomials
    miss; bent: their errors at corners between the samples; all (3, n). window: half-width, (n,)."""

    value: Array
    std: Array
    bent: Array
    window: Array


def smooth(z: Array, std: Array, bound: float) -> Smooth:
    """Local quintics of z, shape (n,), each over the widest window that the noise allows.

    std: (n,) of white noise. bound: size of an error that isn't white (half the step of an encoder) where the
    record moves slowly, or 0.
    A window is widened as long as the two polynomials beyond the fitted ones find nothing but noise in it, at
    this sample and on average around it; those for z and z' about turns, in the mean of all that are alike,
    too: what is missed there is the same at each, and a hysteresis adds it up (of z'' the noise counts more).
    From one width to the next the estimates are faded over, so that neither z nor v jumps.
    """
    found, least = _smoothed(z, std, bound), float(std.min())
    turns = turning_points(found.value[0], FAR * least) if least > 0 else np.zeros(0, dtype=np.intp)
    if not turns.size:
        return found
    path = _smoothed(z, std, bound, turns)
    value, errors, bent = (
        np.concatenate((a[:2], b[2:]))
        for a, b in ((path.value, found.value), (path.std, found.std), (path.bent, found.bent))
    )
    return Smooth(value, errors, bent, path.window)


def _smoothed(z: Array, std: Array, bound: float, turns: NDArray[np.intp] | None = None) -> Smooth:
    """The same, with windows about `turns` tested together, too."""
    n = z.size
    moves = _running_mean(np.abs(np.diff(z, prepend=z[0])), NEARBY)
    bounds = np.where(moves > 2 * SWEPT * bound, 0.0, bound)
    fit = local_fit(z, min(EXACT, n), min(EXACT, n) - 1)
    value, gain, window = fit.value.copy(), fit.gain.copy(), np.full(n, min(EXACT, n) // 2, dtype=float)
    good, half, missed = np.ones(n, dtype=bool), min(EXACT, n) // 2, np.zeros((3, n))
    bent = _bent(fit, z, std)
    for wider in HALF_WIDTHS if std.any() else ():
        if 2 * wider + 1 > n:
            break
        last, fit = fit, local_fit(z, 2 * wider + 1, DEGREE)
        good &= _only_noise(fit, wider, std, bounds)
        if turns is not None:
            good &= _alike_noise(fit, wider, std, bounds, turns, good)
        weight = _fade(good, max(1, wider // 3))
        if not weight.any():
            break
        value += weight * (fit.value - last.value)
        gain += weight * (fit.gain - last.gain)
        window += weight * (wider - half)
        beyond = np.hypot(_missed(fit, wider, std), _cornered(fit, wider, std, bounds, good))
        missed += weight * (beyond - missed)
        bent *= 1 - weight
        half = wider
    return Smooth(value, np.hypot(gain * std, missed), bent, window)


def _bent(fit: LocalFit, z: Array, std: Array) -> Array:
    """(3, n) size of the errors of an interpolating polynomial (`fit`) about corners between the samples.

    A polynomial of two samples less differs from it there, and nowhere else by more than noise does.
    """
    if z.size < 3 * EXACT:
        return np.zeros((3, z.size))
    change = np.abs(fit.value - local_fit(z, NARROWER, NARROWER - 1).value)
    sure, least = SEEN
    change[0] = 0.0  # both go through the samples
    greatest = np.abs(fit.value).max(axis=1)[:, None]
    change[change < np.maximum(sure * std * _change_by_noise()[:, None], least * greatest)] = 0.0
    if not change.any():
        return change
    reach = EXACT // 2
    around = np.lib.stride_tricks.sliding_window_view(np.pad(change, ((0, 0), (reach, reach))), EXACT, axis=1)
    return np.asarray(BENT * around.max(axis=2))


@cache
def _change_by_noise() -> Array:
    """(3,) std of the change between the two interpolating polynomials per unit std of white noise."""
    impulse = np.zeros(4 * EXACT)
    impulse[2 * EXACT] = 1.0
    fits = [local_fit(impulse, m, m - 1).value for m in (EXACT, NARROWER)]
    return np.linalg.norm(fits[0] - fits[1], axis=1)


def _missed(fit: LocalFit, half: int, std: Array) -> Array:
    """(3, n) rms of what the polynomials beyond the fitted ones add, where that is more than their noise."""
    noise = (fit.doubt * std) ** 2
    square = np.minimum(fit.beyond**2, 2 * PEAK**2 * noise) / np.maximum(noise, 1e-300)
    pooled = np.array([_running_mean(row, POOL * half) for row in square])
    return np.asarray(np.sqrt(np.maximum(pooled - (1 + SPREAD), 0.0) * noise))


def _cornered(fit: LocalFit, half: int, std: Array, bound: Array, good: NDArray[np.bool_]) -> Array:
    """(3, n) errors of the fit about corners that are seen in what is beyond it, though not for sure: where
    that is largest, and as large as a corner makes it."""
    error, response = _corner(half)
    power = np.sum(fit.excess**2, axis=0)
    least = np.maximum(CORNER * std**2, (FUNDAMENTAL * bound * fit.reach) ** 2)
    found = np.zeros((3, power.size + 2 * half))
    seen = np.flatnonzero(good & (power > least))
    ends = np.pad(power, ((half + 1) // 2, half // 2))
    around = np.lib.stride_tricks.sliding_window_view(ends, half + 1)
    for n in seen[power[seen] == around[seen].max(axis=1)].tolist():
        around = found[:, n : n + 2 * half + 1]
        np.maximum(around, error * np.sqrt(power[n] / response), out=around)
    return found[:, half : found.shape[1] - half]


@cache
def _corner(half: int) -> tuple[Array, float]:
    """(3, 2 half + 1) errors of a fit about a corner where the slope changes by one, and the largest sum of
    squares of its coefficients beyond the fit."""
    x = np.arange(-3.0 * half, 3.0 * half + 1)
    fit = local_fit(np.maximum(x, 0.0), 2 * half + 1, DEGREE)
    error = np.abs(fit.value - np.array([np.maximum(x, 0.0), x > 0, np.zeros(x.size)]))
    return error[:, 2 * half : 4 * half + 1], float(np.sum(fit.excess**2, axis=0).max())


def _only_noise(fit: LocalFit, half: int, std: Array, bound: Array) -> NDArray[np.bool_]:
    """Where the coefficients beyond the fit look like noise, one by one and on average around."""
    square = fit.excess**2
    limit = np.maximum(PEAK * std, bound * fit.reach) ** 2
    single = square.max(axis=0) < limit
    np.minimum(square, 2 * limit, out=square)  # a huge one must not cost the running sum its digits
    pooled = _running_mean(square.mean(axis=0), POOL * half)
    noise = np.maximum(std**2, _running_mean(std**2, POOL * half)) if np.ptp(std) > 0 else std**2
    return np.asarray(single & (pooled < POOLED * noise + (bound * fit.reach) ** 2))


def turning_points(z: Array, least: float) -> NDArray[np.intp]:
    """The samples at which a smoothed path turns, to go more than `least`."""
    steps = np.flatnonzero(np.diff(np.sign(np.diff(z)))) + 1
    kept = zigzag(z[np.concatenate(([0], steps, [z.size - 1]))], least) if steps.size else slice(None)
    return np.asarray(steps[kept], dtype=np.intp)


def _alike_noise(
    fit: LocalFit, half: int, std: Array, bound: Array, turns: NDArray[np.intp], good: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """False about those of the `turns`, still `good`, where the coefficients beyond the fit are more than
    noise in the mean of all that go as fast."""
    gaps = np.log(np.diff(turns, prepend=-bound.size, append=2 * bound.size))
    pace = np.minimum(gaps[1:], gaps[:-1])
    order = np.argsort(pace, kind="stable")
    order = order[good[turns[order]]]
    near = np.clip(turns[order][:, None] + np.arange(-(half // 2), half // 2 + 1), 0, bound.size - 1)
    noise = std[near] ** 2 + (bound[near] * fit.reach) ** 2
    square = np.minimum(fit.excess[:, near] ** 2 / noise, 2 * PEAK**2).mean(axis=(0, 2))
    first, last = (np.searchsorted(pace[order], pace[order] + x) for x in (-PACE, PACE))
    total = np.concatenate(([0.0], np.cumsum(square)))
    count = np.maximum(last - first, 1)
    missed = turns[order[(total[last] - total[first]) / count > 1 + ALIKE / np.sqrt(count)]]
    kept = np.ones(bound.size, dtype=bool)
    kept[np.clip(missed[:, None] + np.arange(-half, half + 1), 0, bound.size - 1)] = False
    return kept


def zigzag(tips: Array, least: float) -> list[int] | slice:
    """Which of the turns tips[1:-1] remain when excursions of `least` or less don't count."""
    if np.abs(np.diff(tips)).min() > least:
        return slice(None)
    kept: list[int] = []
    high = low = direction = 0
    for n, tip in enumerate(tips):
        high = n if direction >= 0 and tip > tips[high] else high
        low = n if direction <= 0 and tip < tips[low] else low
        if direction >= 0 and tips[high] - tip > least:
            kept += [high - 1] if direction else []
            direction, low = -1, n
        elif direction <= 0 and tip - tips[low] > least:
            kept += [low - 1] if direction else []
            direction, high = 1, n
    return kept


def _fade(good: NDArray[np.bool_], radius: int) -> Array:
    """1 inside the good stretches, falling to 0 within them, over the radius before their ends."""
    inside = _running_mean((~good).astype(float), radius) == 0
    return _running_mean(inside.astype(float), radius)


def _running_mean(x: Array, radius: int) -> Array:
    """Mean over the samples within the radius, fewer at the ends."""
    n, radius = x.size, min(radius, x.size - 1)
    total = np.cumsum(x)
    total = np.concatenate((np.zeros(radius + 1), total, np.full(radius, total[-1])))
    at = np.arange(n)
    count = np.minimum(at + radius + 1, n) - np.maximum(at - radius, 0)
    return np.asarray((total[2 * radius + 1 :] - total[:n]) / count)
