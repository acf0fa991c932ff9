"""Recordings that are simulated, without noise: what a model leaves of them is arithmetic and rounding."""

from __future__ import annotations

import numpy as np

from modelgen.diagnose.gate.gate import Gate
from modelgen.diagnose.gate.leftover import NOTHING
from modelgen.diagnose.hypotheses.ranking import OUTSIDE
from modelgen.diagnose.hypotheses.refit import Fit, mean_square, plain_white
from modelgen.diagnose.hypotheses.setting import Outcome
from modelgen.fit.series import Array, Series

EXACT = 1e-5
"""Residuals, relative to an impedance or to the range of another output, below which there is no physics in
them: no instrument repeats so well, and six digits are no finer."""


def exact(base: Fit) -> bool:
    """Whether the base leaves no more than arithmetic and rounding do, which have steps and rows of their own
    that a search would explain."""
    e = base.hypothesis.experiment
    return all(recorded_exactly(s, e.raw(base.theta, k)) for k, s in enumerate(e.series))


def recorded_exactly(s: Series, left: Array) -> bool:
    """That of one recording with residuals `left` (channels, n): each output by itself, as units differ."""
    whole = np.ptp(s.data, axis=1, keepdims=True) if s.measure == "real" else s.size
    share = left / np.maximum(whole, 1e-300)
    return bool(np.all(np.mean(share**2, axis=1) < EXACT**2))


def nothing_left(outcome: Outcome, enough: bool) -> Gate:
    """The gate on that: nothing is missing.

    enough: data are more than parameters, of which as many fit anything exactly, noise and all.
    """
    floor = max(mean_square(plain_white(outcome.base)), 1e-300)
    words = "next to nothing, as of simulated recordings that hold no noise"
    notes = (NOTE,) if enough else ()
    return Gate(False, NOTHING, 1 - OUTSIDE, floor, float(np.sqrt(floor)), words, notes)


NOTE = "the model leaves no more than arithmetic and rounding do: these recordings hold no noise"
