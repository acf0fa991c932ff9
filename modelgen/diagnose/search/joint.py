"""Pairs of effects that explain the base's residual together, whatever each does alone.

A beam holds what explains much alone. Two effects of which either is hidden by the other are in none.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, islice

import numpy as np

from modelgen.diagnose.hypotheses.hypothesis import Hypothesis, make_hypotheses
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import Setting
from modelgen.diagnose.search.screen import Score, Tangent
from modelgen.diagnose.search.swap import LOOSE
from modelgen.fit.series import Array

PAIRS, DEAR = 12, 3
"""Pairs that are fitted, and where fits are dear."""
SLACK = 1.5
"""Times what a pair promises that it may explain, where fits are dear."""
HIDING = 1.5
"""Times what its effects explain alone that a pair must, there: others a beam finds."""
STARTS = 4
"""Shapes of a pair from which descents start: of a narrow resonance the first order knows only the
neighbourhood."""
PLACES = 60
"""Of the places where an effect may resonate."""
ALIKE = 0.999
"""Changes of the output that are one and the same to this cosine make no pair."""


@dataclass(frozen=True, eq=False)
class _Change:
    """What an effect with these values does to the whitened residual; which part of it is its strengths'."""

    score: Score
    values: Mapping[str, float]
    change: Array

    def scaled(self, part: float) -> dict[str, float]:
        """The values with strengths `part` as far from null."""
        a = self.score.addition
        null = a.nulls
        most = 1.0 if a.effect.secant else np.inf
        return {
            k: null[k] + min(part, most) * (v - null[k]) if k in null else v for k, v in self.values.items()
        }


def joint(
    s: Setting,
    base: Fit,
    judge: Judge,
    scores: Sequence[Score],
    first: Sequence[Fit],
    known: Collection[object],
    below: float = np.inf,
) -> list[Fit]:
    """Fits of the pairs that at first order beside the base's own parameters promise most, but for `known`.

    first: fits of single effects, from which the pairs start as well. below: where fits are dear, those
    alone are made that may lead below this χ² and of which either hides the other, in one shape each, and
    none goes on that does not keep it.
    """
    tangent = Tangent.of(*judge.tangent(base))
    shapes = None if s.cheap else 1
    changes = [c for x in scores for c in _changes(x, base, judge, tangent, shapes)]
    if not changes:
        return []
    least = -np.inf if s.cheap else (float(tangent.r @ tangent.r) - below) / SLACK
    found = _best(changes, tangent, least, 0.0 if s.cheap else HIDING)
    new = (pairs[:shapes] for pairs in found if _key(pairs[0]) not in known)
    chosen = list(islice(new, PAIRS if s.cheap else DEAR))
    made = make_hypotheses(
        s.model, s.case, s.series, [tuple(c.score.addition for c in pairs[0].changes) for pairs in chosen]
    )
    where = {_key(pairs[0]): pairs for pairs in chosen}
    alone = {f.hypothesis.key: f for f in first}

    def fitted(h: Hypothesis) -> Fit:
        starts = [h.place(base.hypothesis, base.theta, {**a, **b}) for a, b in map(_values, where[h.key])]
        for k, a in enumerate(h.added):
            f = alone.get(frozenset([a.key]))
            if f is not None:
                starts += [h.place(f.hypothesis, f.theta, _values(p)[1 - k]) for p in where[h.key]]
        return judge.fit(h, starts, worth=LOOSE * below if s.cheap else below)

    return s.each(fitted, made)


def plain(
    s: Setting, judge: Judge, first: Sequence[Fit], known: Collection[object], below: float
) -> list[Fit]:
    """Fits of pairs at one port of effects that have strengths alone, but for `known`, from either's own fit
    (in `first`): they are few, and where the base is far off no first order tells which.

    below: as in `joint`.
    """
    alone = [f for f in first if not f.hypothesis.shapes and not f.hypothesis.added[0].effect.secant]
    pairs = {
        f.hypothesis.key | g.hypothesis.key: (f, g)
        for f, g in combinations(alone, 2)
        if f.ids != g.ids and f.hypothesis.added[0].port.name == g.hypothesis.added[0].port.name
    }
    pairs = {key: pair for key, pair in pairs.items() if key not in known}
    both = [tuple(f.hypothesis.added[0] for f in pair) for pair in pairs.values()]
    made = make_hypotheses(s.model, s.case, s.series, both)

    def fitted(h: Hypothesis) -> Fit:
        starts = [h.place(f.hypothesis, f.theta, {}) for f in pairs[h.key]]
        return judge.fit(h, starts, worth=LOOSE * below)

    return s.each(fitted, made)


@dataclass(frozen=True, eq=False)
class _Pair:
    """Two changes, and the parts of them that together explain most."""

    changes: tuple[_Change, _Change]
    parts: tuple[float, float]


def _key(p: _Pair) -> frozenset[tuple[str, str, int]]:
    return frozenset(c.score.addition.key for c in p.changes)


def _values(p: _Pair) -> tuple[dict[str, float], dict[str, float]]:
    (a, b), (x, y) = p.changes, p.parts
    return a.scaled(x), b.scaled(y)


def _changes(x: Score, base: Fit, judge: Judge, tangent: Tangent, most: int | None) -> list[_Change]:
    """What the effect does at the values (the first `most`) that its score took for the best, and wherever
    it may resonate."""
    a, h, found = x.addition, x.hypothesis, []
    index = [h.names.index(n) for n in a.strengths]
    for values in (*(v for _, v in x.starts), *x.some(PLACES))[:most]:
        at = h.place(base.hypothesis, base.theta, values)
        with np.errstate(all="ignore"):
            if a.effect.secant:
                white = h.experiment.whitened(at, judge.whiteners)
                change = np.concatenate([w.ravel() for w in white]) - tangent.r
            else:
                null = h.place(
                    base.hypothesis, base.theta, {k: v for k, v in values.items() if k not in a.strengths}
                )
                change = h.experiment.columns(null, index, judge.whiteners) @ (at - null)[index]
            rest = tangent.off(change[:, None])[:, 0] if np.all(np.isfinite(change)) else change * 0.0
        if rest @ rest > 0:
            found.append(_Change(x, values, rest))
    return found


def _best(changes: Sequence[_Change], tangent: Tangent, least: float, hiding: float) -> Iterator[list[_Pair]]:
    """Pairs of different effects that explain more than `least`, and than `hiding` times what either does
    alone, those that explain most first, with the parts of their changes; one law of each, in the few shapes
    that explain most."""
    C = np.stack([c.change for c in changes], axis=1)
    size = np.linalg.norm(C, axis=0)
    C /= size
    G, b = C.T @ C, -C.T @ tangent.r
    rest = np.where(np.abs(G) < ALIKE, 1 - G**2, np.inf)
    parts = (b[:, None] - G * b[None, :]) / rest  # of the first of a pair; those of the second by transposing
    gain = np.where((parts > 0) & (parts.T > 0), parts * b[:, None] + parts.T * b[None, :], 0.0)
    alone = np.maximum(b, 0.0) ** 2
    gain = np.where(gain > hiding * (alone[:, None] + alone[None, :]), gain, 0.0)
    ids, effect = np.unique([c.score.addition.id for c in changes], return_inverse=True)
    one, other = np.nonzero(np.triu(gain > max(least, 0.0), 1) & (effect[:, None] != effect))
    order = np.argsort(-gain[one, other], kind="stable")
    one, other = one[order], other[order]
    both = np.sort([effect[one], effect[other]], axis=0)
    which = both[0] * len(ids) + both[1]
    for first in np.sort(np.unique(which, return_index=True)[1]):
        alike = np.flatnonzero(which[first:] == which[first]) + first
        pairs = (
            _Pair((changes[i], changes[m]), (float(parts[i, m] / size[i]), float(parts[m, i] / size[m])))
            for i, m in zip(one[alike].tolist(), other[alike].tolist(), strict=True)
        )
        best = next(pairs)
        yield [best, *islice((p for p in pairs if _key(p) == _key(best)), STARTS - 1)]
