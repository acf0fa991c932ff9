"""The base model's fit, from many starts, and its other optima."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.hypothesis import Hypothesis
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.starts import base_starts
from modelgen.fit.series import Array
from modelgen.fit.swarms import scattered, swarmed


def fit_base(h: Hypothesis, judge: Judge, seed: int) -> tuple[Fit, tuple[Array, ...]]:
    """The base from many starts, those of swarms among them where samples are independent; and its other
    optima.

    First as if all errors were independent, then under the judge: a smooth error in the covariance hides
    where a far start is wrong, and a search gets lost. A base that lacks an effect may be bent so far that
    another optimum is the one near the truth.
    """
    plain = Judge(tuple(replace(w, root=None, ar=None) for w in judge.whiteners), judge.prior)
    starts = base_starts(h, seed, 12)
    fits = [plain.fit(h, [start], iterations=150) for start in starts]
    if any(s.measure != "real" for s in h.experiment.series):
        fits += _swarmed(h, plain, fits, starts[0], seed)
        if _best(fits).chi2 > ASTRAY**2 * effective(fits[0].white):
            known = _best(fits).theta
            further = scattered(h.experiment.problem(known, plain.whiteners), seed, known)
            fits.append(plain.fit(h, [further], iterations=150))
    ends = [judge.fit(h, [f.theta], iterations=150) for f in _distinct(fits)]
    first = soundest(ends)
    return first, tuple(f.theta for f in _distinct(ends) if f is not first)[:2]


ASTRAY = 5.0
"""Times the noise that the base leaves from which an optimum that has run to an end of its range is none, if
there is another: a base that is all wrong fits best where a part of it is switched off."""


def soundest(ends: Sequence[Fit]) -> Fit:
    """The best of a base's optima; far from the recordings, of those within the parameters' range."""
    if _best(ends).chi2 > ASTRAY**2 * effective(ends[0].white):
        ends = [f for f in ends if not _run_away(f)] or ends
    return _best(ends)


def _run_away(f: Fit) -> bool:
    """Whether a parameter is at an end of its bounds that is not 0."""
    ends = np.array([p.bounds for p in f.hypothesis.experiment.layout.parameters])
    near = np.isfinite(ends) & np.isclose(f.theta[:, None], ends, rtol=1e-6, atol=0.0)
    return bool(np.any(near & (ends != 0)))


COMPARABLE = 10.0
"""Optima with so many times the χ² of the best are looked into further."""


def _distinct(fits: Sequence[Fit]) -> list[Fit]:
    """The best, and what is not much worse and elsewhere: another optimum or, in a sweep that leaves some
    parameters open, another place of a valley, as what an effect does may differ along it."""
    found: list[Fit] = []
    for f in sorted((f for f in fits if np.isfinite(f.bic)), key=lambda f: f.chi2):
        worse = not found or (1 + 1e-3) * found[-1].chi2 + 1.0 < f.chi2
        if (worse or _apart(f, found)) and (not found or f.chi2 < COMPARABLE * found[0].chi2):
            found.append(f)
    return found or list(fits[:1])


VALLEY = 0.3
"""Relative difference of a parameter by which two places of a valley are apart."""


def _apart(fit: Fit, others: Sequence[Fit]) -> bool:
    """Whether a sweep's fit lies elsewhere than each of `others`."""
    if fit.hypothesis.experiment.model.is_time_model:
        return False
    return all(np.any(np.abs(fit.theta - f.theta) > VALLEY * np.abs(f.theta)) for f in others)


def _swarmed(h: Hypothesis, plain: Judge, fits: Sequence[Fit], centre: Array, seed: int) -> list[Fit]:
    """Fits from where swarms about `centre` end."""

    def descend(theta: Array) -> Fit:
        return plain.fit(h, [theta], iterations=150)

    problem = h.experiment.problem(centre, plain.whiteners)
    return swarmed(problem, seed, descend, lambda f: f.chi2, _best(fits).chi2)


def _best(fits: Sequence[Fit]) -> Fit:
    return min(fits, key=lambda f: f.chi2 if np.isfinite(f.bic) else np.inf)
