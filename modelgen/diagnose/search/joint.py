"""Pairs of effects that explain the base's residual together, whatever each does alone.

A beam holds what explains much alone. Two effects of which either is hidden by the other are in none.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from modelgen.diagnose.hypotheses.hypothesis import make_hypotheses
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import Setting
from modelgen.diagnose.search.screen import Score, Tangent
from modelgen.fit.series import Array

PAIRS = 12
"""Pairs that are fitted."""
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
        null = {f"{a.id}_{q.name}": q.null for q in a.effect.strengths}
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
) -> list[Fit]:
    """Fits of the pairs that at first order beside the base's own parameters promise most, but for `known`.

    first: fits of single effects, from which the pairs start as well.
    """
    tangent = Tangent.of(*judge.tangent(base))
    changes = [c for x in scores for c in _changes(x, base, judge, tangent)]
    chosen = [c for c in _best(changes, tangent) if _key(c[0], c[1]) not in known][:PAIRS]
    made = make_hypotheses(
        s.model, s.case, s.series, [(a.score.addition, b.score.addition) for a, b, _, _ in chosen]
    )
    where = {_key(a, b): (a.scaled(x), b.scaled(y)) for a, b, x, y in chosen}
    alone = {f.hypothesis.key: f for f in first}
    fits = []
    for h in made:
        start = where[h.key]
        starts = [h.place(base.hypothesis, base.theta, {**start[0], **start[1]})]
        for k, a in enumerate(h.added):
            f = alone.get(frozenset([a.key]))
            if f is not None:
                starts.append(h.place(f.hypothesis, f.theta, start[1 - k]))
        fits.append(judge.fit(h, starts))
    return fits


def _key(a: _Change, b: _Change) -> frozenset[tuple[str, str, int]]:
    return frozenset((a.score.addition.key, b.score.addition.key))


def _changes(x: Score, base: Fit, judge: Judge, tangent: Tangent) -> list[_Change]:
    """What the effect does at the values that its score took for the best."""
    a, h, found = x.addition, x.hypothesis, []
    index = [h.names.index(n) for n in a.strengths]
    for _, values in x.starts:
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


def _best(changes: Sequence[_Change], tangent: Tangent) -> list[tuple[_Change, _Change, float, float]]:
    """Pairs of different effects, that which explains most first, with the parts of their changes; one law
    of each."""
    C = np.stack([c.change for c in changes], axis=1)
    size = np.linalg.norm(C, axis=0)
    G, b = (C / size).T @ (C / size), -(C / size).T @ tangent.r
    rest = np.where(np.abs(G) < ALIKE, 1 - G**2, np.inf)
    parts = (b[:, None] - G * b[None, :]) / rest  # of the first of a pair; those of the second by transposing
    gain = np.where((parts > 0) & (parts.T > 0), parts * b[:, None] + parts.T * b[None, :], 0.0)
    found: dict[frozenset[str], tuple[_Change, _Change, float, float]] = {}
    for k in np.argsort(-np.triu(gain, 1), axis=None):
        i, m = divmod(int(k), len(changes))
        ids = frozenset((changes[i].score.addition.id, changes[m].score.addition.id))
        if i >= m or gain[i, m] <= 0:
            break
        if len(ids) == 2 and ids not in found:
            found[ids] = (changes[i], changes[m], float(parts[i, m] / size[i]), float(parts[m, i] / size[m]))
    return list(found.values())
