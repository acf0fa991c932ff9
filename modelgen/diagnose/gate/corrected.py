"""The base fitted to sweeps as they would be without an error of how they were taken."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.search.screen import Tangent
from modelgen.fit.series import Array, Series

STEPS, ITERATIONS = 6, 10
"""Times that the error is found anew beside the base, and steps of the base's fits there."""
ENOUGH = 0.1
"""BIC that a step must gain for another."""


def corrected(
    judge: Judge, base: Fit, columns: Callable[[Fit], Array], without: Callable[[Array], tuple[Series, ...]]
) -> tuple[Fit, Array]:
    """(The fit that leaves least, amounts (k,) of the error); columns: whitened (N, k), what the residual of
    a fit gains of its amounts; without: the sweeps without so much of it."""
    amounts = np.zeros(columns(base).shape[1])
    best, fit, found = base, base, amounts
    for _ in range(STEPS):
        tangent, changes = Tangent.of(*judge.tangent(fit)), columns(fit)
        if not np.all(np.isfinite(changes)):  # two samples have come to stand for one frequency
            break
        amounts = amounts - np.linalg.lstsq(tangent.off(changes), tangent.r, rcond=1e-10)[0]
        e = replace(base.hypothesis.experiment, series=without(amounts))
        fit = judge.fit(replace(base.hypothesis, experiment=e), [fit.theta], ITERATIONS)
        if not fit.bic < best.bic - ENOUGH:
            break
        best, found = fit, amounts
    return best, found
