"""How far a fit is from the recordings, by what neighbours scatter."""

from __future__ import annotations

import numpy as np

from modelgen.diagnose.hypotheses.refit import Fit, plain_white
from modelgen.fit.scatter import local_scatter

BENT = 1.1
"""Residuals this many times the scatter between neighbours: the first orders of a
bent base tell little."""
FEWEST = 15
"""Samples that tell a scatter."""


def beyond_scatter(f: Fit) -> float:
    """How many times as large as the scatter between neighbours a fit's residuals are."""
    over = [
        float(np.mean(x**2)) / local_scatter(x) ** 2 for e in plain_white(f) for x in e if x.size > FEWEST
    ]
    return float(np.sqrt(np.mean(over))) if over else 1.0
