"""All single effects: screened at the base by their score tests, and the most promising fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from modelgen.diagnose.hypotheses.hypothesis import Hypothesis
from modelgen.diagnose.hypotheses.refit import Fit, Judge, plain_white
from modelgen.diagnose.hypotheses.setting import ALARM, CLOSE, Setting
from modelgen.diagnose.hypotheses.starts import base_starts
from modelgen.diagnose.noise.recolour import gross
from modelgen.diagnose.search.afresh import HOPE, afresh, elsewhere
from modelgen.diagnose.search.far import BENT, FAR, beyond_scatter
from modelgen.diagnose.search.grow import faint
from modelgen.diagnose.search.screen import Score, Tangent, score
from modelgen.diagnose.search.swap import better_of
from modelgen.fit.experiment import initial_parameters

ASIDE = (0.97, 1.0, 1.03)
"""Factors of a strength between which descents have kinks to overcome."""


def screened(
    s: Setting, base: Fit, judge: Judge, singles: Sequence[Hypothesis]
) -> tuple[list[Score], list[Fit]]:
    """Score tests of all single effects at the base's fit, and fits of the most promising.

    What first order can't show is fitted, too: it is blind only if that gains nothing.
    """
    scores = _scored(s, base, judge, singles, 3)
    fits = _refit_singles(s, base, judge, scores)
    for theta in s.others:
        away = judge.fit(base.hypothesis, [theta])
        if abs(away.bic - base.bic) > 1.0 or not np.allclose(away.theta, base.theta, rtol=0.1, atol=0.0):
            fits = better_of(fits, _refit_singles(s, away, judge, _scored(s, away, judge, singles)))
    if s.model.is_time_model:
        for there in elsewhere(s, base, judge, fits):
            fits = better_of(fits, _refit_singles(s, there, judge, _scored(s, there, judge, singles)))
    elif s.cheap:
        fits = _crossed(s, base, judge, afresh(s, base, judge, fits))
    fits = sorted(fits, key=lambda f: f.bic)
    fits = [*s.each(partial(_unhooked, judge), fits[: s.beam]), *fits[s.beam :]]
    gained = {f.hypothesis.key for f in fits if base.bic - f.bic > ALARM}
    return [replace(x, blind=x.blind and x.hypothesis.key not in gained) for x in scores], fits


def _scored(s: Setting, fit: Fit, judge: Judge, singles: Sequence[Hypothesis], keep: int = 1) -> list[Score]:
    """Score tests of single effects at a fit of the base."""
    tangent = Tangent.of(*judge.tangent(fit))

    def scored(h: Hypothesis) -> Score:
        return score(h, fit.hypothesis, fit.theta, tangent, judge.whiteners, keep)

    return s.each(scored, singles)


def from_singles(judge: Judge, base: Fit, singles: Sequence[Fit]) -> Fit:
    """The base fitted again from where the best singles have taken its parameters: none may win by a better
    start."""
    starts = [base.theta]
    for f in sorted(singles, key=lambda f: f.bic)[:3]:
        starts.append(f.hypothesis.values_of(f.theta, base.hypothesis))
    return judge.fit(base.hypothesis, starts, iterations=150)


def _refit_singles(s: Setting, base: Fit, judge: Judge, scores: Sequence[Score]) -> list[Fit]:
    """Fits of the most promising single effects (all, where that is cheap)."""
    seen = sorted((x for x in scores if x.starts), key=lambda x: -x.gain)
    count = len(seen) if s.cheap else s.refits
    # a base far from the data may be bent too far for a way back: from its defaults, too
    defaults = base_starts(base.hypothesis, 0, 1) if gross(s, plain_white(base)) else []

    def fitted(ranked: tuple[int, Score]) -> Fit:
        k, x = ranked
        places = [(base.theta, v) for _, v in (x.starts if k < 12 else x.starts[:1])]
        places += [(theta, x.starts[0][1]) for theta in defaults]
        f = judge.fit(x.hypothesis, [x.hypothesis.place(base.hypothesis, t, v) for t, v in places])
        return f if s.cheap else judge.revived(f, base)

    first: dict[str, Score] = {}
    for x in seen:
        first.setdefault(x.addition.id, x)
    named = {x.addition.id for x in seen[:count]}
    others = [x for x in first.values() if x.addition.id not in named]
    seen = [*seen[:count], *others[:OTHERS]]
    fits = s.each(fitted, list(enumerate(seen)))
    if s.cheap and not s.model.is_time_model:
        fits = _beside(s, base, judge, seen, _scouted(s, base, judge, seen, fits))
    return fits


OTHERS = 3
"""Effects beyond the most promising laws, where fits are dear: the many laws of one leave others a place."""
SOME, EVERY = 24, 1000
"""Places where a resonance may lie from which descents start."""


def _scouted(s: Setting, base: Fit, judge: Judge, seen: Sequence[Score], fits: Sequence[Fit]) -> list[Fit]:
    """`fits` of sweeps by what was `seen`, again where the first order has led astray: from little of an
    effect where it reached too far, and, once there is something to be found, from where resonances may lie,
    all over while no fit is near the noise."""
    best = min(fits, key=lambda f: f.bic, default=base)
    bent = beyond_scatter(min(fits, key=lambda f: f.chi2, default=base)) > BENT
    count = EVERY if bent else SOME if base.bic - best.bic > ALARM else 0

    def again(found: tuple[Score, Fit]) -> Fit:
        x, f = found
        places = x.some(min(count, len(x.scouts)))
        starts = [x.hypothesis.place(base.hypothesis, base.theta, v) for v in places]
        if f.chi2 > base.chi2:
            here = [x.hypothesis.place(base.hypothesis, base.theta, v) for _, v in x.starts]
            starts += faint(x.hypothesis, x.addition, here)
        other = judge.fit(x.hypothesis, starts, worth=HOPE * f.chi2, few=SCOUTS) if starts else f
        return min((f, other), key=lambda f: f.bic)

    return s.each(again, list(zip(seen, fits, strict=False)))


def _beside(s: Setting, base: Fit, judge: Judge, seen: Sequence[Score], fits: Sequence[Fit]) -> list[Fit]:
    """`fits` of sweeps by what was `seen`, those of resonances that are behind the best one again from where
    that has taken the base's own parameters: a base that is bent far hides where its rivals resonate."""
    best = min(fits, key=lambda f: f.bic, default=base)
    if base.bic - best.bic < ALARM or beyond_scatter(base) < FAR:
        return list(fits)
    there = judge.look(base.hypothesis, best.hypothesis.values_of(best.theta, base.hypothesis))
    tangent = Tangent.of(*judge.tangent(there))

    def again(found: tuple[Score, Fit]) -> Fit:
        (x, f), h = found, found[0].hypothesis
        if not x.scouts or f.bic <= best.bic + CLOSE:
            return f
        seen_there = score(h, base.hypothesis, there.theta, tangent, judge.whiteners, SCOUTS)
        starts = [h.place(base.hypothesis, there.theta, v) for _, v in seen_there.starts]
        other = judge.fit(h, starts, worth=HOPE * f.chi2, few=SCOUTS) if starts else f
        return min((f, other), key=lambda f: f.bic)

    return s.each(again, list(zip(seen, fits, strict=True)))


def _crossed(s: Setting, base: Fit, judge: Judge, fits: Sequence[Fit]) -> list[Fit]:
    """`fits` of sweeps that explain something, again from where the best few have taken the base's own
    parameters: a modulus has a valley on either side of a loss that vanishes, and none may win by its
    start."""
    guides = [f.hypothesis.values_of(f.theta, base.hypothesis) for f in sorted(fits, key=lambda f: f.bic)]

    def crossed(f: Fit) -> Fit:
        if base.bic - f.bic <= ALARM:
            return f
        own = dict(zip(f.hypothesis.names, f.theta.tolist(), strict=True))
        own = {n: v for n, v in own.items() if n not in base.hypothesis.names}
        here = f.hypothesis.values_of(f.theta, base.hypothesis)
        there = (x for x in guides[:GUIDES] if not np.allclose(x, here, rtol=0.1, atol=0.0))
        starts = [f.hypothesis.place(base.hypothesis, x, own) for x in there]
        return min([f, judge.fit(f.hypothesis, starts)] if starts else [f], key=lambda f: f.bic)

    return s.each(crossed, fits)


GUIDES = 4
"""Fits whose base parameters others start from."""
SCOUTS = 6
"""Descents that go on: in a narrow resonance they are slow at first."""


def _unhooked(judge: Judge, f: Fit) -> Fit:
    """A fit of an effect with kinks, which hold descents up, from beside where it ended: with other
    strengths, and with the states before the record as they were at first."""
    kinked = [n for a in f.hypothesis.added if a.effect.secant for n in a.strengths]
    if not kinked:
        return f
    e = f.hypothesis.experiment
    at = [f.hypothesis.names.index(n) for n in kinked]
    own = [k for k, n in enumerate(f.hypothesis.names) if n.split("[")[0] in initial_parameters(e.model)]
    reset = f.theta.copy()
    for k in own:
        default = e.layout.parameters[k].default
        reset[k] = reset[k] if default is None else default
    starts = [f.theta]
    for theta in (f.theta, reset):
        for by in ASIDE:
            starts.append(theta.copy())
            starts[-1][at] *= by
    return judge.fit(f.hypothesis, starts)
