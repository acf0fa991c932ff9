"""Estimation in stages, as papers do it: each fits some parameters to one measure of the data, and holds the
rest at what the stages before it found."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import InputError
from modelgen.fit.carried import Known, after
from modelgen.fit.conditions import held_values
from modelgen.fit.experiment import Experiment, Layout, experiment
from modelgen.fit.method import Method, Outcome, Progress, Reason, Seed, part
from modelgen.fit.problem import Matrix, Problem, Vector
from modelgen.fit.result import OutputFit, RecordingFit
from modelgen.fit.series import make_series
from modelgen.fit.uncertainty import Places, Product, product
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

    objective: √(Σe²/I), in the unit of the measure. recordings: the same for each, also for those held out.
    problem: what was solved.
    """

    stage: Stage
    problem: Problem
    names: tuple[str, ...]
    theta: Vector
    objective: float
    unit: str
    outcome: Outcome
    recordings: tuple[RecordingFit, ...]
    seconds: float

    @property
    def held_out(self) -> float:
        """The rms over all that is held out, as `objective`; NaN for nothing."""
        held = [r for r in self.recordings if r.role == "holdout"]
        points = sum(r.points for r in held)
        return float(np.sqrt(sum(r.points * r.rms**2 for r in held) / points)) if held else np.nan


@dataclass(frozen=True, eq=False)
class Staged:
    """All stages' results, and every parameter's last value with its covariance (p, p), linearised.

    Errors of early stages are carried through the later ones; noise is as large as each stage's residual.
    determined (p,), rank and `undetermined` (sentences): as in `Uncertainty`.
    """

    recipe: Recipe
    stages: tuple[StageResult, ...]
    values: Mapping[str, float]
    names: tuple[str, ...]
    covariance: Matrix
    determined: NDArray[np.bool_]
    rank: int
    undetermined: tuple[str, ...]

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

    Hold-out recordings are predicted in each stage's measure. Raises InputError for a case that a recipe
    cannot deal with: parameters with a value in each recording, or a recording that holds only another
    measure.
    """
    if case.per_recording:
        raise InputError(f"{recipe.name}: per_recording is not for this method; '{case.per_recording[0]}' is")
    free = _free(model, case)
    known = Known.nothing(free.names).with_sources(uncertain or {})
    done: list[StageResult] = []
    for k, stage in enumerate(recipe.stages):
        result, known = _run(
            stage, model, case, known, seed, part(progress, k, len(recipe.stages)), constrained
        )
        done.append(result)
        if result.outcome.reason is Reason.INTERRUPTED:
            break
    sought = [
        (n, p) for n, p in zip(free.names, free.parameters, strict=True) if np.isfinite(known.values[n])
    ]
    names = tuple(n for n, _ in sought)
    span = np.array([p.bounds[1] - p.bounds[0] for _, p in sought])
    judged = known.judged(names, span, _powers(done[-1], names))
    return Staged(
        recipe, tuple(done), {n: known.values[n] for n in names}, names,
        judged.covariance, judged.determined, judged.rank, judged.undetermined,
    )  # fmt: skip


def _free(model: Model, case: Case) -> Layout:
    series = [make_series(model, case, r) for r in case.fit]
    return experiment(model, case, series).layout


def _run(
    stage: Stage,
    model: Model,
    case: Case,
    known: Known,
    seed: Seed,
    progress: Progress | None,
    constrained: bool,
) -> tuple[StageResult, Known]:
    """One stage, and what is known after it."""
    began = time.perf_counter()
    seen = _seen(case, stage)
    ex, whole, problem = _prepared(stage, model, seen, known, constrained)
    sought = problem.names
    outcome = stage.method.run(problem, progress=progress, seed=seed)
    whole[[ex.layout.names.index(n) for n in sought]] = outcome.theta
    unit = "deg" if stage.measure == "phase" else ex.series[0].unit
    samples = sum(s.n for s in ex.series)
    result = StageResult(
        stage, problem, tuple(sought), outcome.theta, float(np.sqrt(outcome.value / samples)), unit, outcome,
        _met(ex, seen, whole, unit), time.perf_counter() - began,
    )  # fmt: skip
    return result, after(known, ex, whole, sought, stage.constants)


def stage_problem(
    stage: Stage, model: Model, case: Case, values: Mapping[str, float] | None = None
) -> Problem:
    """The least-squares problem of one stage, r its plain residual; `values`: what was found before it."""
    known = Known.nothing(_free(model, case).names)
    known = replace(known, values=dict(known.values) | dict(values or {}))
    return _prepared(stage, model, _seen(case, stage), known, False)[2]


def _prepared(
    stage: Stage, model: Model, seen: Case, known: Known, constrained: bool
) -> tuple[Experiment, Vector, Problem]:
    """The experiment with all that is sought in any stage, its θ so far, and this stage's own problem."""
    ex = _experiment(model, seen, known)
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
        recordings=tuple(_measured(r, stage) for r in case.recordings),
        constants=dict(case.constants) | dict(stage.constants),
        noise=Noise(sigma=dict.fromkeys(outputs, 1.0)),
    )


def _measured(r: Recording, stage: Stage) -> Recording:
    outputs, kinds = dict(r.outputs), dict(r.kinds)
    for name, y in r.outputs.items():
        if kinds[name] == stage.measure:
            continue
        if kinds[name] == "real":
            raise InputError(
                f"recording '{r.name}' holds {name}, which is real: this recipe is for models of an "
                "impedance, such as its paper's"
            )
        if kinds[name] != "complex":
            raise InputError(
                f"recording '{r.name}' holds the {kinds[name]} of {name} alone, its {stage.measure} is wanted"
            )
        outputs[name] = np.abs(y) if stage.measure == "modulus" else np.degrees(np.angle(y))
        kinds[name] = stage.measure
    constants = dict(r.constants) | {n: v for n, v in stage.constants.items() if n in r.constants}
    return replace(r, outputs=outputs, kinds=kinds, constants=constants)


def _experiment(model: Model, case: Case, known: Known) -> Experiment:
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


def _powers(last: StageResult, names: Sequence[str]) -> Product:
    """Combinations of parameters, by their places in `names`, as products where the last stage sought all."""

    def powers(index: Places, row: Vector) -> str:
        own = [names[i] for i in index]
        if not set(own) <= set(last.names):
            return ""
        _, J = last.problem.jacobian(last.theta)
        return product(last.problem, last.theta, J, np.array([last.names.index(n) for n in own]), row)

    return powers


def _met(ex: Experiment, seen: Case, whole: Vector, unit: str) -> tuple[RecordingFit, ...]:
    """How each recording is met at θ `whole`, also those held out, which no stage has fitted."""
    from modelgen.codegen.lower import primary_outputs

    values = dict(zip(ex.layout.names, whole, strict=True))
    found = [(s, ex.raw(whole, k)) for k, s in enumerate(ex.series)]
    for r in seen.holdout:
        alone = experiment(ex.model, seen, [make_series(ex.model, seen, r)], ex.function)
        found.append((alone.series[0], alone.raw(np.array([values[n] for n in alone.layout.names]), 0)))
    output, met = primary_outputs(ex.model)[0], []
    for s, e in found:
        rms = float(np.sqrt(np.sum(e**2) / s.n))
        each = (OutputFit(output, rms, unit, np.nan),)
        met.append(RecordingFit(s.name, s.role, s.n, rms, unit, np.nan, outputs=each))
    return tuple(met)
