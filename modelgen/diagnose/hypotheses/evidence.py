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
    """Prior on the noise of one recording: `count` samples' worth of a variance 1 (in whitened units).

    own: (n,) share of the noise itself in the variance of each sample, or None where it is all: the rest is
    what errors of a recorded motion make of it.
    """

    count: float
    own: Array | None = None


@dataclass(frozen=True)
class Smooth:
    """A smooth relative error of an instrument: rms in units of the noisiest sweep's own noise; length in
    ln f; shared: the same in all sweeps."""

    rms: float
    length: float
    shared: bool


def levels(series: Sequence[Series]) -> tuple[Level, ...]:
    return tuple(Level(TRUST_STATED if s.stated else TRUST_ESTIMATED, _own(s)) for s in series)


def _own(s: Series) -> Array | None:
    """What `Level` says of a series: only errors of a motion are smeared."""
    return None if s.whitener.share is None or s.whitener.smear is None else s.whitener.share**2


TINY = 1e-300
"""Sum of squares of nothing: its logarithm is finite."""
RUNAWAY = 1e100
"""A simulation that is so many standard deviations off has run away; its square would overflow."""


def deviance(white: Sequence[Array], prior: Sequence[Level], robust: bool = False) -> float:
    """−2 ln of the likelihood of whitened residuals with each recording's noise level profiled out.

    `robust`: no lone sample counts more than LONE times the mean.

    Σ (N + ν) ln((Σe² + ν)/(N + ν)): for a level that is right about Σe² − N, and robust where it is wrong.
    """
    total = 0.0
    for e, p in zip(white, prior, strict=True):
        if not np.max(np.abs(e), initial=0.0) < RUNAWAY:
            return float("inf")
        total += profiled(settled(e) if robust else e**2, p.own, p.count)
    return total


def profiled(square: Array, own: Array | None, count: float = 0.0) -> float:
    """−2 ln of the likelihood of squares of residuals, 0 where they weigh nothing, at their likeliest level.

    own: the noise's share in their variances, as in `Level`. What errors of a motion leave is no measure of
    the noise: a level below 1 is that of the noise alone, one above 1 that of both. count: as in `Level`.
    """
    used = square != 0
    n, chi2 = max(int(np.count_nonzero(used)), 1) + count, float(np.sum(square)) + count + TINY
    if own is None:
        return n * float(np.log(chi2 / n))
    most = max(chi2 / n, 1.0)
    share = own * used
    size, part = float(np.sum(share)) + count + TINY, float(np.sum(share * square)) + count + TINY
    least = min(part / size, 1.0)
    above = n * float(np.log(most)) + chi2 / most
    return float(min(above, size * np.log(least) + part / least - part + chi2) - n)


def settled(e: Array) -> Array:
    """e², none counted beyond LONE times the mean of all: a few samples that stand alone are no evidence for
    physics."""
    square = np.asarray(e**2)
    used = square[square != 0]
    mean = float(np.mean(used)) if used.size else 0.0
    for _ in range(20):
        mean = float(np.mean(np.minimum(used, LONE * mean))) if used.size else 0.0
    return np.minimum(square, LONE * mean)


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
