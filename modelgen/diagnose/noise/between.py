"""How a recorded input ran between its samples: straight, as a model with states takes it, or smoothly.

Of a wave, straight lines leave (sin x/x)² = 1 − x²/3 + …, x = ω Δt/2 (R. W. Hamming, Digital Filters (1989),
ch. 3). A twelfth of the second difference taken away beforehand gives that back. At a dozen samples a cycle
it is 2 %, which at a resonance is far more than noise. A motion acts at once as well, and there it must stay
as it is: what a cubic's way from sample to sample changes of the base's output is taken off the recordings.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from modelgen.codegen import build_many
from modelgen.codegen.inputs import complete_inputs
from modelgen.codegen.lower import primary_outputs
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import ALARM
from modelgen.diagnose.noise.replica import on
from modelgen.fit.experiment import Experiment
from modelgen.fit.series import Array, input_noise
from modelgen.language import Model
from modelgen.language.derived import values_before
from modelgen.language.meant import expressions
from modelgen.recordings import Case, Recording

EVEN = 1e-2
"""Steps of time that differ by less, relative, are even."""


def smoothly_driven(model: Model, case: Case, base: Fit, judge: Judge) -> Case | None:
    """The case with inputs whose straight lines do what smooth ones would, where `base` fits far better by
    them; else None."""
    names = driving(model)
    if not names:
        return None
    smooth = replace(case, recordings=tuple(_lifted(model, r, names) for r in case.recordings))
    e = base.hypothesis.experiment
    series = tuple(
        replace(s, inputs=complete_inputs(model, r.inputs, input_noise(model, smooth, r))[0])
        for s, r in zip(e.series, smooth.fit, strict=True)
    )
    return smooth if judge.fit(on(base.hypothesis, series), [base.theta]).bic < base.bic - ALARM else None


FINER = 4
"""Steps from sample to sample in which a cubic is followed."""
MATTERS = 0.05
"""Times the noise from which on it is looked at what that changes."""


def smoothly_moved(model: Model, case: Case, base: Fit, judge: Judge) -> Case | None:
    """The case without what straight ways between samples make of a motion that a memory follows, where
    `base` fits far better by it; else None."""
    e = base.hypothesis.experiment
    if not _following(model) or driving(model):
        return None
    more = [_rounder(case, e, base.theta, r)[list(s.rows)] for r, s in zip(case.fit, e.series, strict=True)]
    pairs = list(zip(e.series, more, strict=True))
    if all(np.sqrt(np.mean((x * s.whitener.weight) ** 2)) < MATTERS for s, x in pairs):
        return None
    series = tuple(replace(s, data=s.data + x) for s, x in pairs)
    if judge.fit(on(base.hypothesis, series), [base.theta]).bic > base.bic - ALARM:
        return None
    rounder = [_rounder(case, e, base.theta, r) for r in case.recordings]
    less_so = [less(model, r, -x) for r, x in zip(case.recordings, rounder, strict=True)]
    return replace(case, recordings=tuple(less_so))


def less(model: Model, r: Recording, part: Array) -> Recording:
    """A recording without a `part` of its outputs, (outputs, n)."""
    at = {n: k for k, n in enumerate(primary_outputs(model))}
    return replace(r, outputs={n: y - part[at[n]] if n in at else y for n, y in r.outputs.items()})


def _following(model: Model) -> set[str]:
    """Recorded motions of which the value before is taken."""
    recorded = {i.name for i in model.inputs if i.derived is None} - {model.axis}
    return set(values_before(model).values()) & recorded


def _rounder(case: Case, e: Experiment, theta: Array, r: Recording) -> Array:
    """(outputs, n) of the base by straight ways between the samples of a recording, less those by cubics."""
    model = e.model
    whole, _ = complete_inputs(model, r.inputs, input_noise(model, case, r))
    recorded = {n: whole[n] for n in r.inputs if n in whole}
    t = recorded[model.axis]
    fine = np.interp(np.arange(FINER * (len(t) - 1) + 1) / FINER, np.arange(len(t)), t)
    between = {n: fine if n == model.axis else CubicSpline(t, x)(fine) for n, x in recorded.items()}
    exact = dict.fromkeys(_following(model), 0.0)
    straight, smooth = (
        _outputs(e, theta, r, complete_inputs(model, inputs, exact)[0]) for inputs in (recorded, between)
    )
    return straight - smooth[:, ::FINER]


def outputs_of(case: Case, e: Experiment, theta: Array, r: Recording) -> Array:
    """(outputs, n) of a model on a recording of `case`, with what is fitted in the one of its name."""
    return _outputs(e, theta, r, complete_inputs(e.model, r.inputs, input_noise(e.model, case, r))[0])


def _outputs(e: Experiment, theta: Array, r: Recording, inputs: Mapping[str, Array]) -> Array:
    (f,) = build_many([(e.model, e.layout.wrt)], ("values",))
    k = next((k for k, s in enumerate(e.series) if s.name == r.name), 0)
    known = {**e.constants, **r.constants, **dict(zip(e.layout.wrt, e.local(theta, k), strict=True))}
    there = {p.name: known[p.name] for p in e.model.scalar_parameters if p.name in known}
    ready = f.prepare(**inputs, **there)
    return ready.values(ready.p[ready.function.free], "real")


def driving(model: Model) -> set[str]:
    """Recorded inputs that drive states along straight lines: those, but time and motions, of which the value
    before is taken, and not that alone: such an input is held."""
    others = {i.derived[1] for i in model.inputs if i.derived and i.derived[0] != "previous"}
    used = {x.name for s in model.statements for e in expressions(s) for x in e.free_symbols}
    return (_following(model) - others) & used if model.is_time_model else set()


def _lifted(model: Model, r: Recording, names: set[str]) -> Recording:
    steps = np.diff(r.inputs[model.axis])
    if r.n < 3 or np.ptp(steps) > EVEN * float(np.mean(steps)):
        return r
    return replace(r, inputs={n: _sharpened(x) if n in names else x for n, x in r.inputs.items()})


def _sharpened(x: Array) -> Array:
    bend = np.zeros(len(x))
    bend[1:-1] = np.diff(x, 2)
    return np.asarray(x - bend / 12)
