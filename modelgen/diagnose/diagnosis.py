"""A diagnosis: noise, base fit, search, ranking, gate, verdict. Each claim with its evidence."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from modelgen.diagnose.base import fit_base, soundest
from modelgen.diagnose.conclude import conclude
from modelgen.diagnose.gate.exact import exact
from modelgen.diagnose.gate.hum import hum
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.gate.mirrored import mirrored, opposed
from modelgen.diagnose.gate.narrow import glitch
from modelgen.diagnose.gate.oddities import mains, saturation
from modelgen.diagnose.hypotheses.hypothesis import additions, make_hypotheses
from modelgen.diagnose.hypotheses.refit import Fit, Judge, base_starts, plain_white
from modelgen.diagnose.hypotheses.scales import motion_scales, port_scale, record_scales, values_at
from modelgen.diagnose.hypotheses.setting import Outcome, Progress, Setting
from modelgen.diagnose.noise.between import smoothly_driven
from modelgen.diagnose.noise.floor import no_finer_than_rounded, parted, slanted
from modelgen.diagnose.noise.frame import framed
from modelgen.diagnose.noise.glitches import bursts, by_chance, laid_open, rather
from modelgen.diagnose.noise.history import unrested
from modelgen.diagnose.noise.noise import marked, masked, outliers_of
from modelgen.diagnose.noise.resolved import unresolved
from modelgen.diagnose.noise.staircase import rounded
from modelgen.diagnose.noise.thin import thin
from modelgen.diagnose.own_effects import check_effects, unused
from modelgen.diagnose.search.search import search, white_judge
from modelgen.diagnose.verdict import Verdict
from modelgen.diagnose.whole_ports import whole
from modelgen.effects import Effect
from modelgen.effects.kinds import unknown_kinds
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


def diagnose(
    case: Case,
    model: Model,
    *,
    effects: Sequence[Effect] | None = None,
    progress: Progress = None,
    out: Path | None = None,
    seed: int = 0,
) -> Verdict:
    """Say whether `model` explains the recordings of `case`, and if not, which physics was left out.

    effects: further effects beside the catalogue. out: folder for the extended model and its C (none: not
    written). Holdout recordings are looked at once, at the end. Raises InputError when the case can't be
    fitted.
    """
    from modelgen.effects import CATALOGUE

    catalogue = (*CATALOGUE, *(effects or ()))
    check_effects(effects or (), model, {k for e in CATALOGUE for k in e.kinds})
    # fits share the cores already; threads of small matrices wait for each other, ten times as long on a busy
    # machine
    with threadpool_limits(1, "blas"):
        return _diagnosed(case, whole(model), catalogue, effects or (), progress, out, seed)


def _diagnosed(
    case: Case,
    model: Model,
    catalogue: Sequence[Effect],
    own: Sequence[Effect],
    progress: Progress,
    out: Path | None,
    seed: int,
) -> Verdict:
    begun = time.perf_counter()
    if progress:
        progress(0.02, "reading")
    case, notes = thin(model, case)
    case, ground, smooth = _prepared(model, case, seed)
    seen = (*unresolved(model, ground.series), *mirrored(model, case, ground.base, seed))
    notes = (*notes, *unknown_kinds(model, own), *seen, *smooth)
    if progress:
        progress(0.15, "base fitted")
    ground, setting, outcome = _searched(model, case, ground, catalogue, seed, progress)
    if progress:
        progress(0.9, "deciding")
    turned = opposed(model, case, ground.base, outcome.best, seed)
    idle = unused(own, model, setting.additions)
    notes = (*notes, *idle, *marked(ground.series, ground.marks), *turned)
    return conclude(setting, notes, ground.marks, ground.oddity, outcome, out, begun)


def _prepared(model: Model, case: Case, seed: int) -> tuple[Case, Ground, tuple[str, ...]]:
    """The case with inputs that ran as the base says they did between their samples, and with a past of its
    memory; its ground, and a note where they ran smoothly or the sample had not rested."""
    ground, notes = prepare(model, case, seed), []
    for ask, note in ((smoothly_driven, SMOOTH), (unrested, UNRESTED)):
        other = ask(model, case, ground.base, ground.judge)
        if other is not None:
            case, ground = other, prepare(model, other, seed)
            notes.append(note)
    return case, ground, tuple(notes)


SMOOTH = "inputs ran smoothly between their samples: with straight lines the base fits far worse"
UNRESTED = (
    "the sample had not rested before the records: what its memory begins with is fitted, in each its own"
)


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
    spread = parted(framed(series, fit), f, plain_white(fit))
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
        raw = [fit.hypothesis.experiment.raw(fit.theta, k) for k in range(len(series))]
        white = [s.whitener.apply(e) for s, e in zip(series, raw, strict=True)]
        series = slanted(series, f, white)
    base = make_hypotheses(model, case, series, [()])
    judge = white_judge(series)
    starts = ([fit.theta], base_starts(base[0], seed, 4))
    fit = soundest([judge.fit(base[0], some) for some in starts])
    return Ground(series, bare, fit, judge, marks, oddity, others)


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


def _oddity(
    model: Model, series: Sequence[Series], white: Sequence[Array], marks: tuple[Array, ...]
) -> tuple[Leftover | None, tuple[Array, ...]]:
    """What the outliers have in common, if anything, and all samples that it spoils."""
    if model.is_time_model:
        found, more = saturation(series, white, marks)
        return found, tuple(more)
    if any(s.measure == "real" for s in series):
        return None, marks
    ports = {p.name for p in model.ports}
    port = "electrical" if "electrical" in ports else min(ports, default="model")
    f = [s.inputs[model.axis] for s in series]
    found, more = mains(f, white, port)
    if found is None:
        found, more = hum(f, white, port)
    return found, tuple(a | b for a, b in zip(marks, more, strict=True))


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


def set_up(model: Model, case: Case, ground: Ground, catalogue: Sequence[Effect]) -> Setting:
    """The additions that this model and these recordings allow."""
    e = ground.base.hypothesis.experiment
    values = [values_at(e, ground.base.theta, k) for k in range(len(ground.series))]
    sizes = {p.equation: port_scale(p, values) for p in model.ports}
    along = [s.inputs[model.axis] for s in ground.series]
    motions = {p.equation: motion_scales(model, p, values, along) for p in model.ports}
    scales, repeats = record_scales(model, ground.series), _repeats(model, ground.series)
    found = additions(model, catalogue, scales, sizes, motions, repeats)
    return Setting(model, case, ground.series, tuple(found), ground.others)


def _repeats(model: Model, series: Sequence[Series]) -> tuple[str, ...]:
    """Names of records over time, in each of which zero point and temperature drift in their own way, and of
    sweeps that repeat each other, nothing being known to differ; none of sweeps where something is."""
    alike = all(dict(s.constants) == dict(series[0].constants) for s in series)
    return tuple(s.name for s in series) if model.is_time_model or alike else ()


def _searched(
    model: Model,
    case: Case,
    ground: Ground,
    catalogue: Sequence[Effect],
    seed: int,
    progress: Progress = None,
) -> tuple[Ground, Setting, Outcome]:
    """The search; and once more, where what it found lays outliers open that the base's misfit had hidden."""
    setting = set_up(model, case, ground, catalogue)
    if exact(ground.base):
        return ground, setting, Outcome(ground.judge, ground.base, ground.base, (), ())
    outcome = search(setting, ground.base, ground.judge, progress)
    few = not model.is_time_model  # of the samples over time a few more or less say little
    seen = laid_open(outcome.base, outcome.best, ground.bare, ground.marks) if few else None
    alone = glitch(outcome) if few and seen is None else None
    if alone is not None:
        seen = [a | b for a, b in zip(alone, ground.marks, strict=True)]
    if seen is None:
        return ground, setting, outcome
    again = prepare(model, case, seed, seen)
    anew = set_up(model, case, again, catalogue)
    found = search(anew, again.base, again.judge, progress)
    if rather(outcome.judge, outcome.best, found.best):
        return ground, setting, outcome
    return again, anew, found


def outcome_of(
    model: Model, case: Case, catalogue: Sequence[Effect], seed: int = 0
) -> tuple[Setting, Outcome]:
    """Setting and outcome without a verdict, for studies of the search itself."""
    model = whole(model)
    case, _ = thin(model, case)
    case, ground, _ = _prepared(model, case, seed)
    _, setting, outcome = _searched(model, case, ground, catalogue, seed)
    return setting, outcome
