"""A planned recording, as a hypothesis has it: what it would be like before and when it is made."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from modelgen.codegen.lower import primary_outputs
from modelgen.diagnose.experiment.menu import Plan
from modelgen.diagnose.experiment.rivals import Rivals
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import Setting
from modelgen.diagnose.noise.smooth_error import quietness, with_smooth
from modelgen.fit.experiment import Experiment, Layout
from modelgen.fit.motion import errors_in_motion
from modelgen.fit.series import Array, Series, input_noise, make_series
from modelgen.fit.whitener import Whitener
from modelgen.recordings import Case, Noise, Recording
from modelgen.recordings.noise import noise_std


def planned(rivals: Rivals, plan: Plan) -> Series:
    """The plan's recording before anything is known of its outputs."""
    values = np.ones((len(rivals.setting.series[rivals.k].rows), len(plan.inputs[rivals.setting.model.axis])))
    return make_series(rivals.setting.model, *_case(rivals, plan, plan.inputs, values))


def _case(rivals: Rivals, plan: Plan, inputs: Mapping[str, Array], out: Array) -> tuple[Case, Recording]:
    """The plan's recording with these outputs, and a case of its noise."""
    setting, k = rivals.setting, rivals.k
    old, record = setting.series[k], setting.case.fit[k]
    names = [o for o in primary_outputs(setting.model) if o in record.outputs]
    values = [out[0] + 1j * out[1]] if old.measure == "complex" else list(out)
    kinds, outputs = {o: record.kinds[o] for o in names}, dict(zip(names, values, strict=False))
    case = replace(setting.case, noise=_noise(setting, rivals.judge, k, plan.quiet, names))
    constants = {**old.constants, **plan.constants}
    return case, Recording("planned", None, "fit", inputs, outputs, kinds, constants)


INEXACT = 0.01
"""What a law leaves of its effect's part of a recording, since it is never quite the right one: less than
that tells nothing, however often a recording is averaged."""


@dataclass(frozen=True, eq=False)
class Made:
    """A planned recording as a hypothesis gives it: `plain` with the noise only in its weights; inexact: (n,)
    what its laws may leave."""

    plain: Series
    inexact: Array

    def whitener(self, times: int = 1) -> Whitener:
        """Of the mean of so many recordings; the error of laws stays what it is."""
        w = self.plain.whitener
        weight = w.weight * times**0.5
        less = 1 / np.hypot(1.0, np.mean(np.abs(np.atleast_2d(weight)), axis=0) * self.inexact)
        root = None if w.root is None else replace(w.root, size=w.root.size * times)
        return replace(w, weight=weight * less, root=root)

    @property
    def series(self) -> Series:
        return replace(self.plain, whitener=self.whitener())


def simulated(rivals: Rivals, truth: Fit, plan: Plan, empty: Series | None = None) -> Made | None:
    """The plan's recording as a hypothesis gives it; None if not finite.

    empty: as `planned`.
    """
    setting, judge, k = rivals.setting, rivals.judge, rivals.k
    model, empty = setting.model, empty or planned(rivals, plan)
    with np.errstate(all="ignore"):
        e, theta = joined(truth, k, empty)
        last = alone(e)
        out = last.raw(theta, 0) + empty.data
        if not np.all(np.isfinite(out)):
            return None
        case, made = _case(rivals, plan, empty.inputs, out)
        new = make_series(model, case, made)
        if model.is_time_model:
            noisy = replace(case, noise=case.noise.but(_motion_noise(setting, k, plan)))
            new = errors_in_motion(replace(last, series=(new,)), noisy, made, theta, 0)
    whitener = replace(new.whitener, ar=judge.whiteners[k].ar)
    if judge.smooth is not None and whitener.root is None:
        over = quietness(setting.series, judge.whiteners)[k] / plan.quiet
        (whitener,) = with_smooth((whitener,), [np.log(new.inputs[model.axis])], judge.smooth, [over])
    return Made(replace(new, whitener=whitener), _inexact(last, truth, theta, out, empty))


def _inexact(e: Experiment, truth: Fit, theta: Array, out: Array, empty: Series) -> Array:
    """(n,) share of the part of the output that a hypothesis' effects have; 0 where that is not finite."""
    nulls = {n: null for a in truth.hypothesis.added for n, null in a.nulls.items()}
    base = np.array([nulls.get(n, x) for n, x in zip(e.layout.names, theta, strict=True)])
    without = e.raw(base, 0) + empty.data
    with np.errstate(over="ignore", invalid="ignore"):
        mean = np.mean((out - without) ** 2, axis=0)
    change = np.sqrt(mean * (len(out) if empty.measure == "complex" else 1))
    return np.where(np.isfinite(change), INEXACT * change, 0.0)


def _noise(setting: Setting, judge: Judge, k: int, quiet: float, names: Sequence[str]) -> Noise:
    """The noise of recording k as it is judged, `quiet` times as large; planned inputs are known exactly."""
    s, stated = setting.series[k], setting.case.noise_of(setting.case.fit[k])
    inputs = {i.name: 0.0 for i in setting.model.inputs if i.derived is None}
    weight = np.atleast_2d(np.abs(judge.whiteners[k].weight))
    used = np.all(weight > 0, axis=0)
    sigma = quiet / weight[:, used]
    if s.measure in ("complex", "modulus"):
        level, relative = sigma[0], sigma[0] / s.size[used]
        if np.ptp(np.log(relative)) <= np.ptp(np.log(level)):
            return Noise(inputs, {names[0]: float(np.median(relative))}, stated.calibration)
        return Noise(inputs | {names[0]: float(np.median(level))}, {}, stated.calibration)
    return Noise(
        inputs | {n: float(np.median(x)) for n, x in zip(names, sigma, strict=True)}, {}, stated.calibration
    )


def _motion_noise(setting: Setting, k: int, plan: Plan) -> Noise:
    """What errors recording k has in its displacement, stated or its own, averaged as planned."""
    record, model = setting.case.fit[k], setting.model
    told = input_noise(model, setting.case, record)
    moved = {
        i.derived[1] for i in model.inputs if i.derived and i.derived[0] == "rate"
    } & record.inputs.keys()
    t = record.inputs[model.axis]
    found = {n: noise_std(t, record.inputs[n]) if told[n] is None else told[n] for n in moved}
    return Noise({n: x / plan.averaged**0.5 for n, x in found.items()})


def joined(fit: Fit, k: int, new: Series) -> tuple[Experiment, Array]:
    """The fit's experiment with `new` beside its recordings, and θ: the fit's, then what `new` has of its
    own.

    Constants of `new` hold parameters there that are free elsewhere; its own start at their values in
    recording k.
    """
    e = fit.hypothesis.experiment
    old = e.layout
    place, held = old.place[k].copy(), old.held[k].copy()
    names, parameters, theta = list(old.names), list(old.parameters), list(fit.theta)
    for i, n in enumerate(old.wrt):
        if n in new.constants:
            place[i], held[i] = -1, new.constants[n]
        elif n in old.own and place[i] >= 0:
            parameters.append(old.parameters[place[i]])
            theta.append(fit.theta[place[i]])
            place[i] = len(names)
            names.append(f"{n}[{new.name}]")
    rows = np.vstack([old.place, place]), np.vstack([old.held, held])
    layout = Layout(old.wrt, tuple(names), tuple(parameters), *rows, old.own)
    return replace(e, layout=layout, series=(*e.series, new)), np.array(theta)


def alone(e: Experiment) -> Experiment:
    """The last recording of an experiment alone."""
    layout = replace(e.layout, place=e.layout.place[-1:], held=e.layout.held[-1:])
    return replace(e, layout=layout, series=e.series[-1:])
