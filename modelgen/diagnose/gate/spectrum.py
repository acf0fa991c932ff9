"""The spectrum of a record over time, samples missing or not."""

from __future__ import annotations

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
