"""Evidence for a fitted hypothesis: profile likelihood over the unknown noise level, with a price for each
parameter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modelgen.fit.series import Array, Series

TRUST_STATED, TRUST_ESTIMATED = 12.0, 1.0
"""How many samples' worth of belief a noise level deserves that is stated, or estimated from neighbours."""


@dataclass(frozen=True)
class Level:
    """Prior on the noise of one recording: `count` samples' worth of a variance 1 (in whitened units)."""

    count: float


def levels(series: Sequence[Series]) -> tuple[Level, ...]:
    return tuple(Level(TRUST_STATED if s.stated else TRUST_ESTIMATED) for s in series)


def deviance(white: Sequence[Array], prior: Sequence[Level]) -> float:
    """−2 ln of the likelihood of whitened residuals with each recording's noise level profiled out.

    Σ (N + ν) ln((Σe² + ν)/(N + ν)): for a level that is right about Σe² − N, and robust where it is wrong.
    """
    total = 0.0
    for e, p in zip(white, prior, strict=True):
        n = int(np.count_nonzero(e))
        total += (n + p.count) * float(np.log((float(np.sum(e**2)) + p.count) / (n + p.count)))
    return total


def effective(white: Sequence[Array]) -> int:
    """Number of residuals that weigh something."""
    return max(2, sum(int(np.count_nonzero(e)) for e in white))


def bic(
    white: Sequence[Array], prior: Sequence[Level], parameters: int, own: int = 0, temper: float = 1.0
) -> float:
    """Bayes' information criterion. Small samples pay more (AICc's correction), so that five points can't buy
    four numbers."""
    n = effective(white)
    k = parameters + own
    known = n + sum(p.count for p in prior)
    small = 2.0 * k * (k + 1) / max(known - k - 1, 1.0) if n < 200 else 0.0
    return deviance(white, prior) / temper + k * float(np.log(max(n / temper, 3.0))) + small
