"""Where a sampled path turns: which way it goes, and how far, where corners lie between the samples."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from modelgen.recordings.smooth import EXACT, FAR, Smooth, turning_points, zigzag

Array = NDArray[np.float64]

SURE = 4.0  # standard deviations of the velocity from which a direction of motion counts; or a way of FAR


def turned(
    t: Array, raw: Array, found: Smooth, std: float
) -> tuple[Array, Array, NDArray[np.intp], NDArray[np.intp]]:
    """(path, z_turn, steps with a turn, those of them at which the path rests) of samples `raw` (n,) with
    noise `std`, smoothed to `found`; path and z_turn: (n,), as in `Kinematics`."""
    z, v, _ = (np.ascontiguousarray(row) for row in found.value)
    sign = _directions(t, z, v, SURE * found.std[1] + 1e-9 * np.abs(v).max())
    sign = _with_ways(z, v, sign, FAR * std) if std > 0 else sign
    steps = _reversals(z, v, sign, std + 1e-9 * float(np.ptp(z)))
    resting = steps[:0]
    if std > 0:
        steps, z, resting = _at_rest(raw, z, sign, steps, found.window, std)
    most = _meeting(t, z, steps)
    slack = np.where(found.window > EXACT // 2, found.std[0], 0.0)  # none where samples are as they were
    z = _one_way(z, steps, SURE * std) if std > 0 else z
    z_turn = np.concatenate((z[:1], z[:-1]))
    z_turn[steps] = _extreme(t, z, v, steps, most, slack[steps])
    return z, z_turn, steps, resting


def _one_way(z: Array, steps: NDArray[np.intp], least: float) -> Array:
    """The monotonic path nearest to z (n,) between one reversal and the next, within `least` of it.

    Noise that smoothing has left goes to and fro with every sample, a way that a hysteresis would remember.
    """
    bounds = [0, *(n for n in steps.tolist() if 0 < n < z.size), z.size]
    parts = []
    for begin, end in pairwise(bounds):
        part, before = z[begin:end], z[max(begin - 1, 0)]
        parts.append(rising(part) if part[-1] >= before else -rising(-part))
    path = np.concatenate(parts)
    return np.where(np.abs(path - z) < least, path, z)


def rising(x: Array) -> Array:
    """The nearest (n,) that never falls: neighbours that do are pooled (Ayer et al., Ann. Math. Stat. 26
    (1955) 641). SciPy's needs longer to be imported than this for a record."""
    means: list[float] = []
    counts: list[int] = []
    for mean in x.tolist():
        count = 1
        while means and means[-1] >= mean:
            last, many = means.pop(), counts.pop()
            mean, count = (many * last + count * mean) / (many + count), many + count
        means.append(mean)
        counts.append(count)
    return np.repeat(means, counts)


def _directions(t: Array, z: Array, v: Array, doubt: Array) -> Array:
    """(n,) sign of the motion where it is sure, else 0: v is, and so is the slope of z on one side at least.

    A polynomial through a corner goes to and fro about samples that don't.
    """
    sign, slope = np.where(np.abs(v) > doubt, np.sign(v), 0.0), np.diff(z) / np.diff(t)
    before, after = np.concatenate((slope[:1], slope)), np.concatenate((slope, slope[-1:]))
    return np.where(np.maximum(sign * before, sign * after) > doubt, sign, 0.0)


def _with_ways(z: Array, v: Array, sign: Array, least: float) -> Array:
    """`sign` (n,) of sure motion, 0 for unsure, with one sample more in each way of more than `least` between
    two turns of z of which none was sure: it is slow, or a small step between two rests."""
    tips = turning_points(z, least)
    sign = sign.copy()
    for begin, end in pairwise([0, *tips.tolist(), z.size - 1]):
        way = np.sign(z[end] - z[begin])
        if abs(z[end] - z[begin]) > least and not np.any(sign[begin : end + 1] == way):
            sign[begin + int(np.argmax(way * v[begin : end + 1]))] = way
    return sign


def _reversals(z: Array, v: Array, sign: Array, least: float) -> NDArray[np.intp]:
    """The steps n, from n - 1 to n, in which the motion turns: one between sure motions of opposite `sign`
    (n,), 0 where it isn't sure, when the path between turns is longer than `least`."""
    sure = np.flatnonzero(sign)
    sign = sign[sure]
    change = np.flatnonzero(sign[1:] != sign[:-1])
    before, after, up = sure[change], sure[change + 1], sign[change]
    steps = after.copy()
    tips = np.where(up > 0, np.maximum(z[before], z[after]), np.minimum(z[before], z[after]))
    for k in np.flatnonzero(after > before + 1):  # doubtful samples in between: where z is extreme
        top = int(np.argmax(up[k] * z[before[k] : after[k] + 1]))
        forward = up[k] * v[before[k] : after[k] + 1] > 0
        crossings = np.flatnonzero(forward[:-1] & ~forward[1:])
        if not crossings.size:  # a way that no speed shows
            crossings = np.array([min(top, len(forward) - 2)])
        steps[k] = before[k] + 1 + crossings[np.argmin(np.abs(crossings - top))]
        tips[k] = z[before[k] + top]
    return steps[zigzag(np.concatenate((z[:1], tips, z[-1:])), least)]


def _at_rest(
    raw: Array, z: Array, sign: Array, steps: NDArray[np.intp], window: Array, std: float
) -> tuple[NDArray[np.intp], Array, NDArray[np.intp]]:
    """Turns and path (n,) where the motion rests before it turns: at the mean of the samples `raw` there; and
    those of the turns that are such.

    The extreme of what smoothing leaves of the noise is farther out, the more so the longer the rest, and a
    hysteresis would remember it. A rest is longer than two of the narrowest windows in it, which see corners,
    and its samples scatter about one level as noise does.
    """
    sure = np.concatenate(([-1], np.flatnonzero(sign), [raw.size]))
    steps, z, resting = steps.copy(), z.copy(), []
    for k, n in enumerate(steps.tolist()):
        after = int(np.searchsorted(sure, n))
        begin, end = sure[after - 1] + 1, sure[after]
        if end - begin <= 2 * (2 * window[begin:end].min(initial=np.inf) + 1):
            continue
        near = begin + np.flatnonzero(np.abs(raw[begin:end] - np.median(raw[begin:end])) < SURE * std)
        rest = slice(near[0], near[-1] + 1)
        m, level = near[-1] + 1 - near[0], raw[rest].mean()
        if np.sum((raw[rest] - level) ** 2) < std**2 * (m + SURE * (2 * m) ** 0.5):
            z[rest], steps[k] = level, max(near[0], 1)
            resting.append(steps[k])
    return steps, z, np.array(resting, dtype=np.intp)


def _extreme(t: Array, z: Array, v: Array, steps: NDArray[np.intp], most: Array, slack: Array) -> Array:
    """Extreme of the Hermite cubic of (z, v) in each step, at most `slack` beyond `most`; of its two ends
    where v has one sign there.

    The slope is a x² + b x + c with x from 0 to 1; opposite signs at the ends leave exactly one root between.
    """
    h, z0, z1 = t[steps] - t[steps - 1], z[steps - 1], z[steps]
    c, end, rise = v[steps - 1] * h, v[steps] * h, z1 - z0
    a, b = 3 * (c + end - 2 * rise), 2 * (3 * rise - 2 * c - end)
    q = -0.5 * (b + np.where(b >= 0, 1.0, -1.0) * np.sqrt(np.maximum(b * b - 4 * a * c, 0.0)))
    with np.errstate(divide="ignore", invalid="ignore"):
        roots = np.array([q / a, c / q])
    x = np.where((roots[0] >= 0) & (roots[0] <= 1), roots[0], roots[1])
    turn = z0 + x * (c + x * (b / 2 + x * a / 3))
    up = np.where(np.where(c * end < 0, c, c + end) >= 0, 1.0, -1.0)
    ends = up * np.maximum(up * z0, up * z1)
    turn = np.where((c * end < 0) & (x >= 0) & (x <= 1), turn, ends)
    return up * np.clip(up * turn, up * ends, np.maximum(up * ends, up * most + slack))


def _meeting(t: Array, z: Array, steps: NDArray[np.intp]) -> Array:
    """Where the straight lines through the samples before each step and after it meet within it: a path that
    bends one way turns short of that. Where they don't: as far beyond z before the step as it comes back."""
    slope = np.diff(z) / np.diff(t)
    h, z0, z1 = t[steps] - t[steps - 1], z[steps - 1], z[steps]
    s0, s1 = slope[np.maximum(steps - 2, 0)], slope[np.minimum(steps, slope.size - 1)]
    bend = np.where(s0 != s1, s0 - s1, 1.0)
    x = (z1 - z0 - s1 * h) / bend
    back = np.where(s0 * (z1 - z0) < 0, 2 * z0 - z1, z0)
    return np.where((s0 != s1) & (x > 0) & (x < h), z0 + s0 * x, back)
