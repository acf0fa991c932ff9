"""What a sample had been through before each record, of which a base with a memory knows nothing."""

from __future__ import annotations

from dataclasses import replace

from modelgen.diagnose.hypotheses.hypothesis import make_hypotheses
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import ALARM
from modelgen.fit.experiment import initial_parameters
from modelgen.language import Model
from modelgen.recordings import Case


def unrested(model: Model, case: Case, base: Fit, judge: Judge) -> Case | None:
    """The case in which numbers are free, in each record its own, that a model's memory begins with and holds
    as known, where `base` fits far better by them; else None."""
    if not model.is_time_model:
        return None
    stated = set(case.constants) | {n for r in case.recordings for n in r.constants} | set(case.bounds)
    initial = initial_parameters(model) - stated
    held = [p for p in model.scalar_parameters if p.known and p.name in initial]
    if not held:
        return None
    free = replace(case, bounds={**case.bounds, **{p.name: p.bounds for p in held}})
    made = make_hypotheses(model, free, base.hypothesis.experiment.series, [()])
    if not made:
        return None
    h = made[0]
    begin = {p.name: p.default for p in held if p.default is not None}
    first = {n: begin[n.partition("[")[0]] for n in h.names if n.partition("[")[0] in begin}
    starts = [h.place(base.hypothesis, base.theta, first)]
    found = judge.fit(h, starts)
    return free if found.bic < base.bic - ALARM * len(case.fit) else None


def had_rested(model: Model, rested: Case, best: Fit, judge: Judge) -> bool:
    """Whether the best hypothesis explains the recordings nearly as well where all `rested` before: what the
    base made up for by a past is what was missing."""
    series = best.hypothesis.experiment.series
    for h in make_hypotheses(model, rested, series, [best.hypothesis.added]):
        found = judge.fit(h, [h.place(best.hypothesis, best.theta, {})])
        return found.bic < best.bic + ALARM * len(rested.fit)
    return False
