"""Effects of a hypothesis exchanged for others, the rest of it kept: the way out of a beam's dead ends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import inf

from modelgen.diagnose.hypotheses.addition import Addition
from modelgen.diagnose.hypotheses.hypothesis import Hypothesis, make_hypotheses
from modelgen.diagnose.hypotheses.refit import Fit, Judge, Remembering
from modelgen.diagnose.hypotheses.setting import CLOSE, Setting
from modelgen.diagnose.search.far import BENT, beyond_scatter
from modelgen.diagnose.search.grow import own_values, points_of
from modelgen.diagnose.search.screen import Score, Tangent, score
from modelgen.fit.series import Array

ROUNDS = 4
"""Exchanges one after another."""
BEST, FEW = 10, 6
"""Effects that are tried in the place of one, and where fits are dear."""
LOOSE = 3.0
"""Those that promise to leave so many times the χ² of the best are not, and those that a few steps have left
with so much do not go on."""
STRONG = 5
"""Effects that alone were best, which are tried in the place of one at the same port."""
CROSSED = 2
"""The best of each place that are tried together."""
RIVALS = 3 * CLOSE
"""ΔBIC within which another law may make a hypothesis the best one."""
MOVED, PLACES = 4, 24
"""The best hypotheses whose resonances are moved, and to how many places."""
Key = frozenset[tuple[str, str, int]]


def swapped(
    s: Setting, base: Fit, judge: Judge, fits: Sequence[Fit], scores: Sequence[Score], first: Sequence[Fit]
) -> list[Fit]:
    """`fits` with those in addition that the best one leads to by exchanges, while they make it better; and
    what is left of it without one of its effects.

    An effect that explains little alone, or whose derivative is the base's own, is in no beam; beside the
    right partner it is seen. Only where fits are cheap. first: the single effects, fitted.
    """
    found = {f.hypothesis.key: f for f in sorted(fits, key=lambda f: -f.bic)}
    if not fits or not s.cheap:
        return list(fits)
    judge = Remembering(**vars(judge))  # rounds come back to the same fits; what they are worth only falls
    done: set[tuple[Key, bool]] = set()
    every, singles = False, {f.hypothesis.added[0].key: f for f in first}
    places_of = {x.addition.key: x.some(PLACES) for x in scores if x.scouts}
    for _ in range(ROUNDS):
        best = min(found.values(), key=lambda f: f.bic)
        places = [a for a in best.hypothesis.added if (best.hypothesis.key - {a.key}, every) not in done]
        done |= {(best.hypothesis.key - {a.key}, every) for a in places}
        most = len(scores) if every else BEST
        _keep(found, [f for a in places for f in _exchanges(s, base, judge, best, a, scores, most, singles)])
        if len(best.ids) == 2:
            _keep(found, _crossed(s, judge, best, found))
        if len(best.ids) > 1:
            _keep(found, _guided(s, judge, min(found.values(), key=lambda f: f.bic), found))
        if len(best.ids) > 1 and not s.model.is_time_model:
            _keep(found, _elsewhere(s, judge, found, len(best.ids), places_of))
        stays = min(f.bic for f in found.values()) > best.bic - 1.0
        few = s.model.is_time_model or len(best.ids) != 2 or beyond_scatter(best) < BENT
        if stays and (every or few):
            break
        # first orders tell little of what is far: before a pair is kept that leaves much of a sweep, all
        every = stays
    return list(found.values())


def exchanged(
    s: Setting, base: Fit, judge: Judge, best: Fit, scores: Sequence[Score], done: frozenset[Key]
) -> tuple[list[Fit], frozenset[Key]]:
    """`best` with each of its effects exchanged for other laws of the same physics, and for the few others
    that promise most, and of a pair both: a beam follows what gains first. Where fits are dear.

    done: what effects have been exchanged beside; it is returned with what they are now.
    """
    found: dict[Key, Fit] = {}
    places = [a for a in best.hypothesis.added if best.hypothesis.key - {a.key} not in done]
    for a in places:
        _keep(found, _exchanges(s, base, judge, best, a, scores, FEW, {}, scouting=True))
    if len(best.ids) == 2:
        _keep(found, _crossed(s, judge, best, found))
    return list(found.values()), done | {best.hypothesis.key - {a.key} for a in places}


def by_other_laws(
    s: Setting, base: Fit, judge: Judge, best: Fit, tried: Sequence[Fit], scores: Sequence[Score]
) -> list[Fit]:
    """The rivals of several effects that the best ones have, each effect by its other laws: what led the best
    one from law to law was not led through theirs."""
    if len(best.ids) < 2:
        return []
    near = [f for f in tried if len(f.ids) == len(best.ids) and f.bic - best.bic < RIVALS]
    first = {frozenset(f.ids): f for f in sorted(near, key=lambda f: -f.bic) if set(f.ids) != set(best.ids)}
    found: list[Fit] = []
    for f in first.values():
        for a in f.hypothesis.added:
            laws = [x for x in scores if x.addition.id == a.id]
            if len(laws) > 1:
                found += _exchanges(s, base, judge, f, a, laws, len(laws), {}, scouting=True)
    return found


def _keep(found: dict[Key, Fit], fits: Sequence[Fit]) -> None:
    """Put into `found` what is new, or better than what it has."""
    for f in fits:
        known = found.get(f.hypothesis.key)
        if known is None or f.bic < known.bic:
            found[f.hypothesis.key] = f


def _exchanges(
    s: Setting,
    base: Fit,
    judge: Judge,
    best: Fit,
    old: Addition,
    scores: Sequence[Score],
    most: int,
    singles: Mapping[tuple[str, str, int], Fit],
    scouting: bool = False,
) -> list[Fit]:
    """Fits with other effects, the `most` promising, in the place of `old`, and of the rest alone.

    They are scored from the values that the rest has beside `old`, where what is missing may be too much for
    a derivative; and from the rest's own optimum, which may be far from the truth. What the base alone can
    imitate shows only beside the others, so its score says nothing, and it is tried; so are other laws of
    the same physics, where fits are cheap what has fewer numbers at the same port, and what as one of the
    `singles` was as good, from its shapes there. scouting: in any shape, as what these were beside a bent
    base tells little. Where fits are dear those do not go on that a few steps have not brought halfway from
    the base to the best one.
    """
    kept = tuple(a for a in best.hypothesis.added if a.key != old.key)
    rest = make_hypotheses(s.model, s.case, s.series, [kept])[0]
    beside = judge.look(rest, rest.place(best.hypothesis, best.theta, {}))
    alone = judge.fit(rest, [beside.theta])
    usable = [x for x in scores if x.addition.key != old.key and x.addition.id not in rest.ids]
    found: dict[tuple[str, str, int], list[Promise]] = {}
    for f in (beside, alone):
        for p in promised(s, base, judge, f, usable, scouting):
            found.setdefault(p.addition.key, []).append(p)
    chosen = sorted(found.values(), key=_least)[:most]
    if most < len(scores):
        chosen = [c for c in chosen if _least(c) < LOOSE * _least(chosen[0])]
    always = [a.key for a in (x.addition for x in usable if x.blind) if a.port.name == old.port.name]
    always += [x.addition.key for x in usable if x.addition.id == old.id]
    always += [x.addition.key for x in usable if s.cheap and _plainer(x.addition, old)]
    always += _as_good(old, singles)
    chosen += [found[key] for key in dict.fromkeys(always) if key in found and found[key] not in chosen]
    made = make_hypotheses(s.model, s.case, s.series, [(*kept, c[0].addition) for c in chosen])
    halfway = 0.5 * (best.chi2 + max(base.chi2, best.chi2))
    worth = LOOSE * best.chi2 if s.cheap else min(LOOSE * best.chi2, halfway)

    def fitted(h: Hypothesis) -> Fit:
        key = h.added[-1].key
        starts = [h.place(rest, p.theta, p.values) for p in found[key]]
        if key in singles:
            starts.append(h.place(rest, beside.theta, own_values(singles[key], h.added[-1])))
        f = judge.fit(h, starts, worth=worth)
        return f if s.cheap else judge.revived(f, beside)

    return ([alone] if kept else []) + s.each(fitted, made)


def _plainer(a: Addition, old: Addition) -> bool:
    """Whether `a` has fewer numbers than `old`, at the same port: a flexible law may have taken its place."""
    return a.port.name == old.port.name and a.count < old.count


def _as_good(old: Addition, singles: Mapping[tuple[str, str, int], Fit]) -> list[tuple[str, str, int]]:
    """Keys of what as a single effect was as good as `old`, and of what was best at its port: of each physics
    the best law. Without an effect that is far from small, a first order tells nothing of others."""
    own = singles[old.key].bic if old.key in singles else -inf
    ranked = sorted(singles.values(), key=lambda f: f.bic)
    there = [f.hypothesis.added[0] for f in ranked if f.hypothesis.added[0].port.name == old.port.name]
    near = [f.hypothesis.added[0] for f in ranked if abs(f.bic - own) < CLOSE]
    best = {a.id: a.key for a in reversed(there)}
    strong = [best[i] for i in list(dict.fromkeys(a.id for a in there))[:STRONG]]
    return [*{a.id: a.key for a in reversed(near)}.values(), *strong]


def better_of(fits: Sequence[Fit], others: Sequence[Fit]) -> list[Fit]:
    """Of each hypothesis the better fit."""
    found = {f.hypothesis.key: f for f in fits}
    _keep(found, others)
    return list(found.values())


@dataclass(frozen=True, eq=False)
class Promise:
    """χ² that an effect would leave at first order, from θ of the rest with these values of its own."""

    left: float
    addition: Addition
    theta: Array
    values: Mapping[str, float]


def _least(promises: Sequence[Promise]) -> float:
    return min(p.left for p in promises)


def promised(
    s: Setting, base: Fit, judge: Judge, f: Fit, scores: Sequence[Score], scouting: bool = False
) -> list[Promise]:
    """What each effect promises beside f: in the shapes that explained most alone or, `scouting`, in any."""
    tangent = Tangent.of(*judge.tangent(f))
    inner = f.hypothesis.values_of(f.theta, base.hypothesis)
    whole = float(tangent.r @ tangent.r)

    def scored(x: Score) -> Score:
        points = None if scouting else points_of(x)
        return score(x.hypothesis, base.hypothesis, inner, tangent, judge.whiteners, 1, points)

    return [
        Promise(whole - x.gain, x.addition, f.theta, x.starts[0][1])
        for x in s.each(scored, scores)
        if x.starts
    ]


def _crossed(s: Setting, judge: Judge, best: Fit, found: dict[Key, Fit]) -> list[Fit]:
    """Pairs of what is best in the place of either effect of the best pair, both exchanged at once."""
    places = []
    for a in best.hypothesis.added:
        kept = best.hypothesis.key - {a.key}
        rivals = [f for key, f in found.items() if len(key) == 2 and kept < key and f is not best]
        rivals.sort(key=lambda f: f.bic)
        places.append([(_other(f.hypothesis, kept), f) for f in rivals[:CROSSED]])
    chosen = {
        frozenset((x.key, y.key)): (x, f, y, g)
        for (x, f), (y, g) in product(*places)
        if x.id != y.id and frozenset((x.key, y.key)) not in found
    }
    made = make_hypotheses(s.model, s.case, s.series, [(x, y) for x, _, y, _ in chosen.values()])
    return s.each(lambda h: judge.fit(h, _starts(h, *chosen[h.key]), worth=LOOSE * best.chi2), made)


def _guided(s: Setting, judge: Judge, best: Fit, found: Mapping[Key, Fit]) -> list[Fit]:
    """The hypotheses that differ from the best one in one effect, fitted again from where that has taken what
    they share: another partner may have left it elsewhere, and none may win by its start."""

    def guided(f: Fit) -> Fit:
        a = next(a for a in f.hypothesis.added if a.key not in best.hypothesis.key)
        start = f.hypothesis.place(best.hypothesis, best.theta, own_values(f, a))
        return judge.fit(f.hypothesis, [start], worth=LOOSE * best.chi2)

    others = [f for f in found.values() if len(f.ids) == len(best.ids)]
    return s.each(guided, [f for f in others if len(f.hypothesis.key - best.hypothesis.key) == 1])


def _elsewhere(
    s: Setting,
    judge: Judge,
    found: Mapping[Key, Fit],
    size: int,
    places_of: Mapping[tuple[str, str, int], Sequence[Mapping[str, float]]],
) -> list[Fit]:
    """The best hypotheses with `size` effects of which one resonates, fitted again from where else it may: as
    the only effect it had to say what its partners say now, and a descent takes it no long way."""
    again = []
    for f in sorted((f for f in found.values() if len(f.ids) == size), key=lambda f: f.bic):
        moved = [
            f.hypothesis.place(f.hypothesis, f.theta, {a.place: values[a.place]})
            for a in f.hypothesis.added
            for values in places_of.get(a.key, ())
        ]
        again += [(f, moved)] if moved else []

    def fitted(part: tuple[Fit, list[Array]]) -> Fit:
        f, moved = part
        return judge.fit(f.hypothesis, moved, worth=LOOSE * f.chi2)

    return s.each(fitted, again[:MOVED])


def _starts(h: Hypothesis, x: Addition, f: Fit, y: Addition, g: Fit) -> list[Array]:
    """From either of two fits, one with x and one with y, the other's effect beside it."""
    beside_x = h.place(f.hypothesis, f.theta, own_values(g, y))
    return [beside_x, h.place(g.hypothesis, g.theta, own_values(f, x))]


def _other(h: Hypothesis, kept: Key) -> Addition:
    return next(a for a in h.added if a.key not in kept)
