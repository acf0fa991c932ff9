"""Impedances that were recorded with the other sign of time: their imaginary parts have the other sign."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modelgen.diagnose.hypotheses.hypothesis import make_hypotheses
from modelgen.diagnose.hypotheses.refit import Fit, base_starts
from modelgen.diagnose.search.search import white_judge
from modelgen.fit.series import make_series
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
    h = make_hypotheses(model, case, turned, [()])[0]
    other = white_judge(turned).fit(h, [base.theta, *base_starts(h, seed, 8)])
    if other.chi2 > LESS * base.chi2:
        return ()
    return (
        f"the model is {np.sqrt(base.chi2 / other.chi2):.2g} times nearer to the complex conjugate of these "
        "recordings: their Im Z may have the sign of e^(−jωt), wanted that of e^(+jωt)",
    )
