"""A meter that is not linear, or does not settle: what is left of sweeps is a factor that depends on |Z|
alone, or a part of the reading before.

A voltmeter that clips softly where |Z| is high damps a resonance as drag does, but by the same law in all
recordings and whatever the frequency: no law of any port does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from modelgen.diagnose.gate.gains import CHECKED, gain_of, noise_of, parted
from modelgen.diagnose.gate.in_frequency import whitened
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import COLOUR_SWEEP
from modelgen.diagnose.search.screen import Tangent
from modelgen.fit.series import Array, Series

POWERS = (1, 2, 4, 8, 16)
"""Powers of |Z| over the greatest: Z (1 + Σ a_p |Z|^p)."""
RANGES = 30
"""Moduli at which a meter's range may change."""
SAYS = "a distortion of the meter: Z is off by a factor that depends on its modulus alone"
SWITCHED = "a range of the meter that is switched: where |Z| is above {0:.3g} {1}, Z is off by a factor"
KEPT = "a meter that does not settle: each reading keeps a part of the one before it"


def distorted(judge: Judge, base: Fit) -> Leftover:
    """What real factors that depend on |Z| gain beside the base, at first order; 0 where there are none."""
    return _best(judge, base, _smooth(base.hypothesis.experiment.series))


def misread(judge: Judge, base: Fit) -> Leftover:
    """The same of what no smooth error of an instrument is: a range that is switched at one modulus, and
    readings that keep a part of the one before."""
    series = base.hypothesis.experiment.series
    return _best(judge, base, (x for make in (_switched, _kept) for x in make(series)))


Columns = tuple[str, int, list[Array]]
"""Words, among how many alike it was chosen, and for each sweep complex changes (n, k) of its readings."""


def _smooth(series: Sequence[Series]) -> Iterator[Columns]:
    top = max(float(s.size.max()) for s in series)
    yield SAYS, 1, [s.reference[:, None] * (s.size[:, None] / top) ** np.array(POWERS) for s in series]


def _switched(series: Sequence[Series]) -> Iterator[Columns]:
    size = np.concatenate([s.size for s in series])
    for limit in np.quantile(size, np.linspace(0, 1, RANGES + 2)[1:-1]):
        above = [(s.reference * (s.size > limit))[:, None] * np.array([1, 1j]) for s in series]
        yield SWITCHED.format(limit, series[0].unit), RANGES, above


def _kept(series: Sequence[Series]) -> Iterator[Columns]:
    """Of the sample below in a sweep upwards, of that above in one downwards, in each sweep another part."""
    parts = []
    for k, s in enumerate(series):
        Z = s.reference
        beside = np.stack([np.append(Z[:1], Z[:-1]) - Z, np.append(Z[1:], Z[-1:]) - Z], axis=1)
        parts.append(np.pad(beside, ((0, 0), (2 * k, 2 * (len(series) - 1 - k)))))
    yield KEPT, 1, parts


def _best(judge: Judge, base: Fit, tried: Iterator[Columns]) -> Leftover:
    """What gains most of all that is tried, each with coloured noise of its own."""
    e = base.hypothesis.experiment
    series, ports = e.series, {p.name for p in e.model.ports}
    none = Leftover(0.0, 0.0, "", "")
    if any(s.measure != "complex" for s in series):
        return none
    port = "electrical" if "electrical" in ports else min(ports, default="model")
    tangent, n = Tangent.of(*judge.tangent(base)), effective(base.white)
    found = []
    for says, among, parts in tried:
        columns = whitened(judge, series, np.concatenate(parts))
        price = 2 * float(np.log(among))
        gain, chi2, left = gain_of(tangent, columns, n, price)
        found.append((gain, chi2, says, left, price + columns.shape[1] * float(np.log(n))))
    gain, chi2, says, left, price = max(found, key=lambda x: x[0])
    if gain > CHECKED:
        before = noise_of(judge, base.white, COLOUR_SWEEP)[0]
        after = noise_of(judge, parted(left, base.white), COLOUR_SWEEP)[0]
        gain = min(gain, before - after - price)
    return Leftover(gain, chi2, port, says)
