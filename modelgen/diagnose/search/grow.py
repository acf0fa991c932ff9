"""Hypotheses with one effect more than those that a search holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from modelgen.diagnose.hypotheses.addition import Addition
from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.hypothesis import Hypothesis, make_hypotheses
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import ALARM, Setting
from modelgen.diagnose.search.screen import Score, Tangent, score
from modelgen.fit.series import Array

SLACK = 1.5
"""A refit may gain this many times the evidence that the score promised at first order."""
COMPANIONS = 4
"""Families whose best single effects are tried beside each hypothesis of the beam."""
FEW = 20
"""So many shapes are always tried."""
DEAR = 3
"""Physics beyond the most promising laws of which one law is tried, where fits are dear."""
OPPOSITE = 2
"""Effects of which the base asks the opposite that are tried, where fits are dear."""


def grow(
    s: Setting, base: Fit, judge: Judge, beam: Sequence[Fit], scores: Sequence[Score], first: Sequence[Fit]
) -> list[Fit]:
    """Hypotheses with one effect more than those of the beam, fitted."""
    chosen = _promising(s, base, judge, beam, scores)
    if beam and len(beam[0].ids) == 1:
        more = _companions(beam if s.cheap else beam[:1], first)
        chosen = chosen | {key: grown for key, grown in more.items() if key not in chosen}
    made = make_hypotheses(
        s.model, s.case, s.series, [(*g.fit.hypothesis.added, g.addition) for g in chosen.values()]
    )

    def fitted(h: Hypothesis) -> Fit:
        g = chosen[h.key]
        starts = [h.place(g.fit.hypothesis, g.fit.theta, v) for v in g.values]
        if g.other is not None:
            own = dict(zip(g.fit.hypothesis.names, g.fit.theta, strict=True))
            starts.append(h.place(g.other.hypothesis, g.other.theta, _only(own, g.fit)))
        f = judge.fit(h, starts, worth=np.inf if s.cheap else _worth(g.fit, judge))
        if f.chi2 > g.fit.chi2:  # it holds g.fit, so the first order has led astray
            f = min(f, judge.fit(h, faint(h, g.addition, starts)), key=lambda f: f.bic)
        return f if s.cheap else judge.revived(f, g.fit)

    found = s.each(fitted, made)
    return found if s.cheap else [*found, *_likewise(s, judge, beam, found)]


ALSO = 2
"""Effects that, as they were best beside one of the beam, are tried beside all of it."""
FAINT = 0.1
"""Part of what the first order promises from which descents start, too."""


def faint(h: Hypothesis, a: Addition, starts: Sequence[Array]) -> list[Array]:
    """Starts with little of an effect."""
    at = [h.names.index(n) for n in a.nulls]
    null = np.array(list(a.nulls.values()))
    little = [start.copy() for start in starts]
    for start in little:
        start[at] = null + FAINT * (start[at] - null)
    return little


def _likewise(s: Setting, judge: Judge, beam: Sequence[Fit], found: Sequence[Fit]) -> list[Fit]:
    """What the best few of `found` have added, beside the others of the beam: how much it does there, their
    own first order may not tell. Where fits are cheap, exchanges find it."""
    best: dict[str, Fit] = {}
    for f in sorted(found, key=lambda f: f.bic):
        best.setdefault(f.hypothesis.added[-1].id, f)
    known = {f.hypothesis.key for f in found}
    whole: dict[Key, tuple[Fit, Fit]] = {}
    for f, g in product(list(best.values())[:ALSO], beam):
        a = f.hypothesis.added[-1]
        if a.id not in g.ids and (key := g.hypothesis.key | {a.key}) not in known:
            whole.setdefault(key, (f, g))
    sets = [(*g.hypothesis.added, f.hypothesis.added[-1]) for f, g in whole.values()]

    def fitted(h: Hypothesis) -> Fit:
        f, g = whole[h.key]
        return judge.fit(h, [h.place(g.hypothesis, g.theta, own_values(f, f.hypothesis.added[-1]))])

    return s.each(fitted, make_hypotheses(s.model, s.case, s.series, sets))


def found_before(s: Setting, judge: Judge, depth: int) -> list[Fit]:
    """Sets of so many of the effects that an earlier search had found together: another base, or another
    colour of the noise, may lead a search past them."""
    if s.before is None or len(s.before.ids) < depth:
        return []
    mine, found = {a.key: a for a in s.additions}, s.before
    own = [mine[a.key] for a in found.hypothesis.added if a.key in mine]
    made = make_hypotheses(s.model, s.case, s.series, list(combinations(own, depth)))
    return s.each(lambda h: judge.fit(h, [h.place(found.hypothesis, found.theta, {})]), made)


def own_values(f: Fit, a: Addition) -> dict[str, float]:
    """The values that a fit has of one effect's parameters."""
    values = zip(f.hypothesis.names, f.theta.tolist(), strict=True)
    return {n: v for n, v in values if n.startswith(f"{a.id}_")}


def _worth(f: Fit, judge: Judge) -> float:
    """χ² below which an effect beside f may still be claimed: half of what that takes is there."""
    return f.chi2 * float(np.exp(-0.5 * ALARM * judge.temper / effective(f.white)))


Key = frozenset[tuple[str, str, int]]


@dataclass(frozen=True, eq=False)
class Grown:
    """A fit and the effect to be added to it, from these values; `other`: a fit with this effect alone."""

    fit: Fit
    addition: Addition
    values: tuple[Mapping[str, float], ...]
    other: Fit | None = None

    @property
    def key(self) -> Key:
        return self.fit.hypothesis.key | {self.addition.key}


def _promising(
    s: Setting, base: Fit, judge: Judge, beam: Sequence[Fit], scores: Sequence[Score]
) -> dict[Key, Grown]:
    """The effects that by their score beside the beam's fits promise most."""
    wanted: list[tuple[float, Grown]] = []
    opposite: list[tuple[float, Grown]] = []
    for k, f in enumerate(beam):
        tangent = Tangent.of(*judge.tangent(f))
        inner = f.hypothesis.values_of(f.theta, base.hypothesis)

        def scored(x: Score, first: bool = k == 0, inner: Array = inner, tangent: Tangent = tangent) -> Score:
            # what the base's residual hides may lie elsewhere: beside the best fit all shapes are tried, of
            # records those that resonate, and where the base asks the opposite, so that it tells no shape
            points = None if first and (s.cheap or x.scouts or x.gain <= 0) else points_of(x)
            return score(x.hypothesis, base.hypothesis, inner, tangent, judge.whiteners, 2, points)

        others = [x for x in scores if x.addition.id not in f.ids]
        for x, again in zip(others, s.each(scored, others), strict=True):
            told = s.cheap or x.gain > 0
            reach = f.bic - SLACK * judge.evidence(f, again.gain) - beam[0].bic
            if again.starts and reach < -ALARM:
                tried = (*(v for _, v in again.starts), *(v for _, v in x.starts[:2]))
                (wanted if told else opposite).append((reach, Grown(f, x.addition, tried)))
    also = [g for _, g in sorted(opposite, key=lambda w: w[0])[:OPPOSITE]]
    return {g.key: g for g in also} | _best(s, [g for _, g in sorted(wanted, key=lambda w: w[0])])


def _best(s: Setting, wanted: Sequence[Grown]) -> dict[Key, Grown]:
    """The first of those that are wanted; beyond them, of other physics one law each."""
    chosen: dict[Key, Grown] = {}
    others: dict[frozenset[str], Grown] = {}
    for g in wanted:
        if g.key not in chosen and len(chosen) < s.pairs * (2 if len(g.fit.ids) == 1 else 1):
            chosen[g.key] = g
        others.setdefault(frozenset((*g.fit.ids, g.addition.id)), g)
    # the many laws of one physics leave others their place: those that are as good are told, too
    new = [g for g in others.values() if g.key not in chosen and len(g.fit.ids) == 1]
    return chosen | {g.key: g for g in new[: s.pairs if s.cheap else DEAR]}


def points_of(x: Score) -> list[Mapping[str, float]]:
    """The shapes that explained most of the base's residual; all, for what the base alone can imitate and
    where they are few and far from each other."""
    effect, grid = x.addition.effect, x.addition.grid
    if not x.starts or (effect.secant and len(grid) <= FEW):
        return grid
    shapes = {f"{x.addition.id}_{q.name}" for q in x.addition.effect.shapes}
    if x.addition.effect.secant:
        shapes |= set(x.addition.strengths)
    return [{k: v for k, v in values.items() if k in shapes} for _, values in x.starts]


def _companions(beam: Sequence[Fit], first: Sequence[Fit]) -> dict[Key, Grown]:
    """Single effects that explain much alone, beside those of the beam of another family.

    A score can miss them: beside a partner that has taken over their part, or with the wrong law, their
    derivative points the wrong way.
    """
    best: dict[str, Fit] = {}
    for f in sorted(first, key=lambda f: f.bic):
        best.setdefault(f.hypothesis.added[0].family, f)
    chosen: dict[Key, Grown] = {}
    for f in beam:
        for g in list(best.values())[:COMPANIONS]:
            a = g.hypothesis.added[0]
            if a.family != f.hypothesis.added[0].family and a.id not in f.ids:
                values = _only(dict(zip(g.hypothesis.names, g.theta, strict=True)), g)
                chosen.setdefault(f.hypothesis.key | {a.key}, Grown(f, a, (values,), g))
    return chosen


def _only(values: Mapping[str, float], f: Fit) -> dict[str, float]:
    """Those of `values` that belong to the effects of a fit."""
    return {k: v for k, v in values.items() if any(k.startswith(f"{i}_") for i in f.ids)}
