"""What a planned recording would do to rival hypotheses: made as one of them says, and all the others fitted
to it and to what is there already."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import erf, hypot, log, sqrt

import numpy as np

from modelgen.diagnose.experiment.menu import Plan
from modelgen.diagnose.experiment.rivals import Rivals
from modelgen.diagnose.experiment.simulate import joined, simulated
from modelgen.diagnose.hypotheses.addition import Addition, ranged, widened
from modelgen.diagnose.hypotheses.bounds import free
from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.refit import Fit
from modelgen.diagnose.hypotheses.scales import record_scales
from modelgen.diagnose.hypotheses.setting import CLOSE
from modelgen.errors import InputError
from modelgen.fit import GaussNewton
from modelgen.fit.experiment import Layout
from modelgen.fit.problem import Problem
from modelgen.fit.series import Array, Series

SPREAD = 4
"""Further starting points for each effect of a rival that has shapes."""


@dataclass(frozen=True)
class Exclusion:
    """χ² and BIC by which a rival would stay behind the truth in old and new recording, and how likely it is
    that it would be excluded."""

    behind: float
    lead: float
    chance: float


def excluded(rivals: Rivals, plan: Plan, i: int) -> Exclusion:
    """The hardest to exclude of all other rivals, if hypothesis `i` is what is there.

    Each has all its parameters fitted again, its shapes free in the ranges that the new recording opens.
    """
    truth, made = rivals.fits[i], simulated(rivals, rivals.fits[i], plan)
    worst: Exclusion | None = None
    if made is None:
        return NOT
    for rival in rivals.others(i):
        left = _left(rivals, truth, rival, made.series)
        worst = left if worst is None else min(worst, left, key=_weakness)
        if worst.chance < HOPELESS:
            break
    return worst or NOT


NOT = Exclusion(0.0, 0.0, 0.0)
HOPELESS = 0.05
"""Chance of an exclusion below which it is given up."""


def _weakness(x: Exclusion) -> tuple[float, float]:
    return x.chance, x.behind


UNSURE = 0.5
"""Relative standard deviation of a foreseen χ²: the truth is like the fitted hypothesis, not the same."""


def chance(lead: float, more: float) -> float:
    """How likely a rival ends up excluded that is expected to be behind by `lead` in BIC, `more` of it by the
    new recording: by noise the χ² by which a wrong law loses has a standard deviation of twice its root."""
    more = max(more, 1.0)
    return 0.5 * (1 + erf((lead - CLOSE) / hypot(2 * sqrt(more), UNSURE * more) / sqrt(2)))


def _left(rivals: Rivals, truth: Fit, rival: Fit, new: Series) -> Exclusion:
    """What a fit to all recordings leaves a rival, from several starts as long as it is excluded."""
    whiteners = (*rivals.judge.whiteners, new.whitener)
    scales = record_scales(rivals.setting.model, [*rivals.setting.series, new])
    added = tuple(ranged(a, scales) for a in rival.hypothesis.added)
    e, start = joined(rival, rivals.k, new)
    e = replace(e, layout=widened(e.layout, added))
    n = effective(truth.white)
    more_data = log((n + new.data.size) / n)
    worst: Exclusion | None = None
    own = [a for a, b in zip(added, rival.hypothesis.added, strict=True) if b.key not in truth.hypothesis.key]
    try:
        problem = e.problem(start, whiteners)
    except InputError:
        return NOT
    for value, theta in _ends(problem, _starts(e.layout, own, start, truth)):
        behind = (value - truth.chi2) / rivals.scale
        more = max(behind - (rival.chi2 - truth.chi2) / rivals.scale, 0.0) / rivals.judge.temper
        if rivals.judge.temper > 1.0:  # by what both are wrong already, neither is excluded
            behind = more
        count = free(e.layout, theta, rival.hypothesis.shapes, rival.hypothesis.pasts)
        price = (count - rival.parameters) * log(n) + (count - truth.parameters) * more_data
        lead = rival.bic - truth.bic + price + more
        now = Exclusion(behind, lead, chance(lead, more))
        worst = now if worst is None else min(worst, now, key=lambda x: x.lead)
        if worst.chance < HOPELESS:
            break
    return worst or NOT


BEGUN, ON, FOLLOWED = GaussNewton(max_iter=20, tol=1e-3), GaussNewton(max_iter=100, tol=1e-5), 3
"""Descents from all starts, and how those that have come farthest go on."""


def _ends(problem: Problem, starts: Sequence[Array]) -> Iterator[tuple[float, Array]]:
    """(r·r, θ) where descents have come, from the first start at first; then where the best of them end."""
    found: list[tuple[float, Array]] = []
    for some, local in ((starts[:1], BEGUN), (starts[1:], BEGUN), ([], ON)):
        begun = some or [x for _, x in sorted(found, key=lambda e: e[0])[:FOLLOWED]]
        if not begun:
            continue
        with np.errstate(all="ignore"):
            ends = local.descents(problem, np.clip(np.array(begun), problem.lower, problem.upper))
        new = [(float(v), x) for v, x in zip(ends.value, ends.theta, strict=True) if np.isfinite(v)]
        found += new
        yield from new


def _starts(layout: Layout, added: Sequence[Addition], theta: Array, truth: Fit) -> list[Array]:
    """θ, and with the shapes of the rival's own effects (`added`) elsewhere: a new record may ask for quite
    others. At θ and at the ends, where laws become simpler ones, also with what the truth has of the same
    parameters: under another load, sharp resonances leave valleys on the way there."""
    starts, ends = [theta], [theta]
    for a in added:
        grid = a.grid if a.effect.shapes else []
        for point in grid[:: max(1, len(grid) // SPREAD)]:
            starts.append(_with(layout, theta, point))
        ends += [_with(layout, theta, point) for point in (grid[0], grid[-1])] if grid else []
    there = dict(zip(truth.hypothesis.names, truth.theta.tolist(), strict=True))
    return starts + [_with(layout, x, there) for x in ends]


def _with(layout: Layout, theta: Array, values: Mapping[str, float]) -> Array:
    """θ with these values of the parameters that it has."""
    own = zip(layout.names, theta.tolist(), strict=True)
    return np.array([values.get(n, x) for n, x in own])
