"""The search over hypotheses: screen, refit, take in one effect after another while the evidence grows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from modelgen.diagnose.evidence import bic, levels
from modelgen.diagnose.hypothesis import Addition, Hypothesis, make_hypotheses
from modelgen.diagnose.noise import correlation_length, local_level
from modelgen.diagnose.refit import Fit, Judge, refine
from modelgen.diagnose.replica import motion_matters, replicas, undeserved
from modelgen.diagnose.screen import Score, Tangent, score
from modelgen.diagnose.smooth_error import smooth_error, with_smooth
from modelgen.fit.colour import coloured
from modelgen.fit.series import Array, Series
from modelgen.language import Model
from modelgen.recordings import Case

ALARM = 10.0
"""ΔBIC that an effect must gain to be claimed: with thirty candidates a false alarm in less than one of a
hundred."""
CLOSE = 10.0
"""ΔBIC within which the data do not exclude a hypothesis."""
GROSS_STATED, GROSS_ESTIMATED = 3.0, 8.0
"""A residual this many times the noise (stated; scatter between neighbours) is a wrong model's, not coloured
noise."""
WORTH = 0.9
"""Where models stay far from the data, an effect must take away a tenth of the misfit to be named."""
IMPERFECT = 0.005
"""Share of the evidence so far that a law of the right family leaves, seven percent off: no second effect."""
SLACK = 1.5
"""A refit may gain this many times what the score promised at first order."""
MOST = 3
"""Effects in one verdict."""
COMPANIONS = 4
"""Families whose best single effects are tried beside each hypothesis of the beam."""
COLOUR_TIME, COLOUR_SWEEP = 12, 3
"""Greatest order of a noise's colour along time, and along a sweep's frequencies."""

Progress = Callable[[float, str], None] | None


@dataclass(frozen=True, eq=False)
class Setting:
    """What a search works on."""

    model: Model
    case: Case
    series: tuple[Series, ...]
    additions: tuple[Addition, ...]
    beam: int = 3
    refits: int = 12
    pairs: int = 5

    @property
    def colour(self) -> int:
        return COLOUR_TIME if self.model.is_time_model else COLOUR_SWEEP


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a search found, all under the judge at its end: the base, the chosen fit, and all that were
    tried."""

    judge: Judge
    base: Fit
    best: Fit
    tried: tuple[Fit, ...]
    blind: tuple[Addition, ...]


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
    blind = tuple(x.addition for x in scores if x.blind)
    judge, base, first = _recolour(s, judge, base, first)
    if progress:
        progress(0.6, "fitting")
    judge, first = _deserved(s, judge, [base], first)
    best, grown, tried = base, first, {f.hypothesis.key: f for f in first}
    beam: list[Fit] = []
    for depth in range(1, MOST + 1):
        if depth > 1:
            if progress:
                progress(0.5 + 0.15 * depth, f"looking for {'a second' if depth == 2 else 'a third'} effect")
            grown = _grow(s, base, judge, beam, scores, first)
            if not grown:
                break
            judge, base, grown, best = _recolour_pairs(s, judge, base, grown, best)
            judge, grown = _deserved(s, judge, beam, grown)
            tried |= {f.hypothesis.key: f for f in grown}
        winner = min([best, *grown], key=lambda f: f.bic)
        if winner is not best and _gains(s, judge, base, best, winner):
            best = winner
        elif not _hidden(s, judge, best, winner, depth):
            break
        beam = sorted(grown, key=lambda f: f.bic)[: s.beam]
    return _concluded(s, judge, base, best, tuple(tried.values()), blind)


def _hidden(s: Setting, judge: Judge, best: Fit, winner: Fit, depth: int) -> bool:
    """Whether only a smooth error that nobody stated forbids to claim `winner`: with one effect more it may
    be told from that."""
    sweeps = not s.model.is_time_model and judge.temper == 1.0
    return sweeps and depth == len(best.ids) + 1 and best.bic - winner.bic > ALARM


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
    smoothed = replace(judge, whiteners=with_smooth(plain, lnf, smooth))
    judge, base, fits = _judged_anew(s, smoothed, base, tried)
    chosen = base
    for size in range(1, len(best.ids) + 1):
        first = min((f for f in fits if len(f.ids) == size), key=lambda f: f.bic)
        if chosen.bic - first.bic > ALARM * (size - len(chosen.ids)):
            chosen = first
    return Outcome(judge, base, chosen, tuple(fits), blind)


def claimless(s: Setting, outcome: Outcome) -> Outcome:
    """The outcome if none of what was tried is claimed."""
    o = outcome
    return _concluded(s, o.judge, o.base, o.base, o.tried, o.blind)


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


def _gross(s: Setting, white: Sequence[Array]) -> bool:
    """Whether the best hypothesis leaves far more than noise."""
    for x, e in zip(s.series, white, strict=True):
        used = e[e != 0]
        if used.size and float(np.sqrt(np.mean(used**2))) > (GROSS_STATED if x.stated else GROSS_ESTIMATED):
            return True
    return False


def _gains(s: Setting, judge: Judge, base: Fit, old: Fit, new: Fit) -> bool:
    """Whether the evidence for `new` is enough: under the common noise, and with each fit's own colour of
    noise.

    The second is the likelihood in which smooth misfit may be coloured noise; it guards against colours that
    the richer hypothesis has taken for itself. What errors of the motion alone would give must be gained
    twice: replicas are made from a path that is smoothed already. A further effect must gain more than what a
    law that is not quite right would leave.
    """
    alarm = ALARM * (len(new.ids) - len(old.ids))
    if judge.temper > 1.0:
        return old.bic - new.bic > alarm and new.chi2 < WORTH * old.chi2
    undeserved = judge.excess.get(new.hypothesis.key, 0.0) - judge.excess.get(old.hypothesis.key, 0.0)
    if old.bic - new.bic < alarm + max(0.0, undeserved) + IMPERFECT * max(0.0, base.bic - old.bic):
        return False
    needed = 0.0 if len(old.ids) == 1 and not s.model.is_time_model else alarm
    return _own_colour(s, judge, old) - _own_colour(s, judge, new) > needed


def _own_colour(s: Setting, judge: Judge, f: Fit) -> float:
    """BIC of a fit under the colour of its own residual, in which lone samples count little.

    Colour many times as large as the independent noise is rare: −2 ln of its prior is twice its size.
    """
    plain = tuple(replace(w, ar=None) for w in judge.whiteners)
    white = [w.apply(f.hypothesis.experiment.raw(f.theta, k)) for k, w in enumerate(plain)]
    own = coloured(plain, white, s.colour)
    innovations = [w.apply(f.hypothesis.experiment.raw(f.theta, k)) for k, w in enumerate(own)]
    orders = sum(0 if w.ar is None else len(w.ar) - 1 for w in own)
    size = max(float(np.sqrt(np.mean(e[e != 0] ** 2))) if np.any(e) else 0.0 for e in white)
    found = bic(innovations, judge.prior, f.parameters, orders, robust=True) + 2 * size
    if s.model.is_time_model:
        return found
    plain_bic, gain, _ = smooth_error(judge, f)
    return plain_bic - max(gain, bic(white, judge.prior, f.parameters, robust=True) - found)


def _screen(
    s: Setting, base: Fit, judge: Judge, singles: Sequence[Hypothesis]
) -> tuple[list[Score], list[Fit]]:
    """Score tests of all single effects at the base's fit, and fits of the most promising."""
    tangent = Tangent.of(*judge.tangent(base))
    scores = [score(h, base.hypothesis, base.theta, tangent, judge.whiteners) for h in singles]
    return scores, _refit_singles(s, base, judge, scores)


def _from_singles(judge: Judge, base: Fit, singles: Sequence[Fit]) -> Fit:
    """The base fitted again from where the best singles have taken its parameters: none may win by a better
    start."""
    starts = [base.theta]
    for f in sorted(singles, key=lambda f: f.bic)[:3]:
        starts.append(f.theta[[f.hypothesis.names.index(n) for n in base.hypothesis.names]])
    return judge.fit(base.hypothesis, starts, iterations=150)


def _refit_singles(s: Setting, base: Fit, judge: Judge, scores: Sequence[Score]) -> list[Fit]:
    """Fits of the most promising single effects (all, where that is cheap)."""
    seen = sorted((x for x in scores if not x.blind and x.starts), key=lambda x: -x.gain)
    size = sum(x.n for x in s.series)
    count = len(seen) if size <= 3000 else s.refits
    fits = []
    for k, x in enumerate(seen[:count]):
        starts = x.starts if k < 12 else x.starts[:1]
        fits.append(
            judge.fit(x.hypothesis, [x.hypothesis.place(base.hypothesis, base.theta, v) for _, v in starts])
        )
    return fits


def _recolour(s: Setting, judge: Judge, base: Fit, fits: list[Fit]) -> tuple[Judge, Fit, list[Fit]]:
    """Judge again with the colour of the best hypothesis' residual, where that has one."""
    best = min([base, *fits], key=lambda f: f.bic)
    plain = tuple(replace(x.whitener, ar=None) for x in s.series)
    white = [w.apply(best.hypothesis.experiment.raw(best.theta, k)) for k, w in enumerate(plain)]
    if _gross(s, white):
        new = Judge(plain, judge.prior, correlation_length(white), judge.excess)
        return new, new.look(base.hypothesis, base.theta), [new.look(f.hypothesis, f.theta) for f in fits]
    filters = coloured(plain, white, s.colour)
    uneven = [
        local_level(w.colour(e)) if s.model.is_time_model else np.ones(e.shape[1])
        for w, e in zip(filters, white, strict=True)
    ]
    if any(np.any(u != 1) for u in uneven):
        plain = tuple(w.scaled(u) for w, u in zip(plain, uneven, strict=True))
        white = [w.apply(best.hypothesis.experiment.raw(best.theta, k)) for k, w in enumerate(plain)]
        filters = coloured(plain, white, s.colour)
    if all(w.ar is None for w in filters) and all(np.all(u == 1) for u in uneven):
        return judge, base, fits
    return _judged_anew(s, replace(judge, whiteners=filters), base, fits)


def _judged_anew(s: Setting, new: Judge, base: Fit, fits: Sequence[Fit]) -> tuple[Judge, Fit, list[Fit]]:
    """The best of `fits` and the base fitted again under a new judge, the rest looked at."""
    rough = sorted((new.look(f.hypothesis, f.theta) for f in fits), key=lambda f: f.bic)
    fitted = refine(new, rough[: s.refits]) + rough[s.refits :]
    return new, refine(new, [base])[0], fitted


def _recolour_pairs(
    s: Setting, judge: Judge, base: Fit, grown: list[Fit], best: Fit
) -> tuple[Judge, Fit, list[Fit], Fit]:
    new, newbase, fits = _recolour(s, judge, base, [*grown, best])
    return (
        new,
        newbase,
        fits[:-1] if new is judge else [f for f in fits if f.hypothesis is not best.hypothesis],
        (best if new is judge else next(f for f in fits if f.hypothesis is best.hypothesis)),
    )


def _grow(
    s: Setting, base: Fit, judge: Judge, beam: Sequence[Fit], scores: Sequence[Score], first: Sequence[Fit]
) -> list[Fit]:
    """Hypotheses with one effect more than those of the beam, fitted."""
    chosen = _promising(s, base, judge, beam, scores)
    if beam and len(beam[0].ids) == 1:
        for key, grown in _companions(beam, first).items():
            chosen.setdefault(key, grown)
    made = make_hypotheses(
        s.model, s.case, s.series, [(*g.fit.hypothesis.added, g.addition) for g in chosen.values()]
    )
    fits = []
    for h in made:
        g = chosen[h.key]
        starts = [h.place(g.fit.hypothesis, g.fit.theta, v) for v in g.values]
        if g.other is not None:
            own = dict(zip(g.fit.hypothesis.names, g.fit.theta, strict=True))
            starts.append(h.place(g.other.hypothesis, g.other.theta, _only(own, g.fit)))
        fits.append(judge.fit(h, starts))
    return fits


@dataclass(frozen=True, eq=False)
class Grown:
    """A fit and the effect to be added to it, from these values; `other`: a fit with this effect alone."""

    fit: Fit
    addition: Addition
    values: tuple[Mapping[str, float], ...]
    other: Fit | None = None


Key = frozenset[tuple[str, str, int]]


def _promising(
    s: Setting, base: Fit, judge: Judge, beam: Sequence[Fit], scores: Sequence[Score]
) -> dict[Key, Grown]:
    """The effects that by their score beside the beam's fits promise most."""
    wanted: list[tuple[float, Grown]] = []
    for f in beam:
        tangent = Tangent.of(*judge.tangent(f))
        inner = f.theta[[f.hypothesis.names.index(n) for n in base.hypothesis.names]]
        for x in scores:
            if x.addition.id in f.ids or x.blind:
                continue
            shapes = {f"{x.addition.id}_{q.name}" for q in x.addition.effect.shapes}
            if x.addition.effect.secant:
                shapes |= set(x.addition.strengths)
            points = [{k: v for k, v in values.items() if k in shapes} for _, values in x.starts]
            again = score(x.hypothesis, base.hypothesis, inner, tangent, judge.whiteners, 1, points)
            reach = f.bic - SLACK * again.gain - beam[0].bic
            if again.starts and reach < -ALARM:
                tried = (again.starts[0][1], *(v for _, v in x.starts[:2]))
                wanted.append((reach, Grown(f, x.addition, tried)))
    wanted.sort(key=lambda w: w[0])
    chosen: dict[Key, Grown] = {}
    for _, g in wanted:
        key = g.fit.hypothesis.key | {g.addition.key}
        if key not in chosen and len(chosen) < s.pairs * (2 if len(g.fit.ids) == 1 else 1):
            chosen[key] = g
    return chosen


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
