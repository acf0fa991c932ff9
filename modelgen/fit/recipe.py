"""Estimation in stages, as papers do it: each fits some parameters to one measure of the data, and holds the
rest at what the stages before it found."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from modelgen.errors import InputError
from modelgen.fit.conditions import broken, held_values
from modelgen.fit.experiment import Experiment, experiment
from modelgen.fit.method import Method, Outcome, Progress, Reason, Seed, part
from modelgen.fit.problem import Matrix, Problem, Vector
from modelgen.fit.result import Estimate, FitResult
from modelgen.fit.series import make_series
from modelgen.language import Model
from modelgen.language.quantities import ComplexParameter
from modelgen.recordings import Case, Noise, Recording

Measure = Literal["modulus", "phase", "complex"]


@dataclass(frozen=True)
class Stage:
    """One fit: the least Σ(measured − model)² of `measure` over all samples, without weights.

    estimates: "all" free parameters, or of the complex ones "real" or "imaginary" parts. constants: values
    that this stage assumes, before those of the case.
    """

    measure: Measure
    estimates: Literal["all", "real", "imaginary"]
    method: Method
    constants: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Recipe:
    """A named estimator: stages one after the other."""

    name: str
    stages: tuple[Stage, ...]
    text: str = ""


@dataclass(frozen=True, eq=False)
class StageResult:
    """What one stage found: θ of the parameters `names` (p,), the rms of its residual, work and time.

    objective: √(Σe²/I), in the unit of the measure.
    """

    stage: Stage
    names: tuple[str, ...]
    theta: Vector
    objective: float
    unit: str
    outcome: Outcome
    seconds: float


@dataclass(frozen=True, eq=False)
class Staged:
    """All stages' results, and every parameter's last value with its covariance (p, p), linearised.

    Errors of early stages are carried through the later ones; noise is as large as each stage's residual.
    """

    recipe: Recipe
    stages: tuple[StageResult, ...]
    values: Mapping[str, float]
    names: tuple[str, ...]
    covariance: Matrix

    def std(self, name: str) -> float:
        """Standard deviation of one parameter."""
        k = self.names.index(name)
        return float(np.sqrt(self.covariance[k, k]))


def run_recipe(
    recipe: Recipe,
    model: Model,
    case: Case,
    seed: Seed = 0,
    progress: Progress | None = None,
    uncertain: Mapping[str, float] | None = None,
    constrained: bool = False,
) -> Staged:
    """Estimate by `recipe`. uncertain: standard deviations of constants that are known by measurement.
    constrained: keep the model's conditions, such as passivity, in each stage.

    Raises InputError for a case that a recipe cannot deal with: parameters with a value in each recording, or
    a recording that holds only another measure.
    """
    if case.per_recording:
        raise InputError(f"{recipe.name}: per_recording is not for this method; '{case.per_recording[0]}' is")
    free = _free(model, case)
    spread = dict(uncertain or {})
    known = _Known(free, np.zeros((len(free), 0)), dict.fromkeys(free, np.nan))
    known = known.with_sources(spread)
    done: list[StageResult] = []
    for k, stage in enumerate(recipe.stages):
        result, known = _run(
            stage, model, case, known, seed, part(progress, k, len(recipe.stages)), constrained
        )
        done.append(result)
        if result.outcome.reason is Reason.INTERRUPTED:
            break
    at = [known.names.index(n) for n in free if np.isfinite(known.values[n])]
    names = tuple(known.names[i] for i in at)
    return Staged(
        recipe,
        tuple(done),
        {n: known.values[n] for n in names},
        names,
        (known.error @ known.error.T)[np.ix_(at, at)],
    )


@dataclass(frozen=True, eq=False)
class _Known:
    """Values so far, and the error of each, linear in independent unit sources: (names, sources).

    The measured constants are the first sources; each stage adds those of its own data, rotated into as many
    as it has parameters.
    """

    names: tuple[str, ...]
    error: Matrix
    values: Mapping[str, float]

    def with_sources(self, spread: Mapping[str, float]) -> _Known:
        names = (*self.names, *spread)
        error = np.zeros((len(names), len(spread)))
        error[len(self.names) :] = np.diag(list(spread.values()))
        return replace(self, names=names, error=error)


def _free(model: Model, case: Case) -> tuple[str, ...]:
    series = [make_series(model, case, r) for r in case.fit]
    return experiment(model, case, series).layout.names


def _run(
    stage: Stage,
    model: Model,
    case: Case,
    known: _Known,
    seed: Seed,
    progress: Progress | None,
    constrained: bool,
) -> tuple[StageResult, _Known]:
    """One stage, and what is known after it."""
    began = time.perf_counter()
    ex, whole, problem = _prepared(stage, model, case, known, constrained)
    sought = problem.names
    outcome = stage.method.run(problem, progress=progress, seed=seed)
    whole[[ex.layout.names.index(n) for n in sought]] = outcome.theta
    unit = "deg" if stage.measure == "phase" else ex.series[0].unit
    samples = sum(s.n for s in ex.series)
    result = StageResult(
        stage, tuple(sought), outcome.theta, float(np.sqrt(outcome.value / samples)), unit, outcome,
        time.perf_counter() - began,
    )  # fmt: skip
    return result, _after(known, ex, whole, sought, stage.constants)


def stage_problem(
    stage: Stage, model: Model, case: Case, values: Mapping[str, float] | None = None
) -> Problem:
    """The least-squares problem of one stage, r its plain residual; `values`: what was found before it."""
    free = _free(model, case)
    known = _Known(free, np.zeros((len(free), 0)), dict.fromkeys(free, np.nan) | dict(values or {}))
    return _prepared(stage, model, case, known, False)[2]


def _prepared(
    stage: Stage, model: Model, case: Case, known: _Known, constrained: bool
) -> tuple[Experiment, Vector, Problem]:
    """The experiment with all that is sought in any stage, its θ so far, and this stage's own problem."""
    ex = _experiment(model, _seen(case, stage), known)
    values = held_values(ex, 0) | {n: v for n, v in known.values.items() if np.isfinite(v)}
    free = ex.problem(constrained=constrained)
    start = dict(zip(free.names, free.start, strict=True))
    whole = np.array([values.get(n, start[n]) for n in free.names])
    chosen = _sought(model, stage.estimates) - set(stage.constants)
    sought = [n for n in free.names if n in chosen and n in known.values]
    return ex, whole, _holding(free, sought, whole)


def _seen(case: Case, stage: Stage) -> Case:
    """The case as the stage sees it: one measure, all samples of the same weight, its own constants."""
    outputs = {name for r in case.recordings for name in r.outputs}
    return replace(
        case,
        recordings=tuple(_measured(r, stage) for r in case.fit),
        constants=dict(case.constants) | dict(stage.constants),
        noise=Noise(sigma=dict.fromkeys(outputs, 1.0)),
    )


def _measured(r: Recording, stage: Stage) -> Recording:
    outputs, kinds = dict(r.outputs), dict(r.kinds)
    for name, y in r.outputs.items():
        if kinds[name] == stage.measure:
            continue
        if kinds[name] != "complex":
            raise InputError(
                f"recording '{r.name}' holds the {kinds[name]} of {name} alone, its {stage.measure} is wanted"
            )
        outputs[name] = np.abs(y) if stage.measure == "modulus" else np.degrees(np.angle(y))
        kinds[name] = stage.measure
    constants = dict(r.constants) | {n: v for n, v in stage.constants.items() if n in r.constants}
    return replace(r, outputs=outputs, kinds=kinds, constants=constants)


def _experiment(model: Model, case: Case, known: _Known) -> Experiment:
    """With derivatives by all that is sought in any stage, and by constants with an uncertainty."""
    from modelgen.codegen import build

    series = [make_series(model, case, r) for r in case.fit]
    return experiment(model, case, series, build(model, known.names))


def _sought(model: Model, which: str) -> set[str]:
    if which == "all":
        return {p.name for p in model.scalar_parameters}
    pairs = [p for p in model.parameters if isinstance(p, ComplexParameter)]
    return {(p.re if which == "real" else p.im).name for p in pairs}


def _holding(problem: Problem, sought: Sequence[str], whole: Vector) -> Problem:
    """The problem of the parameters `sought` alone; the others keep their values in `whole` (p,)."""
    for name, value in zip(problem.names, whole, strict=True):
        if name not in sought:
            problem = problem.fixed(problem.names.index(name), float(value))
    return problem


def _after(
    known: _Known, ex: Experiment, whole: Vector, sought: Sequence[str], assumed: Mapping[str, float]
) -> _Known:
    """Carry errors through a stage: δθ = −J⁺ (e + J_held δheld), e of the size of the residual."""
    r, J = ex.linearised(whole)
    place = [ex.layout.names.index(n) for n in sought]
    inverse = np.linalg.pinv(J[:, place])
    level = float(np.sqrt(r @ r / max(r.size - len(place), 1)))
    U, s, _ = np.linalg.svd(inverse, full_matrices=False)
    own = level * U * s  # as many unit sources as parameters have the covariance of J⁺e
    error = np.hstack([known.error, np.zeros((len(known.names), len(place)))])
    others = [k for k, n in enumerate(ex.layout.names) if n not in sought and n not in assumed]
    rows = [known.names.index(ex.layout.names[k]) for k in others]
    mine = [known.names.index(n) for n in sought]
    moved = -inverse @ J[:, others] @ error[rows]
    moved[:, -len(place) :] += own
    error[mine] = moved
    values = dict(known.values) | dict(zip(sought, whole[place].tolist(), strict=True))
    return _Known(known.names, error, values)


def fit_recipe(
    model: Model,
    case: Case,
    recipe: Recipe,
    seed: Seed = 0,
    progress: Progress | None = None,
    constrained: bool = False,
) -> FitResult:
    """`run_recipe` as the result of a fit: rms by measure, and what each stage reached among its notes."""
    began = time.perf_counter()
    found = run_recipe(recipe, model, case, seed, progress, constrained=constrained)
    stages = [
        f"stage {k}: {s.objective:.4g} {s.unit} rms of the {s.stage.measure} by {', '.join(s.names)}"
        for k, s in enumerate(found.stages, 1)
    ]
    last = found.stages[-1]
    values = {p.name: p.default for p in model.scalar_parameters} | dict(case.constants) | dict(found.values)
    amiss = broken(model, {n: v for n, v in values.items() if v is not None}, constrained)
    with np.errstate(invalid="ignore", divide="ignore"):
        std = np.sqrt(found.covariance.diagonal())
        correlation = found.covariance / np.outer(std, std)
    return FitResult(
        model=model.id,
        parameters=tuple(
            Estimate(n, found.values[n], float(s), model.parameter(n).unit)
            for n, s in zip(found.names, std, strict=True)
        ),
        correlation=correlation,
        rank=len(found.names),
        undetermined=(),
        rms={s.unit: {"fit": s.objective} for s in found.stages},
        rms_over_noise={},
        seconds=time.perf_counter() - began,
        reason=last.outcome.reason.value,
        method=recipe.text or recipe.name,
        notes=(*stages, *amiss),
        warnings=amiss,
    )
