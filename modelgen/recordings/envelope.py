"""Slow properties of a motion: its running amplitude, and the same motion a quarter of a cycle later."""

from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]

SHARE = 0.05
"""A way back of this share of the whole range makes a turning point; less is jitter."""


def amplitude(z: Array) -> Array:
    """Half the swing that each sample of z (n,) lies in, from turning point to turning point, in z's unit.

    The parts before the first and after the last turning point take the larger of their own and the next
    swing's. A record that never turns has half its range throughout.
    """
    turns = turning_points(z)
    if len(turns) < 3:
        return np.full(len(z), float(np.ptp(z)) / 2)
    swings = np.abs(np.diff(z[turns])) / 2
    swings[0], swings[-1] = (
        max(swings[0], swings[min(1, len(swings) - 1)]),
        max(swings[-1], swings[-2:].max()),
    )
    return np.asarray(np.repeat(swings, [*np.diff(turns).tolist()[:-1], len(z) - turns[-2]]))


def turning_points(z: Array) -> Array:
    """Indices of the record's first sample, its turning points and its last sample."""
    least = SHARE * float(np.ptp(z))
    found, high, low = [0], 0, 0
    rising: bool | None = None
    for i, x in enumerate(z.tolist()):
        high = i if x > z[high] else high
        low = i if x < z[low] else low
        if rising is not False and z[high] - x > least:
            found += [high] if rising else []
            rising, low = False, i
        elif rising is not True and x - z[low] > least:
            found += [] if rising is None else [low]
            rising, high = True, i
    return np.array([*found, len(z) - 1])


def quadrature(z: Array) -> Array:
    """The Hilbert transform of z (n,), a quarter of a cycle ahead of it: z = cos ωt gives −sin ωt.

    Beyond both ends the record goes on in cycles like the one that is next to the end (mirrored where it has
    none, or rests), so that they do not ring; a constant gives 0. With it, the loss that takes the same share
    of the energy in each cycle, at any rate, is a force (as K + jH in the frequency domain).
    """
    n = len(z)
    x = np.concatenate([_continued(z[::-1])[::-1], z, _continued(z)]) - float(np.mean(z))
    spectrum = np.fft.rfft(x)
    spectrum[0] = 0.0
    return np.asarray(np.fft.irfft(1j * spectrum, len(x))[n : 2 * n])


RESTS = 0.25
"""Speed at an end, over the greatest in the cycle next to it, below which a record is mirrored there."""


def _continued(z: Array) -> Array:
    """(n,) what would follow on z (n,) if the cycle before its end went on: from where that was at the same
    place, on the same way."""
    turns = turning_points(z)[1:-1]
    if len(turns) < 3:
        return z[::-1]
    period = int(turns[-1] - turns[-3])
    step = max(period // 20, 1)
    ways = z[step:] - z[:-step]
    if abs(ways[-1]) < RESTS * np.abs(ways[-period:]).max():
        return z[::-1]
    last = len(z) - 1
    around = np.arange(max(last - 3 * period // 2, step), last - period // 2)
    around = around[ways[around - step] * ways[-1] > 0]
    if not around.size:
        return z[::-1]
    at = int(around[np.argmin(np.abs(z[around] - z[-1]))])
    return np.resize(z[at + 1 :], len(z))
