"""The spectrum of a record over time, samples missing or not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from modelgen.fit.colour import flattened
from modelgen.fit.series import Array

GAP = 1.5
"""Times the usual step from sample to sample beyond which some between them are missing."""
SPARSE = 2.0
"""Times as many samples that a record without gaps would have, beyond which it was made in bursts, or at
steps that grow: no sampling that some samples are missing of."""


def step(t: Array) -> float:
    """The time from sample to sample where none is missing, or the mean one where none is usual."""
    steps = np.diff(t)
    usual, mean = float(np.median(steps)), float(t[-1] - t[0]) / (len(t) - 1)
    return usual if steps.max() > GAP * usual and mean < SPARSE * usual else mean


def filled(t: Array, x: Array) -> Array:
    """Samples x of no mean as they follow each other at even steps, 0 where some are missing."""
    at = np.rint((t - t[0]) / step(t)).astype(int)
    even = np.zeros(at[-1] + 1)
    even[at] = x
    return even


def highest(t: Array) -> float:
    """Half the sampling frequency."""
    return 0.5 / step(t)


REACH = 120
"""Bins on either side of a line that tell how strong the spectrum is around it."""


def standing_out(t: Array, x: Array, grid: Array) -> Array:
    """Power of the residual x at the frequencies of `grid` over that around them; 0 where it has none."""
    even = filled(t, x - x.mean())
    size = 4 * len(even)
    power = np.abs(np.fft.rfft(flattened(even), size)) ** 2
    around = np.lib.stride_tricks.sliding_window_view(np.pad(power, REACH, mode="reflect"), 2 * REACH + 1)
    ratio = power / np.maximum(np.median(around[::8], axis=1).repeat(8)[: len(power)] / np.log(2), 1e-300)
    width = 2 * highest(t) / size
    return np.asarray(np.interp(grid, np.arange(len(power)) * width, ratio, right=0.0))


def share_of(series: Sequence[tuple[Array, Array]], f: float) -> float:
    """Share of the power of residuals (time, residual) that a wave of the frequency `f` has."""
    held = total = 0.0
    for t, x in series:
        x = x - x.mean()
        waves = np.linalg.qr(np.stack([np.cos(2 * np.pi * f * t), np.sin(2 * np.pi * f * t)], axis=1))[0]
        held += float(np.sum((waves.T @ x) ** 2))
        total += float(x @ x)
    return held / max(total, 1e-300)


def tuned(series: Sequence[tuple[Array, Array]], f: float, width: float) -> float:
    """The frequency within `width` of `f` at which a wave has most of the power."""
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(lambda x: -share_of(series, x), bounds=(f - width, f + width), method="bounded")
    return float(found.x)
