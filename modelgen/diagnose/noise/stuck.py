"""Readings that were lost while the recorder went on: runs of one and the same value, a zero or the last good
one, off which the record jumps back to where the model is."""

from __future__ import annotations

import numpy as np

from modelgen.fit.series import Array
from modelgen.recordings.runs import runs

SURE = 6.0
"""Robust standard deviations that a lost reading is off."""
EDGE = 5.5
"""Times the greatest residual of those next to a run that its own ends are off: no physics ends so."""
NEXT = 3
"""Samples next to a run that are as good as any."""
ODD = 1e-3
"""Probability below which so long a run is no accident of rounding."""
MOST = 0.1
"""A larger share of the samples is not lost: so the record is."""


def stuck(data: Array, white: Array) -> Array:
    """(n,) bool: lost readings of a record, from its data (channels, n) and whitened residuals."""
    found = np.zeros(white.shape[1], dtype=bool)
    for y, x in zip(data, np.abs(white), strict=True):
        same = y[1:] == y[:-1]
        level = max(1.4826 * float(np.median(x)), 1e-300)
        usual = float(np.mean(same))
        for a, b in ((a, b + 1) for a, b in runs(same)):
            begins, ends = x[max(a - NEXT, 0) : a], x[b : b + NEXT]
            jumps, returns = (
                off > max(SURE * level, EDGE * beside.max(initial=0.0))
                for off, beside in ((x[a], begins), (x[b - 1], ends))
            )
            held = ends.size > 0 and len(y) * max(usual, 1 / len(y)) ** (b - a - 1) < ODD
            found[a:b] |= bool(returns and (jumps or held))
    return found if found.sum() < MOST * found.size else np.zeros_like(found)
