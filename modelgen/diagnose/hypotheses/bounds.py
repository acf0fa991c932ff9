"""Parameters at their bounds: which are held there, what has come to nothing, how many count."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from modelgen.diagnose.hypotheses.hypothesis import Hypothesis
from modelgen.diagnose.hypotheses.pasts import is_past
from modelgen.fit.experiment import Layout
from modelgen.fit.whitener import Array


def moving(layout: Layout, theta: Array, shapes: Collection[str] = ()) -> Array:
    """Which parameters, (p,) bool, are not held by a bound.

    An effect's shape on its bound has been chosen there like any other value: it counts as within.
    """
    chosen = np.array([n in shapes for n in layout.names], dtype=bool)
    return np.asarray(~at_ends(layout, theta).any(axis=1) | chosen)


def at_ends(layout: Layout, theta: Array) -> Array:
    """(p, 2) bool: which parameters are at their lower, and at their upper bound."""
    low, high = np.array([p.bounds for p in layout.parameters], dtype=float).reshape(-1, 2).T
    size = np.where(np.isfinite(high - low), high - low, np.maximum(np.abs(theta), 1e-300))
    away = np.stack([np.abs(theta - low), np.abs(high - theta)], axis=1)
    return np.asarray(away <= 1e-9 * size[:, None])


def held_in(h: Hypothesis, theta: Array) -> set[str]:
    """Names of the parameters of a hypothesis that are at a bound."""
    ends = at_ends(h.experiment.layout, theta)
    return {n for n, at in zip(h.names, ends.tolist(), strict=True) if any(at)}


def vanished(h: Hypothesis, theta: Array) -> bool:
    """Whether an effect of a hypothesis is driven to nothing: its model is that of fewer effects."""
    value = dict(zip(h.names, theta.tolist(), strict=True))
    return any(all(value.get(n, x) == x for n, x in a.nulls.items()) for a in h.added)


def free(layout: Layout, theta: Array, shapes: Collection[str] = (), pasts: Collection[str] = ()) -> int:
    """Number of parameters that count: a passive element driven to nothing costs nothing, nor does a past at
    its end; on a bound that says no more than where a search stops, a parameter costs like any other."""
    ends = [p.bounds for p in layout.parameters]
    none = [0.0 in b and abs(x) <= max(map(abs, b)) / 2 for b, x in zip(ends, theta.tolist(), strict=True)]
    nothing = np.array(none, dtype=bool) | is_past(layout, pasts)
    return int(np.count_nonzero(moving(layout, theta, shapes) | ~nothing))
