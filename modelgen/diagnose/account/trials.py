"""The hypotheses that a verdict lists, with their evidence."""

from __future__ import annotations

import numpy as np

from modelgen.diagnose.hypotheses.bounds import vanished
from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.ranking import weights
from modelgen.diagnose.hypotheses.refit import Fit
from modelgen.diagnose.hypotheses.setting import Outcome
from modelgen.diagnose.verdict import Trial

SHOWN, BEYOND = 40, 10
"""Hypotheses that a verdict lists, with no more effects than it names and with more."""


def trials(outcome: Outcome) -> tuple[Trial, ...]:
    """The best of what was tried, each set of effects once; none of which nothing is left but fewer."""
    first: dict[frozenset[str], Fit] = {}
    for f in sorted((f for f in outcome.tried if not vanished(f.hypothesis, f.theta)), key=lambda f: f.bic):
        first.setdefault(frozenset(f.ids), f)
    count = max(len(outcome.best.ids), 1)
    few = [f for f in first.values() if len(f.ids) <= count][:SHOWN]
    more = [f for f in first.values() if len(f.ids) > count][:BEYOND]
    # to be claimed, one effect more must gain far more; beside nothing missing none has a share
    equals = [f for f in few if len(f.ids) == len(outcome.best.ids) > 0]
    odds = dict(zip(map(id, equals), weights(equals), strict=True)) if equals else {}
    places: dict[str, set[str]] = {}
    for a in (a for f in outcome.tried for a in f.hypothesis.added):
        places.setdefault(a.id, set()).add(a.port.name)
    return tuple(
        Trial(f.ids, " + ".join(a.family for a in f.hypothesis.added), f.bic - outcome.base.bic, f.parameters,
              float(np.sqrt(f.chi2 / effective(f.white))), float(odds.get(id(f), np.nan)),
              tuple(a.port.name if len(places[a.id]) > 1 else "" for a in f.hypothesis.added))
        for f in (*few, *more)
    )  # fmt: skip
