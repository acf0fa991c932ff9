"""The noise of a displacement record, from the record itself."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ORDERS = (2, 4, 8, 12, 16, 20, 24)
HIGH = 8  # order from which differences hold next to nothing of a signal of many samples a period
TOO_SHORT = 24  # samples; below, noise and signal can't be told apart


def noise_std(t: Array, z: Array) -> float:
    """Std of the white part of z, shape (n,), sampled at t, shape (n,); 0 where there is none to be seen.

    High-order divided differences hold noise and nearly no signal (Hall, Kay and Titterington, Biometrika 77
    (1990) 521); the median of their size doesn't mind kinks, as long as they are few: each spoils as many
    differences as the order, so the least of the orders counts. A signal of few samples a period leaks into
    them, less with each order: where the estimate still falls at the last, it sees signal, and 0 is returned.
    """
    steps = np.diff(t)
    uniform = bool(np.ptp(steps) < 1e-3 * steps.mean()) if steps.size else True
    orders = [d for d in ORDERS if d <= (z.size // 6 if uniform else min(8, z.size // 6))]
    if z.size < TOO_SHORT:
        return 0.0
    found = [1.4826 * float(np.median(np.abs(_difference(t, z, d, uniform)))) for d in orders]
    if found[-1] < 0.7 * found[-2]:
        return 0.0
    std = min([s for d, s in zip(orders, found, strict=True) if d >= HIGH] or found[-1:])
    return std if std > 100 * np.finfo(float).eps * float(np.abs(z).max()) else 0.0


BLOCK, HOP, BLOCKS = 201, 25, 8000
"""Samples in which the noise here and there is looked at, how far these are apart, and how many there are at
most."""
BY_CHANCE = 0.136
"""Relative standard deviation of what a block tells of white noise."""
MOST = 5.0
"""Times the usual noise from which it is a signal of some two samples a period rather."""
SAME = 1.6
"""How much the noise that differences of one order see may differ from that of another: a signal leaks into
them less with each order."""


def noise_along(t: Array, z: Array, std: float) -> Array:
    """(n,) std of the white part of z (n,), usually `std`: more where differences of two orders tell of more.

    An encoder errs more while it turns, an amplifier while a motor runs.
    """
    from scipy.ndimage import maximum_filter1d

    steps = np.diff(t)
    if std == 0 or z.size < 4 * BLOCK or np.ptp(steps) >= 1e-3 * steps.mean():
        return np.full(z.size, std)
    hop = max(HOP, z.size // BLOCKS)
    low, high = (_here_and_there(z, order, hop) for order in (HIGH, 2 * HIGH))
    here = np.minimum(low, high)
    least = 1 + BY_CHANCE * (1 + np.sqrt(2 * np.log(here.size)))  # hardly one of them all by chance
    louder = (here > least * std) & (here < MOST * std) & (low < SAME * high)
    most = maximum_filter1d(np.where(louder, here, std), 1 + BLOCK // hop)  # a block on the edge sees half
    at = hop * np.arange(here.size) + BLOCK // 2 + HIGH
    return np.asarray(np.interp(np.arange(z.size), at, most))


def _here_and_there(z: Array, order: int, hop: int) -> Array:
    """What differences of this order tell of the noise in blocks `hop` samples apart, whose middles are the
    same for each order."""
    spare = HIGH - order // 2
    size = np.abs(np.diff(z, order))[spare : z.size - order - spare] / math.sqrt(math.comb(2 * order, order))
    blocks = np.lib.stride_tricks.sliding_window_view(size, BLOCK)[::hop]
    return np.asarray(1.4826 * np.median(blocks, axis=1))


def _difference(t: Array, z: Array, order: int, uniform: bool) -> Array:
    """Differences of this order whose std is that of white noise in z."""
    if uniform:
        return np.diff(z, order) / math.sqrt(math.comb(2 * order, order))
    n = z.size - order
    nodes = [t[i : i + n] for i in range(order + 1)]
    span = nodes[-1] - nodes[0]
    weights = np.ones((order + 1, n))
    for i, a in enumerate(nodes):
        for j, b in enumerate(nodes):
            if i != j:
                weights[i] *= span / (a - b)
    values = sum(w * z[i : i + n] for i, w in enumerate(weights))
    return np.asarray(values / np.linalg.norm(weights, axis=0))


def quantum(z: Array) -> float:
    """The step of an encoder, when z, shape (n,), climbs a lattice in a staircase; else 0.

    An exact ramp is on a lattice too, but its second differences vanish where a staircase has two a step.
    """
    moves, bends = (np.count_nonzero(np.abs(np.diff(z, d)) > 1e-9 * np.abs(z).max()) for d in (1, 2))
    if 2 * bends < moves:
        return 0.0
    levels = np.unique(z)
    gaps = np.diff(levels)
    gaps = gaps[gaps > 1e-9 * np.abs(levels).max(initial=0.0)]  # the same rung, rounded differently
    if gaps.size < 4 or levels.size > z.size // 2:
        return 0.0
    step = float(gaps.min())
    near = gaps[gaps < 20 * step] / step
    on_lattice = np.abs(near - np.round(near)) < 0.1
    return step if near.size > gaps.size // 2 and bool(on_lattice.mean() > 0.95) else 0.0
