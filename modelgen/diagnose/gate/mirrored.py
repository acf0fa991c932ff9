"""Recordings with the other sign: impedances of the other sign of time, whose imaginary parts have it; forces
that count positive the other way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modelgen.diagnose.hypotheses.hypothesis import make_hypotheses
from modelgen.diagnose.hypotheses.refit import Fit, misfit
from modelgen.diagnose.hypotheses.starts import base_starts
from modelgen.diagnose.search.search import white_judge
from modelgen.fit.series import Series, make_series
from modelgen.language import Model
from modelgen.recordings import Case

FAR = 9.0
"""Mean square of whitened residuals from which a base may be that of the mirror image."""
LESS = 0.1
"""Share of χ² that is left where the mirror image is the better account."""


def mirrored(model: Model, case: Case, base: Fit, seed: int) -> tuple[str, ...]:
    """A note where the base, far from impedances as recorded, is near their complex conjugates."""
    series = base.hypothesis.experiment.series
    far = base.chi2 > FAR * sum(e.size for e in base.white)
    if not far or any(s.measure != "complex" for s in series):
        return ()
    records = [replace(r, outputs={k: np.conj(x) for k, x in r.outputs.items()}) for r in case.fit]
    turned = tuple(
        replace(make_series(model, case, r), whitener=replace(s.whitener, weight=np.conj(s.whitener.weight)))
        for r, s in zip(records, series, strict=True)
    )
    other = _refitted(model, case, turned, base, seed)
    if other.chi2 > LESS * base.chi2:
        return ()
    return (
        f"the model is {np.sqrt(base.chi2 / other.chi2):.2g} times nearer to the complex conjugate of these "
        "recordings: their Im Z may have the sign of e^(−jωt), wanted that of e^(+jωt)",
    )


def opposed(model: Model, case: Case, base: Fit, best: Fit, seed: int) -> tuple[str, ...]:
    """A note where the base, far from what was recorded over time, is near its negative, and nearer than the
    `best` that effects make of it: a mass on a spring may look so, but it would have been found."""
    series = base.hypothesis.experiment.series
    far = base.chi2 > FAR * sum(e.size for e in base.white)
    if not far or not model.is_time_model or len(series[0].data) != 1:
        return ()
    other = _refitted(model, case, [replace(s, data=-s.data) for s in series], base, seed)
    if misfit(other) > min(LESS * misfit(base), misfit(best)):
        return ()
    nearer = np.sqrt(misfit(base) / misfit(other))
    return (
        f"the model alone is {nearer:.2g} times nearer to the negative of these recordings: "
        f"{model.outputs[0].name} may count positive the other way",
    )


def _refitted(model: Model, case: Case, turned: Sequence[Series], base: Fit, seed: int) -> Fit:
    """The base fitted to recordings that have been `turned`."""
    h = make_hypotheses(model, case, turned, [()])[0]
    return white_judge(turned).fit(h, [base.theta, *base_starts(h, seed, 8)])
