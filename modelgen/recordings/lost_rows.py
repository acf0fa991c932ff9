"""Rows that a recorder lost: all columns hold one and the same value, zeros or the last good row, and then
jump to where they would have been."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from modelgen.recordings.runs import Array, runs

SHORTEST = 3
"""Rows alike that are no accident."""
MOST = 0.1
"""A larger share of the rows is how the record is: one at rest, or rounded."""
SELDOM = 0.01
"""Rows that are like the one before outside such runs, at most: elsewhere all columns change."""
BEYOND = 3.0
"""Times the largest step of those near it that a jump is."""
NEAR = 10
"""Rows before and after a run that say how large steps are."""


def lost_rows(columns: Sequence[Array]) -> Array:
    """(n,) bool: rows that were lost, of columns (n,) each."""
    n = len(columns[0])
    none = np.zeros(n, dtype=bool)
    moving = [np.asarray(y) for y in columns if np.any(y != y[0])]
    if len(moving) < 2 and not any(map(np.iscomplexobj, moving)):
        return none  # of a single real column nothing tells a lost row from a value that stays
    same = np.all([y[1:] == y[:-1] for y in moving], axis=0)
    steps = [np.abs(np.diff(y)) for y in moving]
    found, alike = none.copy(), int(same.sum())
    for a, b in ((a, b + 1) for a, b in runs(same) if b + 1 - a >= SHORTEST):
        alike -= b - a - 1
        before, after = (
            any(_jumps(d, at, near) for d in steps)
            for at, near in ((a - 1, slice(max(a - 1 - NEAR, 0), max(a - 1, 0))), (b - 1, slice(b, b + NEAR)))
        )
        if after or (b == n and before):
            found[a if before else a + 1 : b] = True
    return found if found.sum() <= MOST * n and alike <= SELDOM * n else none


def _jumps(steps: Array, at: int, near: slice) -> bool:
    """Whether the step number `at` is far beyond all `near` it."""
    beside = steps[near]
    return 0 <= at < steps.size and beside.size > 0 and bool(steps[at] > BEYOND * beside.max())
