"""Score tests: how much of the base's residual an effect's first derivative explains that the base's own do
not."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from modelgen.diagnose.hypotheses.addition import Addition
from modelgen.diagnose.hypotheses.hypothesis import Hypothesis
from modelgen.fit.pool import slices
from modelgen.fit.whitener import Array, Whitener

BLIND = 1e-7
"""Share of a derivative's square that must be left beside the base's sensitivities; less is a parameter
renamed."""
CANCELLED = 1e-3
"""Share of its length from which on a column less what the base's sensitivities make of it is exact enough;
of what is shorter they are taken off once more."""
ALIKE = 1e-13
"""Square of what two strengths' parts differ in, over their own, below which they count as one."""
AT_ONCE = 500_000
"""Numbers that are kept of the places of a grid: no more than the cache holds."""


@dataclass(frozen=True, eq=False)
class Score:
    """The result for one effect: χ² explained at first order, and the starting points that explained most.

    blind: at first order it does what the base's own parameters do. scouts: where the effect's grid is fine,
    as there are resonances to be met, the best of each of its places, in their order.
    """

    hypothesis: Hypothesis
    gain: float
    starts: tuple[tuple[float, Mapping[str, float]], ...]
    blind: bool
    scouts: tuple[tuple[float, Mapping[str, float]], ...] = ()

    @property
    def addition(self) -> Addition:
        return self.hypothesis.added[-1]

    def some(self, count: int) -> list[Mapping[str, float]]:
        """At most `count` of the scouts, of neighbours the best."""
        if not count:
            return []
        width = max(1, -(-len(self.scouts) // count))
        blocks = (self.scouts[k : k + width] for k in range(0, len(self.scouts), width))
        return [max(block, key=lambda x: x[0])[1] for block in blocks]


@dataclass(frozen=True, eq=False)
class Tangent:
    """Residual and sensitivities of a fitted hypothesis: r (N,) and an orthonormal basis q (N, p) of its
    Jacobian."""

    r: Array
    q: Array

    @staticmethod
    def of(r: Array, J: Array) -> Tangent:
        size = np.linalg.norm(J, axis=0)
        kept = J[:, size > 0] / size[size > 0]
        u, s, _ = (
            np.linalg.svd(kept, full_matrices=False)
            if kept.shape[1]
            else (np.zeros((len(r), 0)), np.zeros(0), None)
        )
        return Tangent(r, u[:, s > 1e-10 * (s[0] if s.size else 1.0)])

    def off(self, columns: Array) -> Array:
        """The part of `columns` (..., N, k) that no change of the fitted parameters can make."""
        rows = np.swapaxes(columns, -1, -2)
        whole = rows.reshape(-1, rows.shape[-1])  # all at once, and as they lie in memory
        rest = whole - (whole @ self.q) @ self.q.T
        little = np.einsum("kn,kn->k", rest, rest) < CANCELLED**2 * np.einsum("kn,kn->k", whole, whole)
        if little.any():
            rest[little] -= (rest[little] @ self.q) @ self.q.T
        return np.swapaxes(rest.reshape(rows.shape), -1, -2)

    def products(self, columns: Array) -> tuple[Array, Array, Array]:
        """Of the parts of `columns` (m, N, k) that no change of the fitted parameters can make, without
        making them: their products with each other (m, k, k) and with the residual (m, k); and the squares of
        the whole columns (m, k)."""
        rows = np.swapaxes(columns, -1, -2)  # as they lie in memory
        shape, whole = rows.shape[:2], rows.reshape(-1, rows.shape[-1])
        taken, along, square = whole @ self.q, whole @ self.r, np.einsum("kn,kn->k", whole, whole)
        little = np.flatnonzero(square - np.sum(taken**2, axis=1) < CANCELLED**2 * square)
        if little.size:  # a small difference of large numbers: these are made
            whole = whole.copy()
            whole[little] = self.off(whole[little].T).T
            taken[little] = 0.0
            along[little] = whole[little] @ self.r
        along -= taken @ (self.r @ self.q)
        whole, taken = whole.reshape(rows.shape), taken.reshape(*shape, -1)
        among = whole @ np.swapaxes(whole, -1, -2) - taken @ np.swapaxes(taken, -1, -2)
        return among, along.reshape(shape), square.reshape(shape)


def score(
    h: Hypothesis,
    base: Hypothesis,
    theta: Array,
    tangent: Tangent,
    whiteners: Sequence[Whitener],
    keep: int = 3,
    points: Sequence[Mapping[str, float]] | None = None,
) -> Score:
    """Score test of the last effect of `h` over the grid of its shapes (or at `points`), at the base's
    fit."""
    a = h.added[-1]
    grid = list(a.grid if points is None else points)
    judged = _secants if a.effect.secant else _slopes
    tries: list[tuple[float, Mapping[str, float]]] = []
    for part in slices(len(grid), -(-len(grid) * len(tangent.r) * len(a.strengths) // AT_ONCE)):
        places = h.places(base, theta, grid[part])
        for point, found in zip(grid[part], judged(h, tangent, whiteners, places), strict=True):
            if found is not None:
                tries.append((found[0], {**point, **found[1]}))
    blind = not tries
    if blind and not a.effect.secant:
        tries = [*_finite(h, base, theta, tangent, whiteners)]
    tries.sort(key=lambda x: -x[0])
    best = tries[0][0] if tries else 0.0
    return Score(h, best, tuple(_apart(tries, keep)), blind, tuple(_scouts(a, tries)))


Tries = Sequence[tuple[float, Mapping[str, float]]]


def _scouts(a: Addition, tries: Tries) -> Tries:
    """Of each place of resonances that was tried (best first), the best shape otherwise."""
    found: dict[float, tuple[float, Mapping[str, float]]] = {}
    for gain, values in tries:
        if a.place in values:
            found.setdefault(values[a.place], (gain, values))
    return [found[place] for place in sorted(found)]


def _apart(
    tries: list[tuple[float, Mapping[str, float]]], keep: int
) -> list[tuple[float, Mapping[str, float]]]:
    """The best starting points, not all from one place of the grid."""
    chosen: list[tuple[float, Mapping[str, float]]] = []
    for gain, values in tries:
        if len(chosen) == keep:
            break
        if not chosen or (gain > 0 and all(_far(values, v) for _, v in chosen)):
            chosen.append((gain, values))
    return chosen


def _far(a: Mapping[str, float], b: Mapping[str, float]) -> bool:
    """Whether two starting points differ by more than a neighbour's step in some shape."""
    return any(abs(a[k] - b[k]) > 0.35 * max(abs(a[k]), abs(b[k])) for k in a if k in b)


Found = tuple[float, dict[str, float]] | None
"""What is gained, and with which strengths; nothing where the base's parameters do the same."""


def _slopes(h: Hypothesis, tangent: Tangent, whiteners: Sequence[Whitener], places: Array) -> Iterator[Found]:
    """One-sided scores of the strengths' derivatives at null, at each of `places` (m, p)."""
    names = h.added[-1].strengths
    index = [h.names.index(n) for n in names]
    null = places[:, index]
    low, high = np.array([h.experiment.layout.parameters[i].bounds for i in index]).T
    with np.errstate(all="ignore"):
        among, along, square = tangent.products(h.experiment.columns(places, index, whiteners))
        size = np.einsum("mkk->mk", among)  # of what the base's parameters leave
        seen = size > BLIND * square
        told = np.all(np.isfinite(square), axis=1) & seen.any(axis=1)
        step = -along / size
        for k in np.flatnonzero(told) if len(names) > 1 else ():
            step[k] = 0.0
            which = np.ix_(seen[k], seen[k])
            step[k, seen[k]] = np.linalg.lstsq(among[k][which], -along[k, seen[k]], rcond=ALIKE)[0]
        step = np.clip(null + step, low, high) - null  # as far as its bounds let it
        gain = -np.sum(step * (2 * along + np.einsum("mjk,mk->mj", among, step)), axis=1)
        # if it had the sign that physics forbids, a small start in the allowed direction all the same
        allowed = np.where(low >= null, 1.0, -1.0)
        small = np.clip(null + allowed * 0.1 / np.sqrt(np.maximum(size, 1e-300)), low, high)
    moves = step.any(axis=1)
    gain, values = np.where(moves, gain, 0.0), np.where(moves[:, None], null + step, small)
    for tells, found, strengths in zip(told, gain.tolist(), values.tolist(), strict=True):
        yield (found, dict(zip(names, strengths, strict=True))) if tells else None


def _finite(
    h: Hypothesis, base: Hypothesis, theta: Array, tangent: Tangent, whiteners: Sequence[Whitener]
) -> list[tuple[float, dict[str, float]]]:
    """Strengths that change the output about as much as the residual has, and what they gain, where the
    derivatives tell nothing: a little of the effect is a parameter renamed, much of it may not be."""
    names = h.added[-1].strengths
    sums, least = h.experiment.sums(whiteners), np.linalg.norm(tangent.r)
    null = h.place(base, theta, {})

    def of(size: float) -> Array:
        """θ with strengths of a `size` each, in their own units, as far as their bounds let them."""
        place = null.copy()
        for i in map(h.names.index, names):
            low, high = h.experiment.layout.parameters[i].bounds
            place[i] = np.clip(null[i] + (size if null[i] + size <= high else -size), low, high)
        return place

    few, many = DECADES
    with np.errstate(all="ignore"):
        for _ in range(HALVINGS):
            middle = (few + many) / 2
            change = float(np.linalg.norm(sums.residuals(of(10.0**middle)) - tangent.r))
            few, many = (middle, many) if change < least else (few, middle)
    places = np.array([of(share * 10.0**few) for share in SHARES])
    found = _secants(h, tangent, whiteners, places)
    index = [h.names.index(n) for n in names]
    return [
        (max(0.0, f[0]) if f else 0.0, dict(zip(names, place[index].tolist(), strict=True)))
        for f, place in zip(found, places, strict=True)
    ]


DECADES, HALVINGS = (-15.0, 12.0), 7
"""Of a strength, in its unit, between which that is looked for, and how often the range is halved."""
SHARES = (1.0, 0.3, 0.1, 0.03)
"""Of that strength, that are tried."""


def _secants(h: Hypothesis, tangent: Tangent, whiteners: Sequence[Whitener], places: Array) -> list[Found]:
    """Gain of the finite change that a strength makes at each of `places` (m, p), with the base's parameters
    free to follow."""
    with np.errstate(all="ignore"):
        changes = h.experiment.sums(whiteners).residuals(places) - tangent.r
        finite = np.all(np.isfinite(changes), axis=1)
        found = tangent.products(np.where(finite[:, None], changes, 0.0)[..., None])
        size, along, square = found[0][:, 0, 0], found[1][:, 0], found[2][:, 0]
        told = finite & (size > BLIND * square)
        scale = np.clip(-along / size, 0.0, 1.0)
        gains = -scale * (2 * along + scale * size)
    return [(float(gain), {}) if tells else None for gain, tells in zip(gains, told, strict=True)]
