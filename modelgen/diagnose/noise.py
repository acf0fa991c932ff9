"""What in a residual is noise: outliers, level, and colour. Colour is taken from the best hypothesis, never the base."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modelgen.fit.series import Array, Series, Whitener

GROSS = 6.0
"""A sample this many robust standard deviations from its neighbours' median is an outlier."""


def outliers(white: Array) -> Array:
    """(n,) bool: samples that stand alone far off their neighbours in a whitened residual (channels, n)."""
    n = white.shape[1]
    if n < 15:
        return np.zeros(n, dtype=bool)
    far = np.zeros(n, dtype=bool)
    for x in white:
        padded = np.pad(x, 3, mode="reflect")
        windows = np.lib.stride_tricks.sliding_window_view(padded, 7)
        alone = x - np.median(windows, axis=1)
        level = 1.4826 * np.median(np.abs(alone))
        # where the signal itself is rough (reversals), neighbours are far off as well: compare with the local level
        local = 1.4826 * np.median(np.abs(np.lib.stride_tricks.sliding_window_view(np.pad(alone, 10, mode="reflect"), 21)), axis=1)
        far |= np.abs(alone) > GROSS * np.maximum(level, 1.5 * local) + 1e-300
    return far if far.mean() < 0.1 else np.zeros(n, dtype=bool)


def masked(series: Sequence[Series], marks: Sequence[Array]) -> tuple[Series, ...]:
    """Series whose outliers weigh nothing."""
    return tuple(
        replace(s, whitener=s.whitener.masked(np.where(m, 0.0, 1.0))) if m.any() else s
        for s, m in zip(series, marks, strict=True)
    )


def autoregression(white: Array, most: int) -> Array:
    """Whitening filter (1, a1, …) of a residual (channels, n), its order by BIC (0 … most). Scaled to unit input variance.

    Fitted by least squares over both channels; the innovation's standard deviation is divided out relative to the
    residual's own, so that the filter changes the colour of the noise and not what its level was stated to be.
    """
    n = white.shape[1]
    most = int(min(most, n // 10))
    if most < 1:
        return np.ones(1)
    x = white - white.mean(axis=1, keepdims=True)
    target = x[:, most:].ravel()
    columns = np.stack([x[:, most - k : n - k].ravel() for k in range(1, most + 1)], axis=1)
    total = float(target @ target) or 1.0
    count = len(target)
    q, r = np.linalg.qr(columns)
    c = q.T @ target
    rss = np.concatenate([[total], total - np.cumsum(c**2)])
    bic = count * np.log(np.maximum(rss, 1e-12 * total)) + np.arange(most + 1) * np.log(count)
    order = int(np.argmin(bic))
    if order == 0 or bic[0] - bic[order] < 10.0:
        return np.ones(1)
    a = np.linalg.solve(r[:order, :order], c[:order])
    return np.concatenate([[1.0], -a])


def coloured(whiteners: Sequence[Whitener], white: Sequence[Array], most: int) -> tuple[Whitener, ...]:
    """Whiteners with the colour of the residuals `white` (which they left), one filter a recording."""
    return tuple(
        replace(w, ar=None if len(a) == 1 else a)
        for w, a in zip(whiteners, (autoregression(x, most) for x in white), strict=True)
    )


def signs(white: Sequence[Array]) -> float:
    """Largest z-score of lag-1 … 4 correlation over all recordings: how far residuals are from independent."""
    worst = 0.0
    for x in white:
        for row in x:
            n = len(row)
            d = row - row.mean()
            power = float(d @ d) or 1.0
            for lag in range(1, min(5, n - 2)):
                worst = max(worst, float(d[lag:] @ d[:-lag]) / power * np.sqrt(n))
    return worst
