"""How likely rival accounts of sweeps are, by what their shapes cost and by how many laws an id has.

BIC's price of a number, ln n, is that of one which every further sample tells better. Sound from a small
radiator is a mass, whatever its radius; a wide spectrum of relaxation times is known but roughly. Such a
shape costs by how much narrower it is known than it was thought possible (the share of its range that
the recordings leave it), else a law of one number more would be excluded by its price and not by the
recordings. Laws of one id share what is thought of it beforehand: the more ways there are to say it, the
less speaks for each. So do the two signs of a strength that may have either: a law that would have been
wrong of the other sign, as a passive element, has said more.

Sweeps alone: local information on a law with kinks tells little.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from modelgen.diagnose.hypotheses.addition import Addition
from modelgen.diagnose.hypotheses.bounds import moving
from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.hypothesis import Hypothesis
from modelgen.diagnose.hypotheses.pasts import price
from modelgen.diagnose.hypotheses.ranking import weights
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import CLOSE, Outcome, Setting
from modelgen.fit import GaussNewton
from modelgen.fit.series import Array

LEAST = 3.0
"""What a shape costs at least: where nothing tells it, it has to be where it doesn't show, in a fifth of the
range that is searched, say."""


def fairly_priced(setting: Setting, outcome: Outcome, exempt: Callable[[Fit], bool]) -> Outcome:
    """The outcome of a search in sweeps with the evidence for all accounts that have as many effects as the
    best one, by what their shapes cost; of them the best one, of single effects that of the likeliest id.

    `exempt`: those that pay in full, and aren't named.
    """
    best, judge = outcome.best, outcome.judge
    if not best.ids or setting.model.is_time_model:
        return outcome
    ways, shared = _ways(setting.additions), {}
    for f in (best, *outcome.tried):
        if len(f.ids) == len(best.ids) and not exempt(f):
            more = 2 * sum(float(np.log(ways.get(a.id, 1.0) * signs(a))) for a in f.hypothesis.added)
            shared[id(f)] = replace(f, bic=f.bic + more)
    least = min(f.bic for f in shared.values())
    priced = {k: _priced(judge, f, least) for k, f in shared.items()}
    tried = tuple(priced.get(id(f), f) for f in outcome.tried)
    return replace(outcome, best=_likeliest(list(priced.values())), tried=tried)


def _ways(additions: Sequence[Addition]) -> dict[str, float]:
    """In how many ways each id is said, as common as the commonest."""
    common: dict[str, dict[int, float]] = {}
    for a in additions:
        common.setdefault(a.id, {})[id(a.effect)] = a.effect.common
    return {i: sum(of.values()) / max(of.values()) for i, of in common.items()}


def signs(a: Addition) -> int:
    """In how many ways the strengths' signs may be combined; those of repeats go together."""
    return int(2 ** sum(q.bounds[0] < q.null < q.bounds[1] for q in a.effect.strengths))


def _likeliest(fits: Sequence[Fit]) -> Fit:
    """The best fit; of single effects that of the id which is the likeliest by all of its laws, held to be
    as good as the best."""
    best = min(fits, key=lambda f: f.bic)
    if len(best.ids) > 1:
        return best
    of_id: dict[str, float] = {}
    of_law = {f.hypothesis.key: f for f in fits}
    for f, x in zip(of_law.values(), weights(list(of_law.values())), strict=True):
        of_id[f.ids[0]] = of_id.get(f.ids[0], 0.0) + float(x)
    first = max(of_id, key=lambda i: of_id[i])
    return replace(min((f for f in fits if f.ids[0] == first), key=lambda f: f.bic), bic=best.bic)


def _priced(judge: Judge, f: Fit, least: float) -> Fit:
    """`f` with evidence in which its shapes cost no more than the recordings tell of them; as it is where
    that is too little to matter beside a BIC of `least`."""
    layout, widths = f.hypothesis.experiment.layout, _widths(f.hypothesis, f.theta)
    moves = moving(layout, f.theta, f.hypothesis.shapes)
    shapes = moves & (widths > 0)
    full = float(np.log(max(effective(f.white) / judge.temper, 3.0)))
    count = int(shapes.sum())
    if f.bic - count * (full - LEAST) > least + CLOSE or full < LEAST:
        return f
    with np.errstate(all="ignore"):
        told = f.hypothesis.experiment.normal(f.theta, judge.whiteners)[2]
    if not count or not np.all(np.isfinite(told)):
        return f
    places = np.flatnonzero(shapes).tolist()
    cost = sum(_of_range(judge, f, j, _alone(told, j, moves, widths, judge)) for j in places)
    return replace(f, bic=f.bic - max(0.0, count * full - max(cost, count * LEAST)))


NODES = 24
"""Values of a shape, over its range, at which all else is fitted again."""
LOST = 16.0
"""χ² above the least from which a value adds nothing to the evidence."""
AGAIN = GaussNewton(max_iter=30, tol=1e-4)


def _alone(told: Array, j: int, moves: Array, widths: Array, judge: Judge) -> float:
    """What number j of θ costs by what is known of it at its best value."""
    mine = np.arange(len(widths)) == j
    return price(told, mine, moves & ~mine, widths, judge.temper)


def _of_range(judge: Judge, f: Fit, j: int, local: float) -> float:
    """−2 ln of the share of its range that a fit's shape, number j of θ, may have: the mean of the likelihood
    over the range, all else fitted, over the greatest. What is known of it at its best value (`local`) says
    little where a law becomes a simpler one towards an end of the range: there any value will do.
    """
    low, high = f.hypothesis.experiment.layout.parameters[j].bounds
    to, back = (np.log, np.exp) if low > 0 else (np.asarray, np.asarray)
    nodes = np.linspace(to(low), to(high), NODES)
    best = float(to(f.theta[j]))
    problem = f.hypothesis.experiment.problem(f.theta, judge.whiteners)
    above = {best: 0.0}
    for side in (nodes[nodes > best], nodes[nodes < best][::-1]):
        rest = np.delete(f.theta, j)
        for node in side.tolist():
            with np.errstate(all="ignore"):
                ends = AGAIN.descents(problem.fixed(j, float(back(node))), rest[None])
            value, rest = float(ends.value[0]), ends.theta[0]
            if not value - f.chi2 <= LOST * judge.temper:
                break
            above[node] = max(value - f.chi2, 0.0)
    if len(above) == 1:
        return local
    at = np.array(sorted(above))
    likely = np.exp(-0.5 * np.array([above[x] for x in at.tolist()]) / judge.temper)
    return -2 * float(np.log(np.trapezoid(likely, at) / (nodes[-1] - nodes[0])))


def _widths(h: Hypothesis, theta: Array) -> Array:
    """(p,) standard deviations of shapes, spread evenly over the ranges that are searched; 0 elsewhere."""
    widths = np.zeros(len(h.names))
    for a in h.added:
        for q in a.effect.shapes:
            at, (low, high) = h.names.index(f"{a.id}_{q.name}"), a.ranges[q.name]
            span = np.log(high / low) * theta[at] if q.log and low > 0 else high - low
            widths[at] = span / np.sqrt(12.0)
    return widths
