"""The level of independent noise in a record, from how neighbouring samples differ: no model is needed."""

from __future__ import annotations

from math import comb
from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[Any]]


QUIET = 0.25
"""Share of the differences, those that hold the least of other errors, that are enough to tell a scatter."""


def local_scatter(x: Array, order: int = 4, beside: Array | None = None) -> float:
    """Standard deviation of the independent part of a record x (n,), real or complex (then of each part).

    Differences of order `order` remove what is smooth; their median is blind to a few outliers. A smooth
    record without noise gives its rounding. Never zero: a constant record gives 1e-12 of its size.
    beside: (n,) standard deviations of other errors: differences that hold more of them than of the scatter
    say nothing of it.
    """
    x = np.asarray(x)
    floor = 1e-12 * (float(np.max(np.abs(x))) or 1.0)
    order = min(order, len(x) - 2)
    if order < 1:
        return max(floor, 1e-2 * float(np.max(np.abs(x))))
    d = np.diff(x, order)
    gain = np.sqrt(sum(comb(order, k) ** 2 for k in range(order + 1)))
    if beside is not None and np.any(beside > 0):
        other = np.lib.stride_tricks.sliding_window_view(beside, order + 1).max(axis=1)
        first = other <= np.quantile(other, QUIET)
        level = float(np.median(np.abs(d[first]))) / 0.6745 / gain
        d = d[first | (other < level)]
    parts = np.concatenate([d.real, d.imag]) if np.iscomplexobj(d) else d
    mad = float(np.median(np.abs(parts))) / 0.6745 / gain
    rms = float(np.sqrt(np.mean(parts**2))) / gain
    return max(floor, mad if mad > 0 else rms)


def rounding(x: Array) -> float:
    """Standard deviation of the rounding of a record x (n,) to a grid; 0 where its values are on none.

    Differences of a staircase are mostly 0, which hides how far its steps are from what they stand for.
    """
    gaps = np.diff(np.unique(x))
    if len(gaps) < 2:
        return 0.0
    step = float(gaps.min())
    steps = gaps / step
    return step / np.sqrt(12.0) if np.all(np.abs(steps - np.round(steps)) < 0.01) else 0.0


def stands(x: Array) -> bool:
    """Whether a record x (n,) mostly stays where it was a sample ago: a staircase, of treads not of jumps."""
    return bool(np.count_nonzero(np.diff(x)) < len(x) / 2)
