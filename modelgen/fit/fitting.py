"""Fit a model to a case: parameters with uncertainties, and how it does on recordings it never saw."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import InputError, one_of
from modelgen.fit.conditions import broken_in, values_at
from modelgen.fit.experiment import Experiment, experiment
from modelgen.fit.farm import Farm
from modelgen.fit.gauss_newton import GaussNewton
from modelgen.fit.given import check_given, check_held, check_seed, check_start, is_finite
from modelgen.fit.method import Method, Outcome, Progress, Reason, part
from modelgen.fit.motion import with_motion
from modelgen.fit.multistart import MultiStart
from modelgen.fit.own import fitted_alone
from modelgen.fit.pieces import in_pieces
from modelgen.fit.problem import Problem, Vector, wide
from modelgen.fit.recipe import Recipe
from modelgen.fit.remarks import Part, arrived, carried, misfit, of_holdout, warnings
from modelgen.fit.result import Estimate, FitResult, OutputFit, RecordingFit, estimates
from modelgen.fit.separating import confusions
from modelgen.fit.series import Array, Series, make_series, unfitted
from modelgen.fit.staged import fit_recipe
from modelgen.fit.steps import coarse, runs_away
from modelgen.fit.swarms import scattered, swarmed
from modelgen.fit.trace import make_trace
from modelgen.fit.uncertainty import assess
from modelgen.language import Model
from modelgen.recordings import Case, Recording

STARTS = 10  # of each of the two parts of the default search
ASTRAY = 3.0  # times the noise that a sweep's residual is, from which the optimum may be the wrong one
REACH = 30.0  # a parameter without a range is searched from its start divided to its start times this


def fit(
    model: Model,
    case: Case,
    method: Method | Recipe | None = None,
    seed: int = 0,
    progress: Progress | None = None,
    start: Mapping[str, float] | None = None,
    constrained: bool = False,
    executor: Executor | None = None,
) -> FitResult:
    """Fit the free parameters of `model` to the recordings of role "fit".

    method: an optimiser, a chain, or a recipe of stages; by default Gauss–Newton from the model's start and
    from a Latin hypercube of others. start: values to begin with, by name. constrained: keep the model's
    conditions, such as passivity; otherwise a note says which of them the result breaks. Where [noise] is not
    stated, its level is taken from how neighbouring samples scatter, and standard deviations follow from the
    residual. Hold-out recordings are predicted with all shared parameters fixed; only those with a value in
    each recording (offset, initial state) are refitted on them. Ctrl-C keeps the best point so far.
    executor: where the starts of a multi-start run (`fit.farm`), if not here.
    Raises InputError when an argument is of another kind, nothing is free, the data are fewer than the
    parameters, a start makes no sense, or an executor has no starts to run.
    """
    check_given(model, case, method)
    check_seed(seed)
    check_start(start)
    check_held(case)
    case = in_pieces(model, case)
    if executor is not None and not (method is None or isinstance(method, MultiStart)):
        raise InputError("an executor runs the starts of a multi-start, and this method is of one start")
    if isinstance(method, Recipe):
        if start:
            raise InputError(f"{method.name} begins by itself: no start can be given")
        return fit_recipe(model, case, method, seed, progress, constrained)
    began = time.perf_counter()
    series = [make_series(model, case, r) for r in case.fit]
    ex = experiment(model, case, series)
    problem = _started(ex, start, constrained)
    farm = Farm.of(executor, model, case, constrained) if executor is not None else None
    if isinstance(method, MultiStart):
        method = replace(method, farm=farm)
    if method is None:
        outcome, says = _thorough(problem, case, seed, progress, farm), "Gauss–Newton from several starts"
        if any(s.measure != "real" for s in series) and outcome.value > ASTRAY**2 * problem.n_data:
            outcome, says = _by_swarms(problem, seed, outcome), f"{says} and from where swarms end"
    else:
        outcome, says = _searched(method, problem, case, seed, progress), method.text
    if not np.isfinite(outcome.value):
        why, where = outcome.reason.value.removeprefix("failed: "), runs_away(ex, problem.start)
        raise InputError(f"the fit of '{model.id}' failed: {why}{where and f', {where}'}")
    moved = with_motion(ex, case, case.fit, outcome.theta)
    if moved is not ex:
        ex, problem, outcome = moved, *_again(moved, problem, outcome, constrained)
    return _result(ex, case, problem, outcome, says, began, constrained)


def _result(
    ex: Experiment,
    case: Case,
    problem: Problem,
    outcome: Outcome,
    method: str,
    began: float,
    constrained: bool,
) -> FitResult:
    """Uncertainties at an optimum, hold-out recordings predicted from it, and what a reader should know."""
    model, theta = ex.model, outcome.theta
    known = assess(problem, theta, estimate_noise=not all(s.stated for s in ex.series))
    parts = [(s, ex.raw(theta, k), w) for k, (s, w) in enumerate(_whitened(ex, theta))]
    predicted = [predict(ex, case, theta, r) for r in case.holdout]
    parts += [part for part, _ in predicted]
    refitted = tuple(e for _, own in predicted for e in own)
    found = estimates(problem, theta, known)
    over = {role: _rms([w for s, _, w in parts if s.role == role]) for role in ("fit", "holdout")}
    amiss = (
        *unfitted(model, case),
        *warnings(case, outcome, found, parts, over["fit"], problem.segments is not None),
        *broken_in(model, [(s.name, values_at(ex, theta, k)) for k, s in enumerate(ex.series)], constrained),
        *map(str, confusions(ex, theta, known)),
        *coarse(ex, theta),
        *carried(over),
        *_kinds(model),
    )
    size = misfit(parts, over["fit"], all(s.stated for s in ex.series), known.rank)
    return FitResult(
        model=model.id, parameters=found, correlation=known.correlation, rank=known.rank,
        undetermined=known.undetermined, rms=_by_unit(model, parts), rms_over_noise=over,
        seconds=time.perf_counter() - began, reason=outcome.reason.value, method=method,
        recordings=tuple(_recording(model, *p) for p in parts),
        notes=(*amiss, *size, *of_holdout(refitted), *arrived(outcome)), warnings=amiss, refitted=refitted,
        traces=tuple(make_trace(model, s, raw, raw, np.zeros(s.n, bool), s.whitener) for s, raw, _ in parts),
    )  # fmt: skip


def _again(ex: Experiment, before: Problem, outcome: Outcome, constrained: bool) -> tuple[Problem, Outcome]:
    """The problem of `ex`, whose noise is another than `before`, and its optimum near that of before."""
    problem = replace(ex.problem(constrained=constrained), start=before.start)
    last = GaussNewton().run(problem, outcome.theta)
    return problem, replace(outcome, theta=last.theta, value=last.value)


def predict(ex: Experiment, case: Case, theta: Vector, held: Recording) -> tuple[Part, tuple[Estimate, ...]]:
    """The recording `held` as a series, its raw and whitened residual (channels, n), by the shared θ; and
    what it has of its own.

    θ belongs to the layout of `ex`. Parameters with a value in each recording are fitted to it alone.
    Raises InputError when it is shorter than these are many.
    """
    series = make_series(ex.model, case, held)
    alone = experiment(ex.model, case, [series], ex.function)
    found = dict(
        zip(ex.layout.wrt, ex.local(theta, 0), strict=True)
    )  # own ones begin as in the first recording
    found |= dict(zip(ex.layout.names, theta, strict=True))
    full = np.array([found[n] for n in alone.layout.names], dtype=float)
    own = np.array([n in alone.layout.own for n in alone.layout.names], dtype=bool)
    there = [dict(zip(ex.layout.wrt, ex.local(theta, k), strict=True)) for k in range(len(ex.series))]
    mine = [n for n in alone.layout.names if n in alone.layout.own]
    level = float(np.mean(np.concatenate([w.ravel() for w in ex.whitened(theta)]) ** 2))
    full = fitted_alone(alone, own, full, [np.array([x[n] for n in mine]) for x in there], level)
    alone = with_motion(alone, case, [held], full)
    return (alone.series[0], alone.raw(full, 0), alone.whitened(full)[0]), _own(alone, own, full)


def _own(alone: Experiment, own: NDArray[np.bool_], theta: Vector) -> tuple[Estimate, ...]:
    """Estimates of those of θ that are a recording's `own`, as if what is shared were known exactly."""
    if not own.any():
        return ()
    s, problem = alone.series[0], alone.problem_of(own, theta)
    known = assess(problem, theta[own], estimate_noise=not s.stated)
    return tuple(replace(e, name=f"{e.name}[{s.name}]") for e in estimates(problem, theta[own], known))


def _started(ex: Experiment, start: Mapping[str, float] | None, constrained: bool) -> Problem:
    """The problem with the user's starts. Raises InputError for an unknown name or a value out of bounds."""
    layout, given = ex.layout, dict(start or {})
    for name, value in given.items():
        if not any(n == name or n.startswith(f"{name}[") for n in layout.names):
            raise InputError(f"start: '{name}' is not a free parameter{one_of(name, layout.names)}")
        if not is_finite(value):
            raise InputError(f"start: '{name}' is {value!r}, wanted a finite number")
    values = (given.get(n, given.get(n.partition("[")[0])) for n in layout.names)
    pairs = zip(layout.parameters, values, strict=True)
    begun = tuple(p if x is None else replace(p, default=float(x)) for p, x in pairs)
    return replace(ex, layout=replace(layout, parameters=begun)).problem(constrained=constrained)


def _thorough(
    problem: Problem, case: Case, seed: int, progress: Progress | None, farm: Farm | None
) -> Outcome:
    """Gauss–Newton from the start, from others near it, and from others in the whole box about the best end.

    That end tells the scale of what has no bounds, and the whole box holds basins that are far away.
    """
    many = MultiStart(starts=STARTS, farm=farm)
    first = _searched(many, _scaled(problem, problem.start), case, seed, part(progress, 0, 2))
    if first.reason is Reason.INTERRUPTED:
        return first
    about = first.theta if np.isfinite(first.value) else problem.start
    second = many.run(_scaled(problem, about), progress=part(progress, 1, 2), seed=seed)
    worth = second.value < first.value * (1 - 1e-9) or not np.isfinite(first.value)
    best = second if worth else first
    return replace(best, reason=second.reason) if second.reason is Reason.INTERRUPTED else best


def _by_swarms(problem: Problem, seed: int, known: Outcome) -> Outcome:
    """The best of what is known and of Gauss–Newton from where swarms end, which search further out."""
    if known.reason is Reason.INTERRUPTED:
        return known
    method = GaussNewton(beyond=True)
    ends = swarmed(problem, seed, lambda end: method.run(problem, end), lambda end: end.value, known.value)
    best = min(known, *ends, key=lambda end: end.value)
    if best.value <= ASTRAY**2 * problem.n_data:
        return best
    further = method.run(problem, scattered(problem, seed, np.asarray(best.theta)))
    return min(best, further, key=lambda end: end.value)


def _scaled(problem: Problem, start: Vector) -> Problem:
    """`problem` from `start`, with another value than 0 where that is all that tells how far to look."""
    unbounded = ~(np.isfinite(problem.lower) & np.isfinite(problem.upper))
    other = np.where(problem.start != 0, problem.start, np.where(problem.upper > 0, 1.0, -1.0))
    begin = np.where(unbounded & (start == 0), other, start)
    return replace(problem, start=np.clip(begin, problem.lower, problem.upper))


def _searched(method: Method, problem: Problem, case: Case, seed: int, progress: Progress | None) -> Outcome:
    """Run `method`, which may draw starts from the bounds, on ranges that are worth a search.

    Without [bounds] a parameter has the limits of what is physical, a dozen decades apart, most of them
    without a resonance in sight. It is searched within a factor of REACH of its start, and freed at the end.
    """
    free = np.array([n.partition("[")[0] not in case.bounds for n in problem.names])
    far = wide(problem.lower, problem.upper)
    far |= (problem.lower == 0) & (problem.upper > REACH * problem.start)  # a sign tells no scale either
    free &= far & (problem.start > 0)
    low = np.where(free, np.maximum(problem.lower, problem.start / REACH), problem.lower)
    high = np.where(free, np.minimum(problem.upper, problem.start * REACH), problem.upper)
    near = replace(problem, lower=low, upper=high)
    outcome = method.run(near, progress=progress, seed=seed)
    if outcome.reason is Reason.INTERRUPTED or not np.any(free & near.at_bound(outcome.theta)):
        return outcome
    last = GaussNewton().run(problem, outcome.theta)
    return last if last.value < outcome.value else outcome


def _whitened(ex: Experiment, theta: Vector) -> Sequence[tuple[Series, Array]]:
    return list(zip(ex.series, ex.whitened(theta), strict=True))


def _kinds(model: Model) -> tuple[str, ...]:
    """Notes on misspelt kinds of ports; our own models have none, and the catalogue takes time to load."""
    if model.checked:
        return ()
    from modelgen.effects.kinds import unknown_kinds

    return unknown_kinds(model)


def _rms(arrays: Sequence[Array]) -> float:
    """Root of the mean square over all numbers in `arrays`; NaN for none."""
    return float(np.sqrt(np.mean(np.concatenate([a.ravel() for a in arrays]) ** 2))) if arrays else np.nan


def channels(model: Model, s: Series, raw: Array) -> dict[str, Array]:
    """Residuals by unit; of a complex quantity its modulus, so that its rms is that of |ΔZ|."""
    if s.measure in ("complex", "modulus", "phase"):
        return {"deg" if s.measure == "phase" else s.unit: np.linalg.norm(raw, axis=0)}
    by_unit: dict[str, list[Array]] = {}
    for name, e in zip(outputs_of(model, s), raw, strict=True):
        by_unit.setdefault(model[name].unit, []).append(e)
    return {unit: np.concatenate(rows) for unit, rows in by_unit.items()}


def outputs_of(model: Model, s: Series) -> list[str]:
    """Names of the outputs that a recording is compared in, of real ones one for each channel."""
    from modelgen.codegen.lower import primary_outputs

    names = primary_outputs(model)
    return [names[row] for row in s.rows] if s.measure == "real" else list(names[:1])


def _by_unit(model: Model, parts: Sequence[tuple[Series, Array, Array]]) -> dict[str, dict[str, float]]:
    """rms of the residual: unit → role → figure, the unit of the first channel first."""
    found: dict[str, dict[str, list[Array]]] = {}
    for s, raw, _ in parts:
        for unit, e in channels(model, s, raw).items():
            found.setdefault(unit, {}).setdefault(s.role, []).append(e)
    return {unit: {role: _rms(rows) for role, rows in roles.items()} for unit, roles in found.items()}


def _recording(model: Model, s: Series, raw: Array, white: Array) -> RecordingFit:
    (unit, rms), *others = ((unit, _rms([e])) for unit, e in channels(model, s, raw).items())
    more = tuple((x, u) for u, x in others)
    over, names = _rms([white]), outputs_of(model, s)
    each = tuple(
        OutputFit(n, _rms([e]), model[n].unit, _rms([w])) for n, e, w in zip(names, raw, white, strict=False)
    )
    if len(names) == 1:  # a complex one has two channels
        each = (OutputFit(names[0], rms, unit, over),)
    return RecordingFit(s.name, s.role, s.n, rms, unit, over, more, each)
