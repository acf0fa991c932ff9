"""What in a residual is noise: outliers, level, and colour. Colour is taken from the best hypothesis, never
the base."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from modelgen.diagnose.noise.recurring import without_recurring
from modelgen.diagnose.noise.stuck import stuck
from modelgen.fit.experiment import Experiment
from modelgen.fit.scatter import local_scatter, rounding, stands
from modelgen.fit.series import Array, Series

GROSS = 6.0
"""A sample this many robust standard deviations from its neighbours' median is an outlier."""
RARE, FEW = 0.1, 6
"""A larger share of the samples is no outliers, but what the model misses; of a short recording twice the
share, while they are so few."""
MISSED = 0.2
"""Neighbours are no outliers within GROSS times this share of what stands alone in the model itself: the top
of a narrow resonance."""


def outliers(white: Array, signal: Array | None = None, least: float = 0.0) -> Array:
    """(n,) bool: samples that stand alone far off their neighbours in a whitened residual (channels, n).

    signal: the model's own output, whitened alike, where a few samples may hold a resonance. least: standard
    deviation, whitened alike, of what any sample may be off by: the rounding of a record that mostly stands.
    """
    n = white.shape[1]
    if n < 15:
        return np.zeros(n, dtype=bool)
    far, near = np.zeros(n), np.zeros(n)
    peaks = np.zeros(n) if signal is None else MISSED * standing_alone(signal)
    for x in white:
        alone = off_neighbours(x)
        # on a slope most samples are the median of their own neighbours, and what scatters there is told by
        # the lines through them
        (level, local), (other, beside) = _levels(alone), _levels(BY_MEDIAN * off_lines(x))
        level, local = max(level, other), np.maximum(local, beside)
        # where the signal itself is rough (reversals), neighbours are far off as well: compare with the local
        # level
        scale = np.where(local > 2 * level, 1.5 * local, level)
        scale = np.maximum(scale, max(least, 1e-12 * (np.abs(alone).max() or 1.0)))
        far += (alone / scale) ** 2
        near += (alone / np.hypot(scale, peaks)) ** 2
    marked = far > GROSS**2
    lone = marked & ~np.roll(marked, 1) & ~np.roll(marked, -1)
    marked = lone | (near > GROSS**2)
    most = max(RARE * n, min(2 * RARE * n, FEW))
    return marked if marked.sum() < most else np.zeros(n, dtype=bool)


BY_MEDIAN = 0.74
"""What a sample of independent noise is off its neighbours' median, over what it is off their lines."""
LAGS = 6
ORDINARY = 0.01
"""Probability below which innovations are not independent."""


def first_order(white: Array, among: int = 1) -> bool:
    """Whether a residual (channels, n) may be noise of the first order, x_t = ρ x_{t−1} + independent ones:
    these show no more correlation over LAGS samples (Ljung & Box 1978) than the oddest `among` so many would.

    A law that is wrong leaves something smooth and the noise, which no first order describes.
    """
    from scipy.special import chdtrc

    total = 0.0
    for x in white:
        x = x[x != 0]
        if len(x) < 4 * LAGS:
            return False
        u = x[1:] - (x[1:] @ x[:-1]) / (x @ x) * x[:-1]
        n, power = len(u), float(u @ u)
        r = np.array([float(u[k:] @ u[:-k]) for k in range(1, LAGS + 1)]) / max(power, 1e-300)
        total += n * (n + 2) * float(np.sum(r**2 / (n - np.arange(1, LAGS + 1))))
    return bool(chdtrc((LAGS - 1) * len(white), total) > ORDINARY / among)


PEAKED = 9.0
"""Kurtosis beyond which a residual lies in bursts: near Gaussian noise of any colour has 3."""
TOGETHER = 5
"""Samples whose median stands for them: what stands alone is an outlier and no burst."""


def fitful(white: Array) -> bool:
    """Whether a residual over time (channels, n) lies in bursts that last, and recur: what is left where the
    motion comes to some place. Noise is there all the time, whatever its colour.
    """
    from scipy.ndimage import median_filter

    x = median_filter(white, (1, TOGETHER))
    power = np.mean(x**2, axis=1, keepdims=True)
    if white.shape[1] < 10 * TOGETHER or not np.all(power > 0):
        return False
    begins = np.diff(np.any(x**2 > PEAKED * power, axis=0).astype(int)) == 1
    return bool(np.max(np.mean((x**2 / power) ** 2, axis=1)) > PEAKED) and int(begins.sum()) >= RECUR


RECUR = 4
"""Bursts that are no accident."""


def outliers_of(e: Experiment, theta: Array, k: int) -> Array:
    """(n,) bool of recording k of an experiment at θ."""
    s = e.series[k]
    white = s.whitener.apply(e.raw(theta, k))
    if s.measure != "real" or not e.model.is_time_model:
        return outliers(white, modelled_output(e, theta, k))
    least = tread(s)
    alone = outliers(white, least=least)
    lone = without_recurring(e.model, s, white, alone, partial(outliers, least=least))
    return lone | stuck(s.data, white)


def scatter(s: Series, x: Array) -> float:
    """Standard deviation of the independent part of whitened residuals x (n,) of a record: what neighbours
    differ by, and no less than the rounding where it stays on the same steps."""
    return max(local_scatter(x), tread(s))


def tread(s: Series) -> float:
    """Rounding over noise of a record of real values that mostly stays where it was, 0 of others:
    what the scatter between neighbours doesn't show."""
    if s.measure != "real":
        return 0.0
    steps = [
        rounding(y) * float(np.median(w)) for y, w in zip(s.data, s.whitener.weight, strict=True) if stands(y)
    ]
    return max(steps, default=0.0)


FITS = 2.3
"""Times the noise that a law which fits leaves at most: a factor of two is soon forgotten where it is stated,
and misjudged where it was estimated of what the base left."""


def marked(series: Sequence[Series], marks: Sequence[Array]) -> tuple[str, ...]:
    """What is said of the outliers of each recording."""
    return tuple(
        f"{n} outliers in '{s.name}' are marked and weigh nothing"
        if n > 1
        else f"1 outlier in '{s.name}' is marked and weighs nothing"
        for s, n in zip(series, (int(m.sum()) for m in marks), strict=True)
        if n
    )


def off_neighbours(x: Array) -> Array:
    """How far each of (n,) samples is from the median of seven about it."""
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(x, 3, mode="reflect"), 7)
    return np.asarray(x - np.median(windows, axis=1))


def off_lines(x: Array) -> Array:
    """How far each of (n,) samples is from the median of three lines, each through the two samples that are
    as far away on either side."""
    p, n = np.pad(x, 3, mode="reflect"), len(x)
    return np.asarray(x - np.median([(p[k : k + n] + p[6 - k : 6 - k + n]) / 2 for k in range(3)], axis=0))


def _levels(alone: Array) -> tuple[float, Array]:
    """Robust standard deviation of (n,) numbers, of all and (n,) of the 21 about each."""
    near = np.lib.stride_tricks.sliding_window_view(np.pad(np.abs(alone), 10, mode="reflect"), 21)
    return 1.4826 * float(np.median(np.abs(alone))), 1.4826 * np.median(near, axis=1)


def standing_alone(signal: Array) -> Array:
    """(n,) how far a signal (channels, n) stands off its neighbours here or within three samples: the tops of
    narrow resonances."""
    peaks = np.hypot.reduce([off_neighbours(x) for x in signal])
    return np.asarray(
        np.lib.stride_tricks.sliding_window_view(np.pad(peaks, 3, mode="reflect"), 7).max(axis=1)
    )


def modelled_output(e: Experiment, theta: Array, k: int) -> Array:
    """The model's output in recording k at θ, over the noise (channels, n)."""
    s = e.series[k]
    return np.asarray(replace(s.whitener, root=None, ar=None).apply(e.raw(theta, k) + s.data))


def masked(series: Sequence[Series], marks: Sequence[Array]) -> tuple[Series, ...]:
    """Series whose outliers weigh nothing."""
    return tuple(
        replace(s, whitener=s.whitener.masked(np.where(m, 0.0, 1.0))) if m.any() else s
        for s, m in zip(series, marks, strict=True)
    )


def correlation_length(white: Sequence[Array]) -> float:
    """Integrated autocorrelation time of residuals in samples, 1 for independent ones, the largest of the
    recordings."""
    longest = 1.0
    for x in white:
        n = x.shape[1]
        d = x - x.mean(axis=1, keepdims=True)
        power = float(np.sum(d**2)) or 1.0
        total = 1.0
        for lag in range(1, max(2, n // 8)):
            c = float(np.sum(d[:, lag:] * d[:, :-lag])) / power
            if c <= 0.05:
                break
            total += 2 * c
        longest = max(longest, total)
    return longest


def local_level(white: Array) -> Array:
    """(n,) slowly varying level of a residual, 1 in the mean square; 1 everywhere when it is even."""
    n = white.shape[1]
    width = max(64, n // 24)
    if n < 6 * width or not np.any(white):
        return np.ones(n)
    power = np.minimum(np.mean(white**2, axis=0), 9.0 * np.mean(white**2))
    used = (np.abs(white).sum(axis=0) > 0).astype(float)
    kernel = np.ones(width)
    smooth = np.convolve(power * used, kernel, "same") / np.maximum(np.convolve(used, kernel, "same"), 1.0)
    smooth = np.maximum(smooth, 0.2 * np.mean(smooth))
    even = float(smooth.max() / smooth.min()) < (1.0 + 6.0 * np.sqrt(2.0 / width)) ** 2
    return np.ones(n) if even else np.asarray(np.sqrt(smooth / np.mean(smooth)))
