"""Samples of a recorded displacement that were lost: a run that jumps away and back, or the first or last
few, while all that was recorded with them goes on.

A blow or a step looks the same in the displacement alone; the force feels these, and not what a sensor lost.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from modelgen.fit.series import Array
from modelgen.recordings.noise import noise_std

SURE = 25.0
"""Standard deviations of the displacement's noise that it jumps by, at least,"""
STEPS = 3.0
"""times the step that all but a few are below,"""
SEEN = 0.02
"""and part of the stroke of all but a few."""
FEW = 0.01
"""Share of the samples that may be lost, and of the steps that are no measure."""
LONGEST, AT_AN_END = 20, 3
"""Samples that a run may have, between others and at an end, where nothing says how it goes on."""
MISSED = 0.05
"""Part of a jump that the path may be off where it comes back, beside how it moves."""
NEAR = 5
"""Samples next to a run that say where the path is and where it goes."""
FELT = 2.0
"""Times what a recorded output steps by anyway that a jump would have to show in it."""
NOISE = 6.0
"""Standard deviations of an output's noise that it steps by anyway."""


def without_lost(t: Array, z: Array, outputs: Sequence[Array]) -> tuple[Array, NDArray[np.intp]]:
    """z (n,) sampled at t (n,) with lost samples on the path through those next to them, and which they were;
    outputs: each (n,), recorded with them."""
    none = np.zeros(0, dtype=np.intp)
    if z.size < 4 * LONGEST or not (np.diff(t) > 0).all():
        return z, none
    step, stroke = np.abs(np.diff(z)), float(np.ptp(np.quantile(z, (FEW, 1 - FEW))))
    ordinary = float(np.quantile(step, 1 - 2 * FEW))
    large = step > max(SURE * noise_std(t, z), STEPS * ordinary, SEEN * stroke)
    if stroke == 0 or not 0 < np.count_nonzero(large) <= 2 * FEW * z.size:
        return z, none
    path, found, speed = z.copy(), none, ordinary / float(np.median(np.diff(t)))
    senses = [_Sense.of(y) for y in outputs]
    for a, b in _runs(np.flatnonzero(large) + 1, z.size):
        filled = _filled(t, path, a, b, speed)
        if filled is not None and not _felt(float(np.abs(z[a:b] - filled).min()) / stroke, senses, a, b):
            path[a:b] = filled
            found = np.append(found, np.arange(a, b))
    return (path, found) if 0 < found.size <= FEW * z.size else (z, none)


def _runs(jumps: NDArray[np.intp], n: int) -> Iterator[tuple[int, int]]:
    """[a, b) of the short parts between `jumps`."""
    edges = [0, *jumps.tolist(), n]
    k = 0
    while k < len(edges) - 1:
        a, b = edges[k], edges[k + 1]
        k += 1
        if b - a <= (AT_AN_END if a == 0 or b == n else LONGEST):
            yield a, b
            k += 1  # what comes after it is the path again


def _filled(t: Array, z: Array, a: int, b: int, speed: float) -> Array | None:
    """(b − a,) the path between the samples before a and from b on, or beyond its end; None where these do
    not go on to each other at an ordinary speed."""
    sides = [slice(max(a - NEAR, 0), a), slice(b, b + NEAR)]
    lines = [np.polyfit(t[s] - t[s][0], z[s], 1) if len(t[s]) == NEAR else None for s in sides]
    before, after = (
        None if line is None else (at, float(np.polyval(line, at - t[s][0])), float(line[0]))
        for line, s, at in zip(lines, sides, (t[a - 1], t[min(b, len(t) - 1)]), strict=True)
    )
    if before is None or after is None:
        known = before or after
        if known is None or 0 < a < b < len(t):
            return None
        return known[1] + known[2] * (t[a:b] - known[0])
    (t0, z0, v0), (t1, z1, v1) = before, after
    jump = min(abs(z[a] - z0), abs(z[b - 1] - z1))
    if abs(z1 - z0) > MISSED * jump + 2 * max(abs(v0), abs(v1), speed) * (t1 - t0):
        return None
    return np.asarray(CubicHermiteSpline([t0, t1], [z0, z1], [v0, v1])(t[a:b]))


@dataclass(frozen=True, eq=False)
class _Sense:
    """What an output shows: its steps (n − 1,), how large these are `anyway`, and its whole range."""

    step: Array
    anyway: float
    range: float

    @staticmethod
    def of(y: Array) -> _Sense:
        step, index = np.abs(np.diff(y)), np.arange(y.size, dtype=np.float64)
        anyway = STEPS * float(np.quantile(step, 1 - 2 * FEW)) + NOISE * noise_std(index, y)
        return _Sense(step, anyway, float(np.ptp(y)))


def _felt(jump: float, senses: Sequence[_Sense], a: int, b: int) -> bool:
    """Whether one of the outputs steps where the run begins or ends, or none would show such a part of the
    stroke."""
    if any(s.step[max(a - 1, 0) : b + NEAR].max() > s.anyway for s in senses):
        return True
    return not any(jump * s.range > FELT * s.anyway for s in senses)
