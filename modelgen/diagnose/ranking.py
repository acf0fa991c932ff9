"""How sure: which hypotheses the data do not exclude, and with which probability."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modelgen.diagnose.hypothesis import Addition
from modelgen.diagnose.refit import Fit
from modelgen.diagnose.setting import CLOSE, TEMPER, Outcome


@dataclass(frozen=True)
class Standing:
    """One effect of the verdict among its rivals: its probability, and ids that explain the data as well."""

    addition: Addition
    probability: float
    equivalents: tuple[str, ...]
    share: float


def weights(fits: Sequence[Fit]) -> np.ndarray:
    """Posterior odds of rival fits: evidence times how common their physics is, normalised."""
    best = min(f.bic for f in fits)
    logs = np.array([-(f.bic - best) / (2 * TEMPER) for f in fits])
    w = np.exp(logs - logs.max())
    return np.asarray(w / w.sum())


def standings(outcome: Outcome) -> tuple[Standing, ...]:
    """The effects of the best fit, the one that explains most first, each with its rivals.

    Rivals of an effect are the tried hypotheses that differ from the best one in this effect alone.
    """
    best = outcome.best
    found = []
    for a in best.hypothesis.added:
        rest = best.hypothesis.key - {a.key}
        rivals = [
            f
            for f in outcome.tried
            if len(f.hypothesis.key) == len(best.hypothesis.key) and rest <= f.hypothesis.key
        ]
        if not any(f.hypothesis is best.hypothesis for f in rivals):
            rivals.append(best)
        w = weights(rivals)
        by_id: dict[str, float] = {}
        close: dict[str, float] = {}
        for f, x in zip(rivals, w, strict=True):
            other = next(b for b in f.hypothesis.added if b.key not in rest)
            by_id[other.id] = by_id.get(other.id, 0.0) + float(x)
            if f.bic - best.bic < CLOSE:
                close[other.id] = min(close.get(other.id, np.inf), f.bic)
        equivalents = tuple(sorted((i for i in close if i != a.id), key=lambda i: close[i]))
        found.append(Standing(a, by_id[a.id], equivalents, _share(outcome, a)))
    return tuple(sorted(found, key=lambda x: -x.share))


def _share(outcome: Outcome, a: Addition) -> float:
    """The part of the explained misfit that goes when this effect alone is left out of the best
    hypothesis."""
    best = outcome.best
    without = [f for f in outcome.tried if f.hypothesis.key == best.hypothesis.key - {a.key}]
    level = min((f.chi2 for f in without), default=outcome.base.chi2)
    span = outcome.base.chi2 - best.chi2
    return float(np.clip((level - best.chi2) / span, 0.0, 1.0)) if span > 0 else 1.0
