"""An estimation in stages as the result of a fit."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from modelgen.errors import InputError
from modelgen.fit.conditions import broken_in
from modelgen.fit.method import Progress, Seed
from modelgen.fit.recipe import Recipe, Staged, StageResult, run_recipe
from modelgen.fit.result import Estimate, FitResult, RecordingFit
from modelgen.language import Model
from modelgen.recordings import Case


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
    try:
        found = run_recipe(recipe, model, case, seed, progress, constrained=constrained)
    except InputError as why:  # a paper's recipe names what its own model has
        raise InputError(f"{recipe.name}: {why}") from why
    amiss = _broken(model, case, found, constrained)
    std = np.sqrt(found.covariance.diagonal())
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = found.covariance / np.outer(std, std)
    rows = zip(found.names, std.tolist(), found.determined.tolist(), strict=True)
    return FitResult(
        model=model.id,
        parameters=tuple(
            Estimate(n, found.values[n], s, model.parameter(n).unit, determined=known) for n, s, known in rows
        ),
        correlation=correlation,
        rank=found.rank,
        undetermined=found.undetermined,
        rms={s.unit: _by_role(s) for s in found.stages},
        rms_over_noise={},
        seconds=time.perf_counter() - began,
        reason=found.stages[-1].outcome.reason.value,
        method=recipe.text or recipe.name,
        recordings=tuple(
            _all_measures(*of) for of in zip(*(s.recordings for s in found.stages), strict=True)
        ),
        notes=(*(_note(k, s) for k, s in enumerate(found.stages, 1)), *amiss),
        warnings=amiss,
    )


def _broken(model: Model, case: Case, found: Staged, constrained: bool) -> tuple[str, ...]:
    """Conditions that the values break, in the recordings that were fitted."""
    values = {p.name: p.default for p in model.scalar_parameters if p.default is not None}
    values |= dict(case.constants) | dict(found.values)
    return broken_in(model, [(r.name, values | dict(r.constants)) for r in case.fit], constrained)


def _by_role(s: StageResult) -> dict[str, float]:
    held = {} if np.isnan(s.held_out) else {"holdout": s.held_out}
    return {"fit": s.objective} | held


def _note(k: int, s: StageResult) -> str:
    """What stage k reached, and how it predicts what is held out."""
    held = "" if np.isnan(s.held_out) else f"; {s.held_out:.4g} {s.unit} on what is held out"
    return f"stage {k}: {s.objective:.4g} {s.unit} rms of the {s.stage.measure} by {', '.join(s.names)}{held}"


def _all_measures(*stages: RecordingFit) -> RecordingFit:
    """One recording in all measures: of stages with the same unit the last counts, as in the rms of all."""
    first, *others = {r.unit: r for r in stages}.values()
    outputs = tuple(o for r in (first, *others) for o in r.outputs)
    return replace(first, others=tuple((r.rms, r.unit) for r in others), outputs=outputs)
