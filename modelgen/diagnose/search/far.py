"""How far a fit is from the recordings, by what neighbours scatter."""

from __future__ import annotations

import numpy as np

from modelgen.diagnose.hypotheses.refit import Fit, plain_white
from modelgen.diagnose.noise.noise import scatter

BENT = 1.1
"""Residuals this many times the scatter between neighbours: the first orders of a
bent base tell little."""
FAR = 2.0
"""… this many times: no small effect leaves that, and a base that does is bent far."""
FEWEST = 15
"""Samples that tell a scatter."""


def beyond_scatter(f: Fit) -> float:
    """How many times as large as the scatter between neighbours a fit's residuals are."""
    pairs = zip(f.hypothesis.experiment.series, plain_white(f), strict=True)
    over = [float(np.mean(x**2)) / scatter(s, x) ** 2 for s, e in pairs for x in e if x.size > FEWEST]
    return float(np.sqrt(np.mean(over))) if over else 1.0
