"""A meter that is not linear, does not settle or whose reference creeps: changes of sweeps' readings by a
factor that depends on |Z| alone or on time, of one part of them alone, or by some of the reading before.

A voltmeter that clips softly where |Z| is high damps a resonance as drag does, but by the same law in all
recordings and whatever the frequency: no law of any port does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise, product

import numpy as np

from modelgen.fit.series import Array, Series

POWERS = (1, 2, 4, 8, 16)
"""Powers of |Z| over the greatest: Z (1 + Σ a_p |Z|^p)."""
WAVES = (4, 8, 16)
"""Half waves over ln |Z|, all up to one of these together: Z (1 + Σ a_p cos pπx), as a chain of amplifiers or
limiters makes."""
RANGES = 100
"""Moduli at which a meter's range may change."""
DISTORTED = "a distortion of the meter: Z is off by a factor that depends on its modulus alone"
SWITCHED = "a range of the meter that is switched: where |Z| is above {0:.3g} {1}, Z is off by a factor"
TIMES = (0.03, 0.1, 0.3, 1.0)
"""Times of a sweep after which a reference creeps but with the logarithm of the time; of two that are
neighbours any between them is made."""
CREPT = "a phase of the reference that creeps with time, ever slower"
SKEWED = "a detector whose two parts are not at right angles, or not read with one gain"
KEPT = "a meter that does not settle: each reading keeps a part of the one before it"
ANY_WAY = 4
"""Sweeps of which each may have been taken in any direction; of more all are upwards."""
Columns = tuple[str, int, list[Array]]
"""Words, among how many alike it was chosen, and for each sweep complex changes (n, k) of its readings."""


def distorted(series: Sequence[Series]) -> Iterator[Columns]:
    """Real factors that are powers of |Z|, or waves over its logarithm."""
    low, top = min(float(s.size.min()) for s in series), max(float(s.size.max()) for s in series)
    x = [s.size[:, None] / top for s in series]
    factors = [[u ** np.array(POWERS) for u in x]]
    if 0 < low < top:
        turns = [np.pi * np.log(u) / np.log(low / top) for u in x]
        factors += [[np.cos(u * np.arange(1, most + 1)) for u in turns] for most in WAVES]
    for factor in factors:
        parts = [s.reference[:, None] * a for s, a in zip(series, factor, strict=True)]
        yield DISTORTED, len(factors), parts


def switched(series: Sequence[Series]) -> Iterator[Columns]:
    size = np.concatenate([s.size for s in series])
    for limit in np.quantile(size, np.linspace(0, 1, RANGES + 2)[1:-1]):
        above = [(s.reference * (s.size > limit))[:, None] * np.array([1, 1j]) for s in series]
        yield SWITCHED.format(limit, series[0].unit), RANGES, above


def kept(series: Sequence[Series]) -> Iterator[Columns]:
    """Of the sample below in a sweep upwards, of that above in one downwards, in each sweep another part."""
    parts = []
    for k, s in enumerate(series):
        Z = s.reference
        beside = np.stack([np.append(Z[:1], Z[:-1]) - Z, np.append(Z[1:], Z[-1:]) - Z], axis=1)
        parts.append(np.pad(beside, ((0, 0), (2 * k, 2 * (len(series) - 1 - k)))))
    yield KEPT, 1, parts


def skewed(series: Sequence[Series]) -> Iterator[Columns]:
    """A detector's two references are not at right angles, so that one part is read with some of the other;
    or the gain of one part is not that of the other."""
    for across, part in product((1, 1j), ("real", "imag")):
        yield SKEWED, 4, [across * getattr(s.reference, part)[:, None] for s in series]


def crept(series: Sequence[Series]) -> Iterator[Columns]:
    """As ln(1 + t/τ) from the first sweep on, or in each anew, each taken upwards or downwards.

    Not anew in sweeps that all go one way: that is one smooth error over frequency, as any instrument has.
    """
    rising = [bool(f[-1] > f[0]) for f in (next(iter(s.inputs.values())) for s in series)]
    ways = list(product((0, 1), repeat=len(series))) if len(series) <= ANY_WAY else [(0,) * len(series)]
    alike = [len({up != turned for up, turned in zip(rising, down, strict=True)}) == 1 for down in ways]
    begun = [(0, down) for down in ways if len(series) > 1]
    begun += [(1, down) for down, one in zip(ways, alike, strict=True) if not one]
    for taus, (anew, down) in product(pairwise(TIMES), begun):
        parts = []
        for k, (s, reverse) in enumerate(zip(series, down, strict=True)):
            t = abs(reverse - np.arange(s.n) / s.n) + (0 if anew else k)
            parts.append(1j * s.reference[:, None] * np.log1p(t[:, None] / taus))
        yield CREPT, (len(TIMES) - 1) * len(begun), parts
