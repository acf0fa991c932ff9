"""Groups of terms that may describe what is left over time, and what each gains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modelgen.diagnose.gate.channels import shown
from modelgen.diagnose.gate.gains import gain_of
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.hypotheses.evidence import Level, effective
from modelgen.diagnose.search.screen import Tangent
from modelgen.fit.series import Series
from modelgen.fit.whitener import Array, Whitener
from modelgen.language import Model


@dataclass(frozen=True, eq=False)
class Tried:
    """A group of terms, with its gain as if noise had no colour; the residual `rest` (N,) that it leaves; and
    the price of its amounts and of looking."""

    left: Leftover
    rest: Array
    price: float


def channel_of(model: Model, s: Series, output: str) -> int:
    """Which channel of a recording shows an output; the first where none does."""
    names = shown(model, s)
    return names.index(output) if output in names else 0


def in_channel(w: Whitener, terms: Array, channel: int, outputs: int) -> Array:
    """Whitened columns (outputs·n, k) of `terms` (k, n) in one of a recording's channels."""
    there = np.zeros((outputs, *terms.shape))
    there[channel] = terms
    return np.asarray(w.apply(there).transpose(0, 2, 1).reshape(-1, len(terms)))


JUMP = "jump"
TOGETHER = {"position": 2, "shown": 1, JUMP: 1}
"""Groups of which only so many terms act at a time (a pitch, a limit): each is tried, at the price of
looking."""


def best_of(
    tangent: Tangent, columns: Array, prior: Sequence[Level], white: Sequence[Array], like: Leftover
) -> Tried:
    """The gain of a group of terms, which `like` names, all at once or the best few neighbours of them."""
    size, n, few = columns.shape[1], effective(white), TOGETHER.get(like.terms[0], 0)
    sets = [list(range(size))] if not few else [list(range(k, k + few)) for k in range(0, size, few)]
    price = 2 * float(np.log(len(sets)))
    own = _own(prior, white)
    first = _foremost(tangent, columns, few) if few else np.zeros(1, dtype=int)
    tried = {int(k): gain_of(tangent, columns[:, sets[k]], n, price, own) for k in first}
    best = max(tried, key=lambda k: tried[k][0])
    gain, chi2, rest = tried[best]
    left = replace(like, gain=float(gain), chi2=chi2, terms=(*like.terms, best))
    return Tried(left, rest, len(sets[best]) * float(np.log(n)) + price)


FOREMOST = 5
"""Sets of terms, those that explain most, of which it is looked at closely what they gain."""


def _foremost(tangent: Tangent, columns: Array, few: int) -> Array:
    """Which sets of so `few` neighbours of `columns` (N, k) explain most beside the fit, best first."""
    rest = tangent.off(columns)
    size = np.linalg.norm(rest, axis=0)
    size[size <= 1e-6 * np.linalg.norm(columns, axis=0)] = np.inf
    unit = (rest / size).reshape(len(rest), -1, few)
    along = np.einsum("nsk,n->sk", unit, tangent.r)
    gram = np.einsum("nsk,nsl->skl", unit, unit) + 1e-9 * np.eye(few)
    explained = np.sum(along * np.linalg.solve(gram, along[..., None])[..., 0], axis=1)
    return np.argsort(-explained)[:FOREMOST]


def _own(prior: Sequence[Level], white: Sequence[Array]) -> Array | None:
    """(N,) the noise's share in the variances of all residuals; None where it is all."""
    if all(p.own is None for p in prior):
        return None
    shares = [np.ones(e.shape) if p.own is None else p.own + 0 * e for p, e in zip(prior, white, strict=True)]
    return np.concatenate([x.ravel() for x in shares])
