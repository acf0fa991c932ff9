"""Gaps in a record over time: what moved while the recorder paused is not known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from modelgen.recordings.runs import Array

LONG = 5.0
"""Times the longest step of those near it that a gap is: steps that grow along a record are no gaps."""
NEAR = 10
"""Steps before and after that are near."""
SLOPE = 8
"""Samples on either side by which it is judged how a motion went on."""
MANY = 100
"""Pauses that are counted, and not looked at one by one."""
TOLD = 0.01
"""Of its stroke: so well a motion within a gap is told by a curve between its ends, or nothing is lost."""

ROUNDING = 1e-9
"""Of its values: so much a motion may differ from itself."""


def gaps(t: Array, motions: Sequence[Array]) -> list[int]:
    """Samples k after which a record of times t (n,), increasing, has a gap in which one of the `motions`,
    (n,) each, may have been anywhere; all pauses where they are MANY."""
    step = np.diff(t)
    if step.size < 2 or not (np.isfinite(step) & (step > 0)).all():  # refused later, in words
        return []
    found = [k for k in np.flatnonzero(step > LONG * np.median(step)).tolist() if _stands_out(step, k)]
    return found if len(found) > MANY else [k for k in found if any(_lost(t, z, k) for z in motions)]


def _stands_out(step: Array, k: int) -> bool:
    beside = np.concatenate([step[max(k - NEAR, 0) : k], step[k + 1 : k + 1 + NEAR]])
    return bool(step[k] > LONG * beside.max())


def _lost(t: Array, z: Array, k: int) -> bool:
    """Whether a straight line from sample k to the next is no account of the motion z between them: its
    slopes at either end are others."""
    sides = (slice(max(k + 1 - SLOPE, 0), k + 1), slice(k + 1, k + 1 + SLOPE))
    slopes = [_slope(t[s], z[s]) for s in sides]
    wait = t[k + 1] - t[k]
    between = abs(z[k + 1] - z[k] - wait * sum(slopes) / 2)  # the mean slope is not that of the ends
    bulge = abs(slopes[1] - slopes[0]) * wait / 8
    return bool(max(between, bulge) > TOLD * np.ptp(z) + ROUNDING * np.abs(z).max())


def _slope(t: Array, z: Array) -> float:
    return float(np.polyfit(t - t[0], z, 1)[0]) if t.size > 1 else 0.0
