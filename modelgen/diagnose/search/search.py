"""The search over hypotheses: screen, refit, take in one effect after another while the evidence grows."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from modelgen.diagnose.hypotheses.addition import Addition
from modelgen.diagnose.hypotheses.evidence import Smooth, levels
from modelgen.diagnose.hypotheses.hypothesis import Hypothesis, make_hypotheses
from modelgen.diagnose.hypotheses.refit import Fit, Judge, mean_square, misfit, plain_white
from modelgen.diagnose.hypotheses.setting import ALARM, Outcome, Progress, Setting
from modelgen.diagnose.noise.recolour import (
    by_own_noise,
    judged_anew,
    near_smooth,
    recolour,
    recolour_pairs,
)
from modelgen.diagnose.noise.smooth_error import quietness, smooth_error, with_smooth
from modelgen.diagnose.search.claim import PLAIN, gains, hidden, own_gain, worse
from modelgen.diagnose.search.deserved import among_rivals, deserved
from modelgen.diagnose.search.far import BENT, FAR, beyond_scatter
from modelgen.diagnose.search.fewer import pruned
from modelgen.diagnose.search.grow import found_before, grow
from modelgen.diagnose.search.joint import joint, plain
from modelgen.diagnose.search.screen import Score
from modelgen.diagnose.search.singles import from_singles, screened
from modelgen.diagnose.search.swap import Key, better_of, by_other_laws, exchanged, swapped
from modelgen.fit.series import Series

MOST = 3
"""Effects in one verdict."""


def white_judge(series: Sequence[Series]) -> Judge:
    """Whiteners as stated, no colour."""
    return Judge(tuple(s.whitener for s in series), levels(series))


def search(s: Setting, base: Fit, judge: Judge, progress: Progress = None) -> Outcome:
    """Forward selection with a beam and swaps, the colour of the noise taken from the best hypothesis so
    far."""
    singles = make_hypotheses(s.model, s.case, s.series, [(a,) for a in s.additions])
    if progress:
        progress(0.3, "screening")
    scores, first = screened(s, base, judge, singles)
    better = from_singles(judge, base, first)
    if base.bic - better.bic > 1.0:  # the base had not been at its optimum: judge anew from there
        base = better
        scores, first = screened(s, base, judge, singles)
    first = swapped(s, base, judge, first, scores, first)
    blind = tuple(x.addition for x in scores if x.blind)
    judge, base, first = recolour(s, judge, base, first)
    if progress:
        progress(0.6, "fitting")
    judge, first = deserved(s, judge, [base], first)
    best, grown, tried = base, first, {f.hypothesis.key: f for f in first}
    for depth in range(1, MOST + 1):
        if depth > 1:
            if progress:
                progress(0.5 + 0.15 * depth, f"looking for {'a second' if depth == 2 else 'a third'} effect")
            judge, base, best, grown = _deeper(s, judge, base, best, grown, scores, first)
            if not grown:
                break
            tried |= {f.hypothesis.key: f for f in grown}
            best = min([best, *(f for f in grown if len(f.ids) == len(best.ids))], key=lambda f: f.bic)
            grown = [f for f in grown if len(f.ids) == depth]
        winner = min([best, *grown], key=lambda f: f.bic)
        best = _from_there(judge, best, winner)
        if winner is not best and gains(s, judge, base, best, winner):
            best = winner
        elif not grown or not hidden(s, judge, best, winner, depth):
            break
    if not s.cheap:
        judge, best, tried = _by_exchanges(s, judge, base, best, scores, first, tried)
    laws = by_other_laws(s, base, judge, best, list(tried.values()), scores) if s.cheap else []
    tried = {f.hypothesis.key: f for f in better_of(list(tried.values()), laws)}
    best = min([best, *(f for f in laws if len(f.ids) == len(best.ids))], key=lambda f: f.bic)
    best, less = pruned(s, judge, base, best, list(tried.values()), scores)
    best = base if worse(s, base, best) else best  # under the last colour
    return _concluded(s, judge, base, best, better_of(list(tried.values()), less), blind, singles)


ROUNDS = {2: 5, 3: 1}
"""Exchanges one after another where fits are dear, while they make the best hypothesis better, by the number
of its effects: three are seldom what is there."""
MISSED = 1.5
"""Times the square of the noise: what leaves more is exchanged anew beside the same."""


def _by_exchanges(
    s: Setting,
    judge: Judge,
    base: Fit,
    best: Fit,
    scores: Sequence[Score],
    first: Sequence[Fit],
    tried: Mapping[Key, Fit],
) -> tuple[Judge, Fit, dict[Key, Fit]]:
    """`_exchanged`; and where no two are claimed though a pair of others was tried that is better, the pair
    that this leads to, if that one may be claimed: a beam follows what gains first."""
    if len(best.ids) > 1:
        return _exchanged(s, judge, base, best, scores, first, tried)
    pairs = [f for f in tried.values() if len(f.ids) == 2]
    lead = min(pairs, key=lambda f: f.bic, default=best)
    if set(best.ids) & set(lead.ids) or not pairs or best.bic - lead.bic < PLAIN:
        return judge, best, dict(tried)
    judge, lead, more = _exchanged(s, judge, base, lead, scores, first, tried)
    more |= {f.hypothesis.key: f for f in by_other_laws(s, base, judge, lead, list(more.values()), scores)}
    lead = min((f for f in more.values() if len(f.ids) == 2), key=lambda f: f.bic)
    best = judge.look(best.hypothesis, best.theta)
    return judge, lead if gains(s, judge, base, best, lead) else best, more


def _exchanged(
    s: Setting,
    judge: Judge,
    base: Fit,
    best: Fit,
    scores: Sequence[Score],
    first: Sequence[Fit],
    tried: Mapping[Key, Fit],
) -> tuple[Judge, Fit, dict[Key, Fit]]:
    """The best hypothesis that exchanges of its effects lead to, the judge who has vetted it, and all that
    was tried."""
    tried, done = dict(tried), frozenset[Key]()
    for _ in range(ROUNDS[len(best.ids)]):
        others, done = exchanged(s, base, judge, best, scores, done)
        if min((f.bic for f in others), default=best.bic) < best.bic:
            judge, others = deserved(s, judge, [base, *first], others)
        known = [tried[f.hypothesis.key] for f in others if f.hypothesis.key in tried]
        known = [judge.look(f.hypothesis, f.theta) for f in known]
        tried |= {f.hypothesis.key: f for f in better_of(known, others)}
        before = best
        best = min([best, *(f for f in others if len(f.ids) == len(best.ids))], key=lambda f: f.bic)
        if best is before:
            break
        if mean_square(plain_white(best)) > MISSED:  # its values are not those that they will be
            done = frozenset()
    return judge, best, tried


def _deeper(
    s: Setting,
    judge: Judge,
    base: Fit,
    best: Fit,
    before: Sequence[Fit],
    scores: Sequence[Score],
    first: Sequence[Fit],
) -> tuple[Judge, Fit, Fit, list[Fit]]:
    """Judge, base and best, and fits with one effect more than the best of those before."""
    depth = 1 + len(before[0].ids)
    # a colour that wrong hypotheses leave hides what would be right
    white = replace(judge, whiteners=tuple(replace(w, ar=None) for w in judge.whiteners))
    before, first = ([white.look(f.hypothesis, f.theta) for f in fits] for fits in (before, first))
    beam = _beam(s, white.look(base.hypothesis, base.theta), before)
    grown = better_of(grow(s, base, white, beam, scores, first), found_before(s, white, depth))
    if not grown:
        return judge, base, best, []
    judge, base, best = white, *(white.look(f.hypothesis, f.theta) for f in (base, best))
    judge, base, grown, best = recolour_pairs(s, judge, base, grown, best)
    far = depth == 2 and not s.model.is_time_model and beyond_scatter(best) > BENT
    least = best.bic - (0.0 if depth == 2 else ALARM)
    better = far or min(f.bic for f in grown) < least
    if better or _flexible(s, before):
        grown = [*grown, *_together(s, base, judge, scores, first, grown, depth)]
    if better or min(f.bic for f in grown) < least or _missed(s, best):
        more = swapped(s, base, judge, grown, scores, first)
        judge, base, grown, best = recolour_pairs(s, judge, base, more, best)
    judge, grown = deserved(s, judge, [base, *beam], grown)
    return judge, base, best, grown


def _missed(s: Setting, best: Fit) -> bool:
    """Whether the best account of sweeps is so far from them that exchanges are worth their time though what
    was added to it gains nothing."""
    return s.cheap and not s.model.is_time_model and beyond_scatter(best) > FAR


ELSEWHERE = 0.5
"""Share of what the best effect gains from which one at a port where none of the best ones is has a place in
the beam: what is wrong with the recording shows as physics does while that is missing."""


def _beam(s: Setting, base: Fit, fits: Sequence[Fit]) -> list[Fit]:
    """The best of `fits`, which a further effect is added to; and the best one with an effect at another
    port."""
    ranked = sorted(fits, key=lambda f: f.bic)
    beam = ranked[: s.beam]
    ports = set().union(*map(_ports, beam))
    least = ELSEWHERE * (base.bic - ranked[0].bic)
    other = (f for f in ranked if base.bic - f.bic > least and not ports >= _ports(f))
    return [*beam, *itertools.islice(other, 1)]


def _ports(f: Fit) -> set[str]:
    return {a.port.name for a in f.hypothesis.added}


def _flexible(s: Setting, before: Sequence[Fit]) -> bool:
    """Whether the best single effect has a shape to bend: two plain ones may say the same with as many
    numbers, and neither need add to it."""
    return s.cheap and any(a.effect.shapes for a in min(before, key=lambda f: f.bic).hypothesis.added)


def _together(
    s: Setting,
    base: Fit,
    judge: Judge,
    scores: Sequence[Score],
    first: Sequence[Fit],
    grown: Sequence[Fit],
    depth: int,
) -> list[Fit]:
    """Pairs that no beam led to: of which either effect is hidden while the other is not there."""
    if depth != 2 or not (s.cheap or s.model.is_time_model):
        return []
    below, known = min(f.chi2 for f in grown), {f.hypothesis.key for f in grown}
    found = joint(s, base, judge, scores, first, known, below)
    if not s.cheap or beyond_scatter(base) < BENT:
        return found
    return [*found, *plain(s, judge, first, known | {f.hypothesis.key for f in found}, below)]


def _concluded(
    s: Setting,
    judge: Judge,
    base: Fit,
    best: Fit,
    tried: list[Fit],
    blind: tuple[Addition, ...],
    singles: Sequence[Hypothesis],
) -> Outcome:
    """All under the judge at the end, which counts a smooth error as noise if the best hypothesis leaves one.

    Not before: what a second effect does to sweeps is smooth, too. Then single effects are screened again,
    as their optima may lie elsewhere.
    """
    lead = by_own_noise(s, judge, best, tried)
    may = judge.temper == 1.0 and near_smooth(s, judge, lead, plain_white(lead))
    smooth = smooth_error(judge, lead)[2] if may else None
    found = None if smooth is None else _with_smooth(s, judge, smooth, base, best, tried, blind, singles)
    if found is not None:
        return found
    base, best, *tried = [judge.look(f.hypothesis, f.theta) for f in (base, best, *tried)]
    fair = among_rivals(s, judge, best, [base, best, *tried])
    if fair is not judge:
        tried = [fair.look(f.hypothesis, f.theta) for f in (best, *tried)]
        best = min((f for f in tried if len(f.ids) == len(best.ids)), key=lambda f: f.bic)
    return Outcome(fair, base, best, tuple(tried), blind)


FARTHER = 9.0
"""Times the squares of a hypothesis' residuals to which a smooth error may lead, no more."""


def _with_smooth(
    s: Setting,
    judge: Judge,
    smooth: Smooth,
    base: Fit,
    best: Fit,
    tried: Sequence[Fit],
    blind: tuple[Addition, ...],
    singles: Sequence[Hypothesis],
) -> Outcome | None:
    """The outcome under a smooth error of the instrument; None where that would become all of the recording:
    a model of next to nothing misses all of it, smoothly."""
    lnf = [np.log(x.inputs[s.model.axis]) for x in s.series]
    plain = tuple(replace(x.whitener, ar=None) for x in s.series)
    smoothed = replace(
        judge, whiteners=with_smooth(plain, lnf, smooth, quietness(s.series, plain)), smooth=smooth
    )
    old = base
    judge, base, fits = judged_anew(s, smoothed, base, tried)
    if best.ids:
        fits = better_of(fits, screened(s, base, judge, singles)[1])
    chosen = base
    for size in range(1, len(best.ids) + 1):
        first = min((f for f in fits if len(f.ids) == size), key=lambda f: f.bic)
        alarm = ALARM * (size - len(chosen.ids))
        if chosen.bic - first.bic > alarm and own_gain(s, judge, chosen, first) > alarm:
            chosen = first
    before = next((f for f in (old, *tried) if f.hypothesis.key == chosen.hypothesis.key), old)
    if misfit(chosen) > FARTHER * misfit(before):
        return None
    return Outcome(judge, base, chosen, tuple(fits), blind)


def _from_there(judge: Judge, best: Fit, winner: Fit) -> Fit:
    """`best` fitted again from where a `winner` that holds it has taken its parameters: for the same
    reason."""
    if not best.hypothesis.key < winner.hypothesis.key or not best.ids:
        return best
    start = winner.hypothesis.values_of(winner.theta, best.hypothesis)
    return min(best, judge.fit(best.hypothesis, [start]), key=lambda f: f.bic)
