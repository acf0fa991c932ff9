"""Fewer effects: what is left of a hypothesis that its last ones have made too large."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

from modelgen.diagnose.hypotheses.hypothesis import Hypothesis, make_hypotheses
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import Setting
from modelgen.diagnose.search.claim import gains
from modelgen.diagnose.search.far import FAR, beyond_scatter
from modelgen.diagnose.search.screen import Score
from modelgen.diagnose.search.swap import FEW, Promise, promised


def pruned(
    s: Setting, judge: Judge, base: Fit, best: Fit, tried: Sequence[Fit], scores: Sequence[Score]
) -> tuple[Fit, list[Fit]]:
    """`best` without effects that it no longer needs, as those that came later say the same better; and all
    that was fitted to see it.

    It needs them where it gains enough on the best account with one effect less, both the best part of it and
    the best other, two in one among these.
    """
    found: list[Fit] = []
    while True:
        less = parts(s, judge, best)
        if not less:
            return best, found
        found += [*less, *merged(s, base, judge, best, scores)]
        others = [f for f in (*tried, *found) if len(f.ids) == len(best.ids) - 1]
        others = [judge.look(f.hypothesis, f.theta) for f in sorted(others, key=lambda f: f.bic)[: s.beam]]
        firsts = [min(fits, key=lambda f: f.bic) for fits in (less, others) if fits]
        if all(gains(s, judge, base, f, best) for f in firsts):
            return best, found
        best = min(firsts, key=lambda f: f.bic)


def parts(s: Setting, judge: Judge, best: Fit) -> list[Fit]:
    """`best` less each of its effects, fitted from where it is."""
    added = best.hypothesis.added
    less = [tuple(b for b in added if b is not a) for a in added] if len(added) > 1 else []
    made = make_hypotheses(s.model, s.case, s.series, less)
    return s.each(lambda h: judge.fit(h, [h.place(best.hypothesis, best.theta, {})]), made)


def merged(s: Setting, base: Fit, judge: Judge, best: Fit, scores: Sequence[Score]) -> list[Fit]:
    """`best` with two of its effects exchanged for a single one, from where the base's own parameters are
    beside them: two may say what one would have said, had the base not been bent too far to see it."""
    if len(best.ids) < 2 or beyond_scatter(base) < FAR:
        return []
    found: list[Fit] = []
    for gone in combinations(best.hypothesis.added, 2):
        kept = tuple(a for a in best.hypothesis.added if a not in gone)
        rest = make_hypotheses(s.model, s.case, s.series, [kept])[0]
        beside = judge.look(rest, rest.place(best.hypothesis, best.theta, {}))
        usable = [x for x in scores if x.addition.id not in rest.ids]
        ranked = sorted(promised(s, base, judge, beside, usable, True), key=lambda p: p.left)
        kinds = list(dict.fromkeys(p.addition.id for p in ranked))[:FEW]
        chosen = []
        for kind in kinds:  # of each physics the best law, and the plainest
            laws = [p for p in ranked if p.addition.id == kind]
            plainest = min(laws, key=lambda p: p.addition.count)
            chosen += [laws[0]] if plainest is laws[0] else [laws[0], plainest]
        own = {p.addition.key: p for p in chosen}
        made = make_hypotheses(s.model, s.case, s.series, [(*kept, p.addition) for p in chosen])

        def fitted(h: Hypothesis, rest: Hypothesis = rest, own: Mapping[Any, Promise] = own) -> Fit:
            p = own[h.added[-1].key]
            return judge.fit(h, [h.place(rest, p.theta, p.values)])

        found += s.each(fitted, made)
    return found
