"""What errors of the motion give to a hypothesis, and take from its rivals, judged by replicas of records."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, partial

from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import CLOSE, Setting
from modelgen.diagnose.noise.replica import TIMES, motion_matters, replicas, undeserved, unfair
from modelgen.fit.series import Series


def deserved(s: Setting, judge: Judge, parents: Sequence[Fit], fits: list[Fit]) -> tuple[Judge, list[Fit]]:
    """Take from the best of `fits` what errors of the motion give them beside the parent they grew from."""
    if judge.temper > 1.0 or not s.model.is_time_model or not motion_matters(judge.whiteners):
        return judge, fits
    made: dict[frozenset[tuple[str, str, int]], tuple[Series, ...]] = {}
    while True:
        first = sorted(fits, key=lambda f: f.bic)[: s.beam]
        child = next((f for f in first if f.hypothesis.key not in judge.excess), None)
        if child is None:
            return judge, fits
        parent = min((p for p in parents if p.hypothesis.key < child.hypothesis.key), key=lambda p: p.bic)
        key = parent.hypothesis.key
        if key not in made:
            made[key] = replicas(s.model, s.case, parent, judge.whiteners, seed=len(key))
        own = judge.excess.get(key, 0.0) + undeserved(judge, parent, child, made[key])
        judge = replace(judge, excess={**judge.excess, child.hypothesis.key: own})
        fits = [judge.look(f.hypothesis, f.theta) if f is child else f for f in fits]


SIMILAR = 0.1
"""Rivals that gain all but this share of what the best one gains may be what is there in its stead."""
RIVALS = 3


def among_rivals(s: Setting, judge: Judge, best: Fit, tried: Sequence[Fit]) -> Judge:
    """The judge who gives to those that do nearly as well as `best` what errors of the motion give it."""
    if judge.temper > 1.0 or not best.ids or not s.model.is_time_model or not motion_matters(judge.whiteners):
        return judge
    less = min((f for f in tried if len(f.ids) < len(best.ids)), key=lambda f: f.bic)
    near = best.bic + SIMILAR * max(0.0, less.bic - best.bic)
    first: dict[tuple[str, ...], Fit] = {}
    for f in sorted(tried, key=lambda f: f.bic):
        if best.bic + CLOSE < f.bic < near and len(f.ids) == len(best.ids) and set(f.ids) != set(best.ids):
            first.setdefault(f.ids, f)
    rivals = list(first.values())[:RIVALS]
    if not rivals:
        return judge

    @cache
    def made(f: Fit, seed: int) -> tuple[Series, ...]:
        return replicas(s.model, s.case, f, judge.whiteners, seed)

    excess = dict(judge.excess)
    for rival in rivals:
        if_best, if_rival = (map(partial(made, f), range(TIMES)) for f in (best, rival))
        # where neither is told from the other, the one that was ahead stays the first
        lead = min(unfair(judge, best, rival, if_best, if_rival), rival.bic - best.bic)
        for f in tried:  # what holds the rival is as much better
            if lead and rival.hypothesis.key <= f.hypothesis.key:
                excess[f.hypothesis.key] = excess.get(f.hypothesis.key, 0.0) - lead
    return judge if excess == judge.excess else replace(judge, excess=excess)
