"""A meter that is not linear, or does not settle: what is left of sweeps is a factor that depends on |Z|
alone, or a part of the reading before.

A voltmeter that clips softly where |Z| is high damps a resonance as drag does, but by the same law in all
recordings and whatever the frequency: no law of any port does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from modelgen.diagnose.gate.gains import CHECKED, gain_of, noise_of, parted
from modelgen.diagnose.gate.in_frequency import whitened
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.refit import Fit, Judge, refine
from modelgen.diagnose.hypotheses.setting import COLOUR_SWEEP
from modelgen.diagnose.noise.smooth_error import smooth_error
from modelgen.diagnose.search.screen import Tangent
from modelgen.fit.series import Array, Series

POWERS = (1, 2, 4, 8, 16)
"""Powers of |Z| over the greatest: Z (1 + Σ a_p |Z|^p)."""
RANGES = 100
"""Moduli at which a meter's range may change."""
SAYS = "a distortion of the meter: Z is off by a factor that depends on its modulus alone"
SWITCHED = "a range of the meter that is switched: where |Z| is above {0:.3g} {1}, Z is off by a factor"
KEPT = "a meter that does not settle: each reading keeps a part of the one before it"


def distorted(judge: Judge, base: Fit) -> Leftover:
    """What real factors that depend on |Z| gain beside the base, at first order; 0 where there are none."""
    series = base.hypothesis.experiment.series
    if any(s.measure != "complex" for s in series):
        return NONE
    columns = whitened(judge, series, np.concatenate(list(_smooth(series))))
    gain, chi2, _ = gain_of(Tangent.of(*judge.tangent(base)), columns, effective(base.white))
    return Leftover(gain, chi2, _port(base), SAYS)


def misread(judge: Judge, base: Fit) -> Leftover:
    """The same of what no smooth error of an instrument is: a range that is switched at one modulus, and
    readings that keep a part of the one before. Each with coloured noise of its own, or a smooth error."""
    series = base.hypothesis.experiment.series
    if any(s.measure != "complex" for s in series):
        return NONE
    plain = Judge(tuple(replace(s.whitener, ar=None) for s in series), judge.prior)
    base = plain.look(base.hypothesis, base.theta) if judge.smooth is None else refine(plain, [base])[0]
    tangent, n = Tangent.of(*plain.tangent(base)), effective(base.white)
    found = []
    for says, among, parts in [*_switched(series), *_kept(series)]:
        columns = whitened(plain, series, np.concatenate(parts))
        price = 2 * float(np.log(among))
        gain, chi2, left = gain_of(tangent, columns, n, price)
        found.append((gain, chi2, says, left, price + columns.shape[1] * float(np.log(n)), parts))
    gain, chi2, says, left, price, parts = max(found, key=lambda x: x[0])
    if gain > CHECKED:
        before = noise_of(plain, base.white, COLOUR_SWEEP)[0]
        after = noise_of(plain, parted(left, base.white), COLOUR_SWEEP)[0]
        gain = min(gain, before - after - price, _beside_smooth(plain, base, parts) - price)
    return Leftover(gain, chi2, _port(base), says)


def is_misread(x: Leftover) -> bool:
    """Whether a description is one of `misread`."""
    return x.says == KEPT or x.says.startswith(SWITCHED.partition("{")[0])


def _beside_smooth(plain: Judge, base: Fit, parts: Sequence[Array]) -> float:
    """By how much −2 ln of the likelihood falls with amounts of changes (n, k) of each sweep, where either
    side may have a smooth error of the instrument."""
    changes = [np.stack([x.T.real, x.T.imag]) for x in parts]
    (alone, process, _), (white, beside, _) = smooth_error(plain, base), smooth_error(plain, base, changes)
    return (alone - process) - (white - beside)


def _port(base: Fit) -> str:
    ports = {p.name for p in base.hypothesis.experiment.model.ports}
    return "electrical" if "electrical" in ports else min(ports, default="model")


NONE = Leftover(0.0, 0.0, "", "")
Columns = tuple[str, int, list[Array]]
"""Words, among how many alike it was chosen, and for each sweep complex changes (n, k) of its readings."""


def _smooth(series: Sequence[Series]) -> Iterator[Array]:
    top = max(float(s.size.max()) for s in series)
    return (s.reference[:, None] * (s.size[:, None] / top) ** np.array(POWERS) for s in series)


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
