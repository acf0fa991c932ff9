"""Recordings that are simulated, without noise: what a model leaves of them is arithmetic and rounding."""

from __future__ import annotations

import numpy as np

from modelgen.diagnose.gate.gate import Gate
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.hypotheses.ranking import OUTSIDE
from modelgen.diagnose.hypotheses.refit import Fit, plain_white
from modelgen.diagnose.hypotheses.setting import Outcome

EXACT = 1e-5
"""Residuals, relative to an impedance or to the range of another output, below which there is no physics in
them: no instrument repeats so well, and six digits are no finer."""


def exact(base: Fit) -> bool:
    """Whether the base leaves no more than arithmetic and rounding do, which have steps and rows of their own
    that a search would explain."""
    e = base.hypothesis.experiment
    for k, s in enumerate(e.series):
        left = e.raw(base.theta, k)
        whole = np.ptp(s.data, axis=1, keepdims=True) if s.measure == "real" else s.size
        if np.mean(left**2) * len(left) > EXACT**2 * np.mean(whole**2):
            return False
    return True


def nothing_left(outcome: Outcome) -> Gate:
    """The gate on that: nothing is missing."""
    count = sum(e.size for e in plain_white(outcome.base))
    floor = max(sum(float(np.sum(e**2)) for e in plain_white(outcome.base)) / count, 1e-300)
    words = "next to nothing, as of simulated recordings that hold no noise"
    return Gate(False, Leftover(0.0, 0.0, "", ""), 1 - OUTSIDE, floor, float(np.sqrt(floor)), words, (NOTE,))


NOTE = "the model leaves no more than arithmetic and rounding do: these recordings hold no noise"
