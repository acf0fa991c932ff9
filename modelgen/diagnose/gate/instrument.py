"""Errors of how sweeps are taken, weighed: what is left is a meter's or a source's, and no physics of the
device.

Each is weighed with coloured noise of its own and beside a smooth error, and so are the named effects that
it is compared with: it is ahead where it is in both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from modelgen.diagnose.gate.axis import mistaken
from modelgen.diagnose.gate.corrected import corrected
from modelgen.diagnose.gate.gains import CHECKED, gain_of, noise_of
from modelgen.diagnose.gate.in_frequency import SPARE, whitened
from modelgen.diagnose.gate.leftover import NOTHING, Leftover
from modelgen.diagnose.gate.meter import crept, distorted, kept, skewed, switched
from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.refit import Fit, Judge, mean_square, refine
from modelgen.diagnose.hypotheses.setting import COLOUR_SWEEP
from modelgen.diagnose.noise.smooth_error import smooth_error
from modelgen.diagnose.search.screen import Tangent
from modelgen.fit.series import Array, Series

Weights = tuple[float, float]
"""−2 ln of the likelihood and the price of all numbers: in coloured noise, and beside a smooth error."""


def misread(judge: Judge, base: Fit) -> Leftover:
    """The error that describes most of what the base leaves of sweeps."""
    series = base.hypothesis.experiment.series
    if any(s.measure != "complex" for s in series):
        return NOTHING
    plain, base = _plainly(judge, base)
    was = _weights(plain, base)
    found = [_read(plain, base, was), _set(plain, base, was)]
    return replace(max(found, key=lambda x: x.gain), port=_port(base))


def lead(judge: Judge, best: Fit, other: Leftover) -> float:
    """By how much such an error is ahead of the effects of `best`."""
    named = _weights(*_plainly(judge, best))
    return min(a - b for a, b in zip(named, other.weights, strict=True))


def _read(plain: Judge, base: Fit, was: Weights) -> Leftover:
    """Readings that are wrong."""
    series = base.hypothesis.experiment.series
    tangent, n = Tangent.of(*plain.tangent(base)), effective(base.white)
    gain, found = 0.0, None
    kinds = distorted, switched, skewed, kept, crept
    for says, among, parts in chain.from_iterable(kind(series) for kind in kinds):
        if n - base.parameters - parts[0].shape[1] < SPARE:
            continue
        columns = whitened(plain, series, np.concatenate(parts))
        price = 2 * float(np.log(among))
        if (gained := gain_of(tangent, columns, n, price)[0]) > max(gain, CHECKED):
            gain, found = gained, (says, price, parts, columns)
    if found is None:
        return NOTHING
    says, price, parts, columns = found
    changes = [np.stack([x.T.real, x.T.imag]) for x in parts]

    def without(amounts: Array) -> tuple[Series, ...]:
        pairs = zip(series, changes, strict=True)
        return tuple(replace(s, data=s.data - np.tensordot(x, amounts, (1, 0))) for s, x in pairs)

    fit, _ = corrected(plain, base, lambda _: columns, without)
    price += columns.shape[1] * float(np.log(n))
    return _weighed(was, base, fit, says, price, _weights(plain, fit, changes))


def _set(plain: Judge, base: Fit, was: Weights) -> Leftover:
    """Frequencies that are."""
    found = mistaken(plain, base)
    return NOTHING if found is None else _weighed(was, base, *found, _weights(plain, found[0]))


def _weighed(was: Weights, base: Fit, fit: Fit, says: str, price: float, weights: Weights) -> Leftover:
    """A description, with no more gain than it has in either noise; `price` of its own numbers."""
    priced = [x + price for x in weights]
    gain = min(base.bic - fit.bic - price, *(a - b for a, b in zip(was, priced, strict=True)))
    rest = f"{says}; without it {np.sqrt(mean_square(fit.white)):.3g} times the noise would be left"
    return Leftover(gain, base.chi2 - fit.chi2, "", rest, weights=tuple(priced))


def _weights(plain: Judge, fit: Fit, beside: Sequence[Array] = ()) -> Weights:
    """Weights of a fit; the smooth error `beside` free amounts of changes."""
    white, process, _ = smooth_error(plain, fit, beside)
    numbers = fit.parameters * float(np.log(effective(fit.white))) - 2 * fit.hypothesis.log_common
    return noise_of(plain, fit.white, COLOUR_SWEEP)[0] + numbers, white - process


def _plainly(judge: Judge, fit: Fit) -> tuple[Judge, Fit]:
    """Both without coloured noise, or a smooth error that nobody stated."""
    series = fit.hypothesis.experiment.series
    plain = Judge(tuple(replace(s.whitener, ar=None) for s in series), judge.prior)
    if judge.smooth is None:
        return plain, plain.look(fit.hypothesis, fit.theta)
    return plain, refine(plain, [fit])[0]


def _port(base: Fit) -> str:
    ports = {p.name for p in base.hypothesis.experiment.model.ports}
    return "electrical" if "electrical" in ports else min(ports, default="model")
