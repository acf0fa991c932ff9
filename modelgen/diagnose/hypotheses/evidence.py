"""Evidence for a fitted hypothesis: profile likelihood over the unknown noise level, with a price for each
parameter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modelgen.fit.series import Array, Series

TRUST_STATED, TRUST_ESTIMATED = 12.0, 1.0
"""How many samples' worth of belief a noise level deserves that is stated, or estimated from neighbours."""

LONE = 15.0
"""Squares of residuals count at most this many times their mean: −2 ln of one in a hundred samples with an
error
ten times the noise."""


@dataclass(frozen=True)
class Level:
    """Prior on the noise of one recording: `count` samples' worth of a variance 1 (in whitened units)."""

    count: float


@dataclass(frozen=True)
class Smooth:
    """A smooth relative error of an instrument: rms in units of the noisiest sweep's own noise; length in
    ln f; shared: the same in all sweeps."""

    rms: float
    length: float
    shared: bool


def levels(series: Sequence[Series]) -> tuple[Level, ...]:
    return tuple(Level(TRUST_STATED if s.stated else TRUST_ESTIMATED) for s in series)


RUNAWAY = 1e100
"""A simulation that is so many standard deviations off has run away; its square would overflow."""


def deviance(white: Sequence[Array], prior: Sequence[Level], robust: bool = False) -> float:
    """−2 ln of the likelihood of whitened residuals with each recording's noise level profiled out.

    `robust`: no lone sample counts more than LONE times the mean.

    Σ (N + ν) ln((Σe² + ν)/(N + ν)): for a level that is right about Σe² − N, and robust where it is wrong.
    """
    total = 0.0
    for e, p in zip(white, prior, strict=True):
        n = int(np.count_nonzero(e))
        if not np.max(np.abs(e), initial=0.0) < RUNAWAY:
            return float("inf")
        square = settled(e) if robust else float(np.sum(e**2))
        total += (n + p.count) * float(np.log((square + p.count) / (n + p.count)))
    return total


def settled(e: Array) -> float:
    """Σe² with no sample counted beyond LONE times the mean: a few that stand alone are no evidence for
    physics."""
    square = np.asarray(e[e != 0] ** 2).ravel()
    if not square.size:
        return 0.0
    mean = float(np.mean(square))
    for _ in range(20):
        mean = float(np.mean(np.minimum(square, LONE * mean)))
    return mean * square.size


def effective(white: Sequence[Array]) -> int:
    """Number of residuals that weigh something."""
    return max(2, sum(int(np.count_nonzero(e)) for e in white))


def bic(
    white: Sequence[Array],
    prior: Sequence[Level],
    parameters: int,
    own: int = 0,
    robust: bool = False,
    temper: float = 1.0,
) -> float:
    """Bayes' information criterion; `temper` residuals in a row count as one.

    Small samples pay more (AICc's correction), so that five points can't buy four numbers.
    """
    n = effective(white)
    k = parameters + own
    known = n + sum(p.count for p in prior)
    small = 2.0 * k * (k + 1) / max(known - k - 1, 1.0) if n < 200 else 0.0
    return deviance(white, prior, robust) / temper + k * float(np.log(max(n / temper, 3.0))) + small
