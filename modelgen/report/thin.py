"""Fewer points for a plot, without losing what one looks for: extremes stay."""

from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[Any]]


def extremes(y: Array, bins: int) -> Array:
    """Indices, in order, of the least and the greatest value in each of `bins` stretches of y (n,)."""
    n = len(y)
    if n <= 2 * bins:
        return np.arange(n)
    width = -(-n // bins)
    padded = np.full(width * (-(-n // width)), np.nan)
    padded[:n] = y
    blocks = padded.reshape(-1, width)
    low = np.argmin(np.where(np.isfinite(blocks), blocks, np.inf), axis=1)
    high = np.argmax(np.where(np.isfinite(blocks), blocks, -np.inf), axis=1)
    start = np.arange(len(blocks)) * width
    found = np.unique(np.concatenate([start + low, start + high]))
    return found[found < n]


def every(n: int, most: int) -> Array:
    """At most `most` evenly spaced indices of n."""
    return np.arange(n) if n <= most else np.unique(np.linspace(0, n - 1, most).round().astype(int))


def upward(signal: Array) -> int:
    """How often `signal` (n,) crosses its mean upwards."""
    centred = np.nan_to_num(signal - np.nanmean(signal)) if len(signal) else signal
    return int(np.sum((centred[:-1] < 0) & (centred[1:] >= 0)))


def excerpt(signal: Array, misfit: Array, cycles: float = 3.0, fewest: int = 60) -> slice:
    """About three cycles of `signal` (n,) around where the squared `misfit` (n,) is greatest; all if short.

    A cycle is the record over its number of upward crossings of the mean.
    """
    n = len(signal)
    ups = upward(signal)
    width = n if ups == 0 else max(int(np.ceil(cycles * n / ups)), fewest)
    if width >= n:
        return slice(0, n)
    total = np.concatenate([[0.0], np.cumsum(np.nan_to_num(np.square(misfit)))])
    begin = int(np.argmax(total[width:] - total[:-width]))
    return slice(begin, begin + width)
