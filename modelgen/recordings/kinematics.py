"""Velocity, acceleration and reversals of a measured displacement, in a way that survives its noise."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modelgen.errors import InputError
from modelgen.recordings.noise import noise_along, noise_std, quantum
from modelgen.recordings.smooth import EXACT, Smooth, smooth
from modelgen.recordings.turns import turned

Array = NDArray[np.float64]

JITTER = 1e-3  # of a step: time stamps that are rounded in a file are uniform all the same
LONG = 100_000  # samples of a record beyond which its motion is not kept in memory
SMOOTH = 0.01  # change from one ratio of neighbouring steps to the next, in logarithms, of a smooth clock
AROUND = 31  # steps whose median is what is usual there
ALIKE = 2.0  # ratio of usual steps up to which one grid serves all
TIP = 0.3  # error of a turn at a corner between samples, over those of both slopes times the step


@dataclass(frozen=True, eq=False)
class Kinematics:
    """Motion at n samples; all arrays have shape (n,), units are those of z and t.

    z: smoothed displacement. v, a: dz/dt, d²z/dt². z_turn: where the path turns on its way from z[n-1] to
    z[n]; z[n-1] where it doesn't. reversals: the steps n with a turn, shape (number of reversals,).
    sigma_z: std of the noise in the record, all in all. sigma, sigma_v, sigma_a, sigma_turn: std of what is
    left of it in z, v, a and z_turn, and of what a corner between the samples makes of them. window:
    half-width, in samples, of the polynomial at each sample.
    """

    z: Array
    v: Array
    a: Array
    z_turn: Array
    reversals: NDArray[np.intp]
    sigma_z: float
    sigma: Array
    sigma_v: Array
    sigma_a: Array
    sigma_turn: Array
    window: NDArray[np.intp]


def kinematics(t: ArrayLike, z: ArrayLike, sigma: float | None = None, name: str = "z") -> Kinematics:
    """Differentiate a displacement record z (n,) taken at increasing times t (n,).

    sigma: std of its noise. name: what errors call it.

    **Which way, and why.** Noise of 3e-4 mm at 4 kHz makes raw differences useless (1.6 mm/s, as large as
    the velocity), and no one filter serves both a 0.1 Hz sine and a record of six samples a period. So:
    local quintics (Savitzky-Golay) over a bank of windows, 9 to 3283 samples; at each sample the widest
    in which the next two polynomials find only noise. That is Lepski's rule (Theory Probab. Appl. 35
    (1990) 454) with a test that has, unlike intersecting confidence intervals, the power of the whole
    window, and so seldom fails by chance. A fast stretch is never smoothed away for the sake of a slow
    one. The narrowest member interpolates 9 samples: differences of 8th order, z untouched. Without noise
    it is the only one.

    **Noise**, unless given, comes from high-order differences, here and there (see `noise_std`,
    `noise_along`); the steps of a coarse encoder count as an error of up to half a step, since at low speed
    they are not white.

    **Time** that is uniform to 1e-3 of a step is taken as uniform. Smoothly varying steps (a logarithmic
    grid, a solver's) are handled with the sample number as parameter, v = z'/t'. Others (jitter, gaps) are
    carried to a grid as dense as the samples around and back by splines; without noise the spline itself
    is differentiated.

    **Reversals**: the direction counts only where |v| > 4 sigma_v and z goes that way, too, and an excursion
    only above the noise of the record, so that neither noise at rest nor ringing at a corner makes one.
    Between two stretches of opposite direction there is exactly one, at the extreme of z; z_turn is the
    extreme of the Hermite cubic of (z, v) in that step, but no farther than a path that bends one way can
    go, so that z[n-1] -> z_turn[n] -> z[n] is monotonic in pieces. With noise z is the monotonic path nearest
    to the smoothed one between two reversals: a hysteresis would remember each to-and-fro of what is left
    of it.

    Raises InputError for arrays of different or zero length, values that aren't finite, time that doesn't
    increase, a negative sigma.
    """
    t, z = _checked(t, z, sigma, name)
    if z.size > LONG:
        return _kinematics(t, z, sigma)
    return _again(t.tobytes(), z.tobytes(), sigma)


@lru_cache(maxsize=16)
def _again(t: bytes, z: bytes, sigma: float | None) -> Kinematics:
    """`kinematics` of records that are asked for again and again, each time with another model."""
    return _kinematics(np.frombuffer(t), np.frombuffer(z), sigma)


def _kinematics(t: Array, z: Array, sigma: float | None) -> Kinematics:
    if z.size == 1:
        still = np.zeros(1)
        none = np.zeros((3, 1))
        return _frozen(
            t, z, Smooth(np.array([z, still, still]), none, none, still), sigma or 0.0, sigma or 0.0
        )
    std = noise_std(t, z) if sigma is None else float(sigma)
    step = quantum(z) if sigma != 0 else 0.0
    if std < step:  # otherwise the noise is wide enough to whiten the steps
        std, bound = max(std, step / 12**0.5), step / 2
    else:
        bound = 0.0
    middle = float(np.median(z))  # digits for the motion rather than for where it happens
    along = noise_along(t, z, std) if sigma is None and bound == 0 else np.full(z.size, std)
    found = _differentiate(t, z - middle, along, bound)
    found.value[0] += middle
    if std == 0:
        found.value[0] = z
    return _frozen(t, z, found, std, float(np.sqrt(np.mean(along**2))))


def _checked(t: ArrayLike, z: ArrayLike, sigma: float | None, name: str) -> tuple[Array, Array]:
    t, z = np.asarray(t, dtype=np.float64), np.asarray(z, dtype=np.float64)
    if t.ndim != 1 or t.shape != z.shape or not t.size:
        raise InputError(f"'{name}': time has shape {t.shape}, it has {z.shape}, wanted two of one length")
    if not (np.isfinite(t).all() and np.isfinite(z).all()):
        row = int(np.argmin(np.isfinite(t) & np.isfinite(z)))
        raise InputError(f"'{name}': sample {row} is {z[row]} at time {t[row]}, wanted finite numbers")
    if (np.diff(t) <= 0).any():
        row = int(np.argmax(np.diff(t) <= 0)) + 1
        raise InputError(f"'{name}': time doesn't increase at sample {row}, {t[row]}")
    if sigma is not None and not 0 <= sigma < np.inf:
        raise InputError(f"'{name}': sigma = {sigma}, wanted a finite number that isn't negative")
    return t, z


def _differentiate(t: Array, z: Array, std: Array, bound: float) -> Smooth:
    """z, v, a against time, by the way that suits the time stamps."""
    n = t.size
    step = (t[-1] - t[0]) / (n - 1)
    if np.abs(t - np.linspace(t[0], t[-1], n)).max() <= JITTER * step:
        return _per_time(smooth(z, std, bound), step)
    ratio = np.diff(np.log(np.diff(t)))
    if n < 5 or (np.abs(ratio).max() < np.log(1.25) and np.abs(np.diff(ratio)).max() < SMOOTH):
        return _by_sample_number(t, z, std, bound)
    return _by_splines(t, z, std, bound)


def _per_time(found: Smooth, step: float) -> Smooth:
    scale = np.array([1.0, 1 / step, 1 / step**2])[:, None]
    return Smooth(found.value * scale, found.std * scale, found.bent * scale, found.window)


def _by_sample_number(t: Array, z: Array, std: Array, bound: float) -> Smooth:
    """z and t are both smooth functions of the sample number: v = z'/t', a = (z'' - v t'')/t'^2."""
    clock = smooth(t - t[0], np.zeros(t.size), 0.0).value
    found = smooth(z, std, bound)
    v = found.value[1] / clock[1]
    a = (found.value[2] - v * clock[2]) / clock[1] ** 2
    scale = np.array([np.ones_like(v), 1 / clock[1], 1 / clock[1] ** 2])
    return Smooth(np.array([found.value[0], v, a]), found.std * scale, found.bent * scale, found.window)


def _by_splines(t: Array, z: Array, std: Array, bound: float) -> Smooth:
    """Interpolate, and with noise smooth on a grid as dense as the samples around, then come back."""
    from scipy.interpolate import make_interp_spline

    curve = make_interp_spline(t, z, k=3 if std.any() or t.size < 6 else 5)
    if not std.any():
        value = np.array([curve(t), curve(t, 1), curve(t, 2)])
        none = np.zeros((3, t.size))
        return Smooth(value, none, none, np.full(t.size, 2.0))
    u = _local_number(t)
    n = int(min(np.ceil(u[-1]), 4 * t.size)) + 1
    grid = np.linspace(0.0, u[-1], n)
    clock = make_interp_spline(u, t, k=3)(grid)
    clock[[0, -1]] = t[[0, -1]]
    found = _by_sample_number(clock, curve(clock), np.interp(grid, u, std), bound)
    value = make_interp_spline(grid, found.value.T, k=3)(u).T
    noise, bent = (np.array([np.interp(u, grid, x) for x in rows]) for rows in (found.std, found.bent))
    window = np.interp(u, grid, found.window)
    as_recorded = window <= EXACT // 2  # nothing was smoothed there, and back and forth rings at corners
    value[0, as_recorded] = z[as_recorded]
    return Smooth(value, noise, bent, window)


def _local_number(t: Array) -> Array:
    """(n,) u(t) that goes up by one in each usual step: what is usual is the median around, which may change
    over decades as it does in a test of relaxation or creep."""
    from scipy.integrate import cumulative_trapezoid
    from scipy.ndimage import median_filter, uniform_filter1d

    usual = median_filter(np.log(np.diff(t)), AROUND, mode="nearest")
    if np.ptp(usual) < np.log(ALIKE):
        return np.asarray((t - t[0]) / np.median(np.diff(t)))
    usual = uniform_filter1d(usual, AROUND, mode="nearest")
    rate = np.exp(-np.interp(t, (t[1:] + t[:-1]) / 2, usual))
    return np.asarray(cumulative_trapezoid(rate, t, initial=0.0))


def _frozen(t: Array, raw: Array, found: Smooth, std: float, overall: float) -> Kinematics:
    z, z_turn, steps, resting = turned(t, raw, found, std)
    v, a = (np.ascontiguousarray(row) for row in found.value[1:])
    window = np.rint(found.window).astype(np.intp)
    sigma, sigma_v, sigma_a = np.hypot(found.std, found.bent)
    before = np.concatenate((found.bent[1, :1], found.bent[1, :-1]))
    sigma_turn = np.hypot(TIP * np.diff(t, prepend=t[0]) * (found.bent[1] + before), found.std[0])
    sigma_turn[resting] = np.hypot(sigma_turn[resting], std)  # as far as noise hides that it went farther
    arrays = (z, v, a, z_turn, steps, sigma, sigma_v, sigma_a, sigma_turn, window)
    for array in arrays:
        array.setflags(write=False)
    return Kinematics(*arrays[:5], overall, *arrays[5:])
