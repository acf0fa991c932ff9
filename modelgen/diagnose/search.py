"""The search over hypotheses: screen, refit, take in one effect after another while the evidence grows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from modelgen.diagnose.evidence import levels
from modelgen.diagnose.grow import grow
from modelgen.diagnose.hypothesis import Addition, Hypothesis, make_hypotheses
from modelgen.diagnose.joint import joint
from modelgen.diagnose.recolour import gross, judged_anew, own_colour, recolour, recolour_pairs
from modelgen.diagnose.refit import Fit, Judge, base_starts, misfit, plain_white
from modelgen.diagnose.replica import motion_matters, replicas, undeserved
from modelgen.diagnose.screen import Score, Tangent, score
from modelgen.diagnose.setting import ALARM, Outcome, Progress, Setting
from modelgen.diagnose.smooth_error import quietness, smooth_error, with_smooth
from modelgen.diagnose.swap import better_of, other_laws, parts, swapped
from modelgen.fit.experiment import initial_parameters
from modelgen.fit.scatter import local_scatter
from modelgen.fit.series import Array, Series

WORTH = 0.9
"""Where models stay far from the data, an effect must take away a tenth of the misfit to be named."""
IMPERFECT = 0.01
"""Share of the evidence so far that a law of the right family leaves, a tenth off: no second effect."""
SEEN = 0.998
"""Where far more than noise is left, a further effect must be seen in the recordings as they are, and not
only in what a filter of that rest leaves of them."""
MOSTLY = 0.25
"""Share of the evidence that coloured noise must leave, or it may be that."""
FAR = 2.3
"""Residuals this many times the noise are looked into further, although no single effect explains them."""
ASIDE = (0.97, 1.0, 1.03)
"""Factors of a strength between which descents have kinks to overcome."""
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
    scores, first = _screen(s, base, judge, singles)
    better = _from_singles(judge, base, first)
    if base.bic - better.bic > 1.0:  # the base had not been at its optimum: judge anew from there
        base = better
        scores, first = _screen(s, base, judge, singles)
    first = swapped(s, base, judge, first, scores)
    blind = tuple(x.addition for x in scores if x.blind)
    judge, base, first = recolour(s, judge, base, first)
    if progress:
        progress(0.6, "fitting")
    judge, first = _deserved(s, judge, [base], first)
    best, grown, tried = base, first, {f.hypothesis.key: f for f in first}
    beam: list[Fit] = []
    for depth in range(1, MOST + 1):
        if depth > 1:
            if progress:
                progress(0.5 + 0.15 * depth, f"looking for {'a second' if depth == 2 else 'a third'} effect")
            judge, base, best, grown = _deeper(s, judge, base, best, beam, scores, first)
            if not grown:
                break
            tried |= {f.hypothesis.key: f for f in grown}
            best = min([best, *(f for f in grown if len(f.ids) == len(best.ids))], key=lambda f: f.bic)
            grown = [f for f in grown if len(f.ids) == depth]
        winner = min([best, *grown], key=lambda f: f.bic)
        best = _from_there(judge, best, winner)
        if winner is not best and _gains(s, judge, base, best, winner):
            best = winner
        elif not _hidden(s, judge, best, winner, depth):
            break
        beam = sorted(grown, key=lambda f: f.bic)[: s.beam]
    if len(best.ids) > 1 and not s.cheap:
        laws = other_laws(s, base, judge, best, scores)
        tried |= {f.hypothesis.key: f for f in laws}
        best = min([best, *(f for f in laws if len(f.ids) == len(best.ids))], key=lambda f: f.bic)
    best, less = _pruned(s, judge, base, best)
    return _concluded(s, judge, base, best, tuple(better_of(list(tried.values()), less)), blind)


def _pruned(s: Setting, judge: Judge, base: Fit, best: Fit) -> tuple[Fit, list[Fit]]:
    """`best` without effects that it no longer needs, as those that came later say the same better; and all
    that was fitted to see it."""
    found: list[Fit] = []
    while True:
        less = parts(s, judge, best)
        found += less
        part = min(less, key=lambda f: f.bic, default=best)
        if part is best or _gains(s, judge, base, part, best):
            return best, found
        best = part


def _deeper(
    s: Setting,
    judge: Judge,
    base: Fit,
    best: Fit,
    beam: Sequence[Fit],
    scores: Sequence[Score],
    first: Sequence[Fit],
) -> tuple[Judge, Fit, Fit, list[Fit]]:
    """Judge, base and best, and fits with one effect more than those of the beam."""
    depth = 1 + len(beam[0].ids)
    if not s.model.is_time_model:  # the colour that wrong hypotheses leave hides what would be right
        judge = replace(white_judge(s.series), prior=judge.prior, temper=judge.temper)
        base, best, *beam = [judge.look(f.hypothesis, f.theta) for f in (base, best, *beam)]
    grown = grow(s, base, judge, beam, scores, first)
    if not grown:
        return judge, base, best, []
    judge, base, grown, best = recolour_pairs(s, judge, base, grown, best)
    if min(f.bic for f in grown) < best.bic - (0.0 if depth == 2 else ALARM):
        more = [*grown, *_together(s, base, judge, scores, first, grown, depth)]
        more = swapped(s, base, judge, more, scores)
        judge, base, grown, best = recolour_pairs(s, judge, base, more, best)
    judge, grown = _deserved(s, judge, [base, *beam], grown)
    return judge, base, best, grown


def _together(
    s: Setting,
    base: Fit,
    judge: Judge,
    scores: Sequence[Score],
    first: Sequence[Fit],
    grown: Sequence[Fit],
    depth: int,
) -> list[Fit]:
    """Pairs of sweeps' effects that no beam led to."""
    if depth != 2 or s.model.is_time_model or not s.cheap:
        return []
    return joint(s, base, judge, scores, first, {f.hypothesis.key for f in grown})


def _hidden(s: Setting, judge: Judge, best: Fit, winner: Fit, depth: int) -> bool:
    """Whether one effect more may show what is not claimed yet.

    A smooth error that nobody stated may forbid to claim `winner`, and two effects together be told from it;
    or what no single effect explains is far more than noise, and two together do.
    """
    if depth != len(best.ids) + 1:
        return False
    if depth == 1 and _far(winner):
        return True
    return not s.model.is_time_model and judge.temper == 1.0 and best.bic - winner.bic > ALARM


def _far(fit: Fit) -> bool:
    """Whether residuals are larger than a noise that is wrong by a factor of two."""
    return any(float(np.mean(e[e != 0] ** 2)) > FAR**2 for e in plain_white(fit) if np.any(e))


def _concluded(
    s: Setting, judge: Judge, base: Fit, best: Fit, tried: tuple[Fit, ...], blind: tuple[Addition, ...]
) -> Outcome:
    """All under the judge at the end, which counts a smooth error as noise if the best hypothesis leaves one.

    Not before: what a second effect does to sweeps is smooth, too.
    """
    smooth = None if s.model.is_time_model or judge.temper > 1.0 else smooth_error(judge, best)[2]
    if smooth is None:
        look = [judge.look(f.hypothesis, f.theta) for f in (base, best, *tried)]
        return Outcome(judge, look[0], look[1], tuple(look[2:]), blind)
    lnf = [np.log(x.inputs[s.model.axis]) for x in s.series]
    plain = tuple(replace(x.whitener, ar=None) for x in s.series)
    smoothed = replace(
        judge, whiteners=with_smooth(plain, lnf, smooth, quietness(s.series, plain)), smooth=smooth
    )
    judge, base, fits = judged_anew(s, smoothed, base, tried)
    chosen = base
    for size in range(1, len(best.ids) + 1):
        first = min((f for f in fits if len(f.ids) == size), key=lambda f: f.bic)
        alarm = ALARM * (size - len(chosen.ids))
        if chosen.bic - first.bic > alarm and _own_gain(s, judge, chosen, first) > alarm:
            chosen = first
    return Outcome(judge, base, chosen, tuple(fits), blind)


def _deserved(s: Setting, judge: Judge, parents: Sequence[Fit], fits: list[Fit]) -> tuple[Judge, list[Fit]]:
    """Take from the best of `fits` what errors of the motion give them beside the parent they grew from."""
    if judge.temper > 1.0 or not s.model.is_time_model or not motion_matters(s.series):
        return judge, fits
    made: dict[frozenset[tuple[str, str, int]], tuple[Series, ...]] = {}
    for _ in range(3 * s.beam):
        first = sorted(fits, key=lambda f: f.bic)[: s.beam]
        child = next((f for f in first if f.hypothesis.key not in judge.excess), None)
        if child is None:
            break
        parent = min((p for p in parents if p.hypothesis.key < child.hypothesis.key), key=lambda p: p.bic)
        key = parent.hypothesis.key
        if key not in made:
            made[key] = replicas(s.model, s.case, parent, seed=len(key))
        own = judge.excess.get(key, 0.0) + undeserved(judge, parent, child, made[key])
        judge = replace(judge, excess={**judge.excess, child.hypothesis.key: own})
        fits = [judge.look(f.hypothesis, f.theta) if f is child else f for f in fits]
    return judge, fits


def _gains(s: Setting, judge: Judge, base: Fit, old: Fit, new: Fit) -> bool:
    """Whether the evidence for `new` is enough: under the common noise, and with each fit's own colour of
    noise.

    The second is the likelihood in which smooth misfit may be coloured noise; it guards against colours that
    the richer hypothesis has taken for itself. What errors of the motion alone would give must be gained
    twice: replicas are made from a path that is smoothed already. A further effect must gain more than what a
    law that is not quite right would leave.
    """
    alarm = ALARM * (len(new.ids) - len(old.ids))
    if not s.model.is_time_model and any(w.ar is not None for w in judge.whiteners):
        alarm *= 2  # a sweep is too short to tell a colour well
    if judge.temper > 1.0:
        return old.bic - new.bic > alarm and new.chi2 < WORTH * old.chi2
    undeserved = judge.excess.get(new.hypothesis.key, 0.0) - judge.excess.get(old.hypothesis.key, 0.0)
    # with no more numbers it mends no law that is nearly right, but is another account
    imperfect = IMPERFECT * max(0.0, base.bic - old.bic) if new.parameters > old.parameters else 0.0
    if old.bic - new.bic < alarm + max(0.0, undeserved) + imperfect:
        return False
    if old.ids and _far(new) and misfit(new) > SEEN * misfit(old):
        return False
    own = _own_gain(s, judge, old, new)
    if s.model.is_time_model or len(old.ids) != 1:
        slow = s.model.is_time_model and own < MOSTLY * (old.bic - new.bic)  # noise of 1/f has no order
        return own > (3 * alarm if slow else alarm)
    # a second effect in sweeps is smooth, as coloured noise is: where it may be mostly that, more is asked
    return own > (2 * alarm if own < MOSTLY * (old.bic - new.bic) else 0.0)


def _own_gain(s: Setting, judge: Judge, old: Fit, new: Fit) -> float:
    """What `new` gains on `old`, each with its own colour of noise."""
    return own_colour(s, judge, old) - own_colour(s, judge, new)


def _screen(
    s: Setting, base: Fit, judge: Judge, singles: Sequence[Hypothesis]
) -> tuple[list[Score], list[Fit]]:
    """Score tests of all single effects at the base's fit, and fits of the most promising.

    What first order can't show is fitted, too: it is blind only if that gains nothing.
    """
    tangent = Tangent.of(*judge.tangent(base))
    scores = [score(h, base.hypothesis, base.theta, tangent, judge.whiteners) for h in singles]
    fits = _refit_singles(s, base, judge, scores)
    for theta in s.others:
        away = judge.fit(base.hypothesis, [theta])
        if abs(away.bic - base.bic) > 1.0:
            tangent = Tangent.of(*judge.tangent(away))
            there = [score(h, base.hypothesis, away.theta, tangent, judge.whiteners, 1) for h in singles]
            fits = better_of(fits, _refit_singles(s, away, judge, there))
    gained = {f.hypothesis.key for f in fits if base.bic - f.bic > ALARM}
    return [replace(x, blind=x.blind and x.hypothesis.key not in gained) for x in scores], fits


def _from_singles(judge: Judge, base: Fit, singles: Sequence[Fit]) -> Fit:
    """The base fitted again from where the best singles have taken its parameters: none may win by a better
    start."""
    starts = [base.theta]
    for f in sorted(singles, key=lambda f: f.bic)[:3]:
        starts.append(f.hypothesis.values_of(f.theta, base.hypothesis))
    return judge.fit(base.hypothesis, starts, iterations=150)


def _from_there(judge: Judge, best: Fit, winner: Fit) -> Fit:
    """`best` fitted again from where a `winner` that holds it has taken its parameters: for the same
    reason."""
    if not best.hypothesis.key < winner.hypothesis.key or not best.ids:
        return best
    start = winner.hypothesis.values_of(winner.theta, best.hypothesis)
    return min(best, judge.fit(best.hypothesis, [start]), key=lambda f: f.bic)


def _refit_singles(s: Setting, base: Fit, judge: Judge, scores: Sequence[Score]) -> list[Fit]:
    """Fits of the most promising single effects (all, where that is cheap)."""
    seen = sorted((x for x in scores if x.starts), key=lambda x: -x.gain)
    count = len(seen) if s.cheap else s.refits
    # a base far from the data may be bent too far for a way back: from its defaults, too
    defaults = base_starts(base.hypothesis, 0, 1) if gross(s, plain_white(base)) else []
    fits = []
    for k, x in enumerate(seen[:count]):
        places = [(base.theta, v) for _, v in (x.starts if k < 12 else x.starts[:1])]
        places += [(theta, x.starts[0][1]) for theta in defaults]
        starts = [x.hypothesis.place(base.hypothesis, theta, v) for theta, v in places]
        fits.append(judge.fit(x.hypothesis, starts))
    if s.cheap and not s.model.is_time_model:
        fits = _scouted(base, judge, seen, fits)
    fits.sort(key=lambda f: f.bic)
    return [_unhooked(judge, f) if k < s.beam else f for k, f in enumerate(fits)]


FAINT = 0.1
"""Part of what the first order promises from which descents start, too."""
BENT = 1.1
"""Residuals this many times the scatter between neighbours: the first orders of a
bent base tell little."""


def _scouted(base: Fit, judge: Judge, seen: Sequence[Score], fits: Sequence[Fit]) -> list[Fit]:
    """`fits` of sweeps by what was `seen`, again where the first order has led astray: from little of an
    effect where it reached too far, and, while no fit is near the noise, from wherever resonances may lie."""
    white = plain_white(min(fits, key=lambda f: f.chi2, default=base))
    over = [float(np.mean(x**2)) / local_scatter(x) ** 2 for e in white for x in e if x.size > FEWEST]
    bent = bool(over) and float(np.mean(over)) > BENT**2
    found = []
    for x, f in zip(seen, fits, strict=False):
        starts = [x.hypothesis.place(base.hypothesis, base.theta, v) for v in x.scouts] if bent else []
        if f.chi2 > base.chi2:
            starts += [_faint(x, base, v) for _, v in x.starts]
        other = judge.fit(x.hypothesis, starts, few=SCOUTS) if starts else f
        found.append(min((f, other), key=lambda f: f.bic))
    return found


SCOUTS = 6
"""Descents that go on: in a narrow resonance they are slow at first."""
FEWEST = 15
"""Samples that tell a scatter."""


def _faint(x: Score, base: Fit, values: Mapping[str, float]) -> Array:
    """A start with little of an effect."""
    start = x.hypothesis.place(base.hypothesis, base.theta, values)
    null = x.hypothesis.place(base.hypothesis, base.theta, {})
    at = [x.hypothesis.names.index(n) for n in x.addition.strengths]
    start[at] = null[at] + FAINT * (start[at] - null[at])
    return start


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
