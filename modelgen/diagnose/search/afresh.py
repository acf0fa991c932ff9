"""Where no single effect comes near the recordings: searches that don't begin at the base's optimum, which
what is missing may have bent too far for a way back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modelgen.diagnose.hypotheses.refit import Fit, Judge, plain_white
from modelgen.diagnose.hypotheses.setting import ALARM, Setting
from modelgen.diagnose.hypotheses.starts import base_starts
from modelgen.diagnose.search.far import beyond_scatter
from modelgen.fit.series import Array

HOPE = 2.0
"""Times the χ² of a fit that is there, which descents from elsewhere must reach in their first steps."""
ASTRAY = 5.0
"""Residuals of the best fit this many times the scatter: the base has no optimum near the truth, …"""
DECADES, FRESH = 2.0, 32
"""… and descents start all over, from so many points that lie within so many decades of its defaults."""
BETTER = 4.0
"""Times smaller that the square of a recording's residual is when the base is fitted to it alone: what the
others show, which it doesn't, is what bends the base."""


def afresh(s: Setting, base: Fit, judge: Judge, fits: Sequence[Fit]) -> list[Fit]:
    """`fits` of sweeps, where none is near the recordings again from all over the parameters' range: what an
    effect as large as the base itself has bent, no descent brings back."""
    if not _astray(base, fits):
        return list(fits)
    h, rng = base.hypothesis, np.random.default_rng(0)
    defaults = base_starts(h, 0, 1)[0]

    def scattered(f: Fit) -> tuple[Fit, list[Array]]:
        grid, span = f.hypothesis.added[-1].grid, np.log(10.0) * DECADES
        starts = [
            f.hypothesis.place(h, defaults * np.exp(rng.uniform(-span, span, len(defaults))), own)
            for own in (grid[k] for k in rng.integers(len(grid), size=FRESH))
        ]
        return f, starts

    def again(found: tuple[Fit, list[Array]]) -> Fit:
        f, starts = found
        return min(f, judge.fit(f.hypothesis, starts, worth=HOPE * f.chi2), key=lambda f: f.bic)

    return s.each(again, [scattered(f) for f in fits])


def elsewhere(s: Setting, base: Fit, judge: Judge, fits: Sequence[Fit]) -> list[Fit]:
    """Over time, where no fit is near the recordings: the base as it is fitted to a recording alone, of each
    that it then is far nearer to."""
    h, series = base.hypothesis, base.hypothesis.experiment.series
    if not _astray(base, fits) or len(series) < 2:
        return []
    bent = [float(np.sum(e**2)) for e in plain_white(base)]

    def alone(k: int) -> Fit | None:
        others = [w if m == k else w.masked(np.zeros(series[m].n)) for m, w in enumerate(judge.whiteners)]
        f = replace(judge, whiteners=tuple(others)).fit(h, [base.theta, *base_starts(h, 0, 1)])
        there = judge.look(h, f.theta)
        return there if BETTER * float(np.sum(plain_white(there)[k] ** 2)) < bent[k] else None

    return [f for f in s.each(alone, range(len(series))) if f is not None]


def _astray(base: Fit, fits: Sequence[Fit]) -> bool:
    """Whether even the best of `fits`, which explains something, is far from the recordings."""
    best = min(fits, key=lambda f: f.chi2, default=base)
    return base.bic - best.bic >= ALARM and beyond_scatter(best) >= ASTRAY
