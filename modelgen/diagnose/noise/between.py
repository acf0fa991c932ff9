"""How a recorded input ran between its samples: straight, as a model with states takes it, or smoothly.

Of a wave, straight lines leave (sin x/x)² = 1 − x²/3 + …, x = ω Δt/2 (R. W. Hamming, Digital Filters (1989),
ch. 3). A twelfth of the second difference taken away beforehand gives that back. At a dozen samples a cycle
it is 2 %, which at a resonance is far more than noise.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import ALARM
from modelgen.diagnose.noise.replica import on
from modelgen.fit.series import Array, input_noise
from modelgen.language import Model
from modelgen.recordings import Case, Recording

EVEN = 1e-2
"""Steps of time that differ by less, relative, are even."""


def smoothly_driven(model: Model, case: Case, base: Fit, judge: Judge) -> Case | None:
    """The case with inputs whose straight lines do what smooth ones would, where `base` fits far better by
    them; else None."""
    from modelgen.codegen.inputs import complete_inputs

    names = _driving(model)
    if not names:
        return None
    smooth = replace(case, recordings=tuple(_lifted(model, r, names) for r in case.recordings))
    e = base.hypothesis.experiment
    series = tuple(
        replace(s, inputs=complete_inputs(model, r.inputs, input_noise(model, smooth, r))[0])
        for s, r in zip(e.series, smooth.fit, strict=True)
    )
    return smooth if judge.fit(on(base.hypothesis, series), [base.theta]).bic < base.bic - ALARM else None


def _driving(model: Model) -> set[str]:
    """Recorded inputs that drive states: those, but time and motions, of which the value before is taken."""
    derived = [i.derived for i in model.inputs if i.derived]
    others = {of for how, of in derived if how != "previous"} | {model.axis}
    return {of for how, of in derived if how == "previous"} - others if model.is_time_model else set()


def _lifted(model: Model, r: Recording, names: set[str]) -> Recording:
    steps = np.diff(r.inputs[model.axis])
    if r.n < 3 or np.ptp(steps) > EVEN * float(np.mean(steps)):
        return r
    return replace(r, inputs={n: _sharpened(x) if n in names else x for n, x in r.inputs.items()})


def _sharpened(x: Array) -> Array:
    bend = np.zeros(len(x))
    bend[1:-1] = np.diff(x, 2)
    return np.asarray(x - bend / 12)
