"""What a diagnosis stands on: the base fitted, noise levels known, outliers out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modelgen.diagnose.base import fit_base, soundest
from modelgen.diagnose.gate.channels import one_channel, port_at, shown
from modelgen.diagnose.gate.hum import hum
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.gate.oddities import mains, saturation
from modelgen.diagnose.hypotheses.hypothesis import make_hypotheses
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.starts import base_starts
from modelgen.diagnose.noise.floor import no_finer_than_rounded, parted, slanted
from modelgen.diagnose.noise.frame import framed
from modelgen.diagnose.noise.glitches import bursts, by_chance
from modelgen.diagnose.noise.noise import masked, outliers, outliers_of, tread
from modelgen.diagnose.noise.staircase import rounded
from modelgen.diagnose.search.search import white_judge
from modelgen.fit.experiment import Experiment, experiment
from modelgen.fit.motion import MotionError, allowing, motion_error
from modelgen.fit.scatter import local_scatter, rounding
from modelgen.fit.series import Array, Series, make_series, sizes_of
from modelgen.language import Model
from modelgen.recordings import Case


@dataclass(frozen=True, eq=False)
class Ground:
    """What a diagnosis stands on: the base fitted to cleaned series."""

    series: tuple[Series, ...]
    bare: tuple[Series, ...]
    """The same with their outliers."""
    base: Fit
    judge: Judge
    marks: tuple[Array, ...]
    oddity: Leftover | None = None
    others: tuple[Array, ...] = ()
    """θ of the base's other optima, not much worse."""


def prepare(model: Model, case: Case, seed: int, seen: Sequence[Array] = ()) -> Ground:
    """Fit the base, find out how the noise goes with what is measured, take out outliers, set noise levels
    that were not stated from neighbours' scatter, fit again.

    seen: outliers of each recording, (n,) bool, which the base would hide.
    """
    series = tuple(make_series(model, case, r) for r in case.fit)
    base = make_hypotheses(model, case, series, [()])
    if not base:
        experiment(model, case, series).problem()  # says in one line what is wrong
    judge = white_judge(series)
    fit, others = fit_base(base[0], judge, seed)
    f = [s.inputs[model.axis] for s in series]
    raw = [fit.hypothesis.experiment.raw(fit.theta, k) for k in range(len(series))]
    spread = parted(framed(series, fit), f, raw)
    if any(a is not b for a, b in zip(series, spread, strict=True)):
        series, base = spread, make_hypotheses(model, case, spread, [()])
        judge = white_judge(series)
        fit, others = fit_base(base[0], judge, seed)
    if model.is_time_model:
        e = fit.hypothesis.experiment
        errors = [motion_error(e, case, r, fit.theta, k) for k, r in enumerate(case.fit)]
        series = rounded(tuple(map(allowing, _levelled(series, fit, errors), errors)), fit)
    ex = replace(fit.hypothesis.experiment, series=series)
    white = [s.whitener.apply(ex.raw(fit.theta, k)) for k, s in enumerate(series)]
    marks = tuple(seen) or _marks(judge, fit, ex)
    oddity, marks = _oddity(model, series, white, marks)
    bare = series if model.is_time_model else no_finer_than_rounded(_levelled(_referred(series, fit), fit))
    series = masked(bare, marks)
    if not model.is_time_model:
        if any(m.any() for m in marks):  # which may have bent the base
            fit = _again(model, case, series, fit, seed)
        raw = [fit.hypothesis.experiment.raw(fit.theta, k) for k in range(len(series))]
        series = slanted(series, f, raw)
    fit = _again(model, case, series, fit, seed)
    return Ground(series, bare, fit, white_judge(series), marks, oddity, others)


def _again(model: Model, case: Case, series: tuple[Series, ...], before: Fit, seed: int) -> Fit:
    """The base fitted to `series`, from where it was before and from a few starts more."""
    (base,), judge = make_hypotheses(model, case, series, [()]), white_judge(series)
    starts = ([before.theta], base_starts(base, seed, 4))
    return soundest([judge.fit(base, some) for some in starts])


def _marks(judge: Judge, fit: Fit, e: Experiment) -> tuple[Array, ...]:
    """(n,) bool of each recording: samples that stand alone, and bursts of them in sweeps."""
    alone = [outliers_of(e, fit.theta, k) for k in range(len(e.series))]
    if e.model.is_time_model:
        return tuple(alone)
    together = bursts(judge, fit)
    if any(x.any() for x in together):  # what they have bent is no outlier
        rest = masked(e.series, together)
        fit = replace(judge, whiteners=tuple(s.whitener for s in rest)).fit(fit.hypothesis, [fit.theta])
        alone = [outliers_of(e, fit.theta, k) for k in range(len(e.series))]
    marks = [a | b for a, b in zip(alone, together, strict=True)]
    return tuple(by_chance([s.inputs[e.model.axis] for s in e.series], marks))


LISTED = 60
"""Rows of a table of real values from which it is a sweep, in which lines are told from what is between."""


def _oddity(
    model: Model, series: Sequence[Series], white: Sequence[Array], marks: tuple[Array, ...]
) -> tuple[Leftover | None, tuple[Array, ...]]:
    """What the outliers have in common, if anything, and all samples that it spoils."""
    if model.is_time_model:  # the ends of a record are where the motion always comes
        found, more = _saturated(model, series, white)
        return found, tuple(a | b for a, b in zip(marks, more, strict=True))
    if any(s.measure == "real" and s.n < LISTED for s in series):
        return None, marks
    ports = {p.name for p in model.ports}
    port = "electrical" if "electrical" in ports else min(ports, default="model")
    f = [s.inputs[model.axis] for s in series]
    found, more = mains(f, white, port)
    if found is None:
        found, more = hum(f, white, port)
    return found, tuple(a | b for a, b in zip(marks, more, strict=True))


def _saturated(
    model: Model, series: Sequence[Series], white: Sequence[Array]
) -> tuple[Leftover | None, list[Array]]:
    """The clearest plateau of an output, and the samples on plateaus of any."""
    found: list[Leftover] = []
    on = [np.zeros(s.n, dtype=bool) for s in series]
    outputs = [shown(model, s) for s in series]
    for output in dict.fromkeys(n for names in outputs for n in names):
        there = [(k, names.index(output)) for k, names in enumerate(outputs) if output in names]
        parts = [one_channel(model, series[k], c) for k, c in there]
        errors = [white[k][c : c + 1] for k, c in there]
        stand_out = [outliers(e, least=tread(s)) for s, e in zip(parts, errors, strict=True)]
        left, more = saturation(parts, errors, stand_out)
        if left is not None:
            found.append(replace(left, port=port_at(model, output, "force", "sensor") or left.port))
        for (k, _), spoilt in zip(there, more, strict=True):
            on[k] |= spoilt
    return max(found, key=lambda x: x.gain, default=None), on


NEAR = 0.1
"""Relative distance from the recording at which the base says better what noise is relative to."""
WITHIN = 4.0
"""And the same in standard deviations, where some of the noise is absolute: a frame that holds the noise
itself would be alike to it."""


def _referred(series: Sequence[Series], fit: Fit) -> tuple[Series, ...]:
    """Impedances' noise relative to the base where that is near: neighbours share a coloured noise."""
    found = []
    for k, s in enumerate(series):
        if s.measure not in ("complex", "modulus"):
            found.append(s)
            continue
        e = fit.hypothesis.experiment.raw(fit.theta, k)
        base = s.data + e
        base = base[0] + 1j * base[1] if s.measure == "complex" else base[0]
        noise = WITHIN * sizes_of(s.spread, s.size)
        floors = bool(s.spread[0] or s.spread[2])
        near = np.abs(base - s.reference) < np.maximum(NEAR * s.size, noise if floors else 0.0)
        found.append(s.referred(np.where(near, base, s.reference)))
    return tuple(found)


def _levelled(
    series: Sequence[Series], fit: Fit, errors: Sequence[MotionError | None] = ()
) -> tuple[Series, ...]:
    """Where noise is not stated, its level is the scatter of the base's residual between neighbours, where
    `errors` of a motion make little of it, and of real values no less than the rounding of what was
    recorded."""
    levelled = []
    for k, (s, e) in enumerate(zip(series, fit.white, strict=True)):
        if s.stated or e.shape[1] < 8:
            levelled.append(s)
            continue
        error = errors[k] if errors else None
        more = [None] * len(e) if error is None else list(s.whitener.weight * np.sqrt(error.variance))
        scatter = float(np.median([local_scatter(x, beside=m) for x, m in zip(e, more, strict=True)]))
        if s.measure == "real":
            own = [rounding(y) * float(np.median(w)) for y, w in zip(s.data, s.whitener.weight, strict=True)]
            scatter = max(scatter, float(np.median(own)))
        level = max(scatter, 1e-6)
        absolute, relative, inverse = s.spread
        spread = (absolute * level, relative * level, inverse * level)
        levelled.append(replace(s, whitener=s.whitener.scaled(level), spread=spread))
    return tuple(levelled)
