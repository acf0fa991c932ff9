"""A diagnosis: noise, base fit, search, ranking, gate, verdict. Each claim with its evidence."""

from __future__ import annotations

import gc
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from threadpoolctl import threadpool_limits

from modelgen.codegen import warm
from modelgen.diagnose.clock import in_seconds
from modelgen.diagnose.conclude import conclude
from modelgen.diagnose.gate.exact import exact
from modelgen.diagnose.gate.mirrored import mirrored, opposed
from modelgen.diagnose.gate.narrow import glitch
from modelgen.diagnose.ground import Ground, prepare
from modelgen.diagnose.hypotheses.addition import additions
from modelgen.diagnose.hypotheses.hypothesis import unbuilt
from modelgen.diagnose.hypotheses.refit import Fit
from modelgen.diagnose.hypotheses.scales import motion_scales, port_scale, record_scales, values_at
from modelgen.diagnose.hypotheses.setting import Outcome, Progress, Setting
from modelgen.diagnose.noise.between import smoothly_driven, smoothly_moved
from modelgen.diagnose.noise.bridged import bridged
from modelgen.diagnose.noise.glitches import laid_open, rather, uncovered, unexplained
from modelgen.diagnose.noise.history import had_rested, unrested
from modelgen.diagnose.noise.humming import without_hum
from modelgen.diagnose.noise.noise import marked
from modelgen.diagnose.noise.resolved import unresolved
from modelgen.diagnose.noise.thin import Thinned, thin, told_rightly, unblurred
from modelgen.diagnose.own_effects import check_effects, check_nulls, unused
from modelgen.diagnose.search.search import search
from modelgen.diagnose.verdict import Verdict
from modelgen.diagnose.whole_ports import whole
from modelgen.effects import Effect
from modelgen.effects.kinds import unknown_kinds
from modelgen.fit.given import check_effects_given, check_given, check_held, check_seed
from modelgen.fit.pieces import in_pieces
from modelgen.fit.series import Series, unfitted
from modelgen.fit.steps import TOLERATED, finer, step_errors
from modelgen.language import Model
from modelgen.recordings import Case


def diagnose(
    case: Case,
    model: Model,
    *,
    effects: Sequence[Effect] | None = None,
    progress: Progress = None,
    out: str | Path | None = None,
    seed: int = 0,
) -> Verdict:
    """Say whether `model` explains the recordings of `case`, and if not, which physics was left out.

    effects: further effects beside the catalogue. out: folder for the extended model and its C (none: not
    written). Holdout recordings are looked at once, at the end. Raises InputError when an argument is of
    another kind, or the case can't be fitted.
    """
    from modelgen.effects import CATALOGUE

    check_given(model, case)
    check_seed(seed)
    check_effects_given(effects)
    check_held(case)
    folder = None if out is None else Path(out)
    warm()
    catalogue = (*CATALOGUE, *(effects or ()))
    model, case = in_seconds(model, in_pieces(model, case))
    model = whole(model)
    check_effects(effects or (), model, {k for e in CATALOGUE for k in e.kinds})
    # fits share the cores already; threads of small matrices wait for each other, ten times as long on a busy
    # machine
    with threadpool_limits(1, "blas"), _seldom_collected():
        return _diagnosed(case, model, catalogue, effects or (), progress, folder, seed)


@contextmanager
def _seldom_collected() -> Iterator[None]:
    """Cycles of objects are looked for seldom: they hold little, and the search for them takes 4 % of a
    diagnosis."""
    before = gc.get_threshold()
    gc.set_threshold(50_000, *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)


def _diagnosed(
    case: Case,
    model: Model,
    catalogue: Sequence[Effect],
    own: Sequence[Effect],
    progress: Progress,
    out: Path | None,
    seed: int,
) -> Verdict:
    begun, read = time.perf_counter(), (*case.warnings, *unfitted(model, case))
    if progress:
        progress(0.02, "reading")
    case, glitches = bridged(model, case)
    case, hum = without_hum(model, case)
    model, made, steps = _finely_stepped(model, case, seed)
    seen = (*unresolved(model, made.ground.series), *mirrored(model, made.case, made.ground.base, seed))
    if progress:
        progress(0.15, "base fitted")
    if own:
        alone = set_up(model, made.case, made.ground, own)
        check_nulls(alone.additions, alone, made.ground.base)
    made, setting, outcome = _accounted(model, made, catalogue, seed, progress)
    case, ground, thinned = made.case, made.ground, made.thinned
    notes = (*read, *thinned.notes, *steps, *unknown_kinds(model, own), *glitches, *hum, *seen, *made.notes)
    setting = replace(setting, averaged=thinned.finer is not None)
    if progress:
        progress(0.9, "deciding")
    turned = opposed(model, case, ground.base, outcome.best, seed)
    idle = (*unused(own, model, setting.additions), *unbuilt(model, setting.additions))
    marks = ground.marks
    if ground.oddity is None:
        marks = unexplained(outcome.best, ground.bare, marks)
    notes = (*notes, *idle, *marked(ground.series, marks), *turned)
    return conclude(setting, notes, marks, ground.oddity, outcome, out, begun)


@dataclass(frozen=True)
class _Prepared:
    """A case as it is to be judged, with its ground; `rested`: as it would be had the sample no past."""

    thinned: Thinned
    case: Case
    ground: Ground
    notes: tuple[str, ...]
    rested: Case | None = None


def _prepared(model: Model, thinned: Thinned, seed: int) -> _Prepared:
    """The case with inputs that ran as the base says they did between their samples, and with a past of its
    memory; a note where they ran smoothly or the sample had not rested."""
    ground = prepare(model, thinned.case, seed)
    thinned, before = told_rightly(thinned, ground.base), thinned
    case, notes = thinned.case, []
    ground = ground if thinned is before else prepare(model, case, seed)
    for _ in range(BLURRED):
        sharp = unblurred(thinned, ground.base, ground.judge)
        if sharp is None:
            break
        case, ground = sharp, prepare(model, sharp, seed)
    rested = None
    for ask, note in ((smoothly_driven, SMOOTH), (smoothly_moved, ROUND), (unrested, UNRESTED)):
        other = ask(model, case, ground.base, ground.judge)
        if other is not None:
            rested = case if note is UNRESTED else None
            case, ground = other, prepare(model, other, seed)
            notes.append(note)
    return _Prepared(thinned, case, ground, tuple(notes), rested)


HALVED = 4
"""Times that steps of integration are halved, to a sixteenth."""


def _finely_stepped(model: Model, case: Case, seed: int) -> tuple[Model, _Prepared, tuple[str, ...]]:
    """The model with steps short enough that what they miss is far below the noise, its case prepared, and a
    note where it has others than it came with: errors of integration are no physics."""
    made, times = _prepared(model, thin(model, case), seed), 1
    before = worst = _coarsest(made.ground.base)
    while worst > TOLERATED and times < 2**HALVED:
        model, times = finer(model), 2 * times
        made = _prepared(model, thin(model, case), seed)
        worst = _coarsest(made.ground.base)
    if times == 1:
        return model, made, ()
    note = (
        f"states are integrated in {times} times as many steps between samples as the model has: with its "
        f"own, the output changes by {before:.3g} times the noise when they are halved"
    )
    return model, made, (note if worst <= TOLERATED else f"{note}, and by {worst:.3g} times with these",)


def _coarsest(base: Fit) -> float:
    return max(step_errors(base.hypothesis.experiment, base.theta), default=0.0)


def _accounted(
    model: Model, made: _Prepared, catalogue: Sequence[Effect], seed: int, progress: Progress = None
) -> tuple[_Prepared, Setting, Outcome]:
    """The search; and once more, where what it found tells that the sample had rested, or what the motion was
    within a block of samples, which the base could not."""
    ground, setting, outcome = _searched(model, made.case, made.ground, catalogue, seed, progress)
    again = None
    if made.rested is not None and had_rested(model, made.rested, outcome.best, outcome.judge):
        again, notes = made.rested, tuple(n for n in made.notes if n is not UNRESTED)
    elif not made.notes:
        again, notes = unblurred(made.thinned, outcome.best, outcome.judge), ()
    if again is not None:
        made = replace(made, case=again, ground=prepare(model, again, seed), notes=notes)
        before = outcome.best
        ground, setting, outcome = _searched(model, made.case, made.ground, catalogue, seed, progress, before)
    return replace(made, ground=ground), setting, outcome


BLURRED = 2
"""Times that what averaging does to the base is told from a base that is fitted anew."""
SMOOTH = "inputs ran smoothly between their samples: with straight lines the base fits far worse"
ROUND = (
    "the motion ran smoothly between its samples: what straight ways make of the model's memory is taken off "
    "the recordings, which fit far better so"
)
UNRESTED = (
    "the sample had not rested before the records: what its memory begins with is fitted, in each its own"
)


def set_up(model: Model, case: Case, ground: Ground, catalogue: Sequence[Effect]) -> Setting:
    """The additions that this model and these recordings allow."""
    e = ground.base.hypothesis.experiment
    values = [values_at(e, ground.base.theta, k) for k in range(len(ground.series))]
    sizes = {p.equation: port_scale(p, values) for p in model.ports}
    along = [s.inputs[model.axis] for s in ground.series]
    motions = {p.equation: motion_scales(model, p, values, along) for p in model.ports}
    scales, repeats = record_scales(model, ground.series), _repeats(model, ground.series)
    records = tuple(s.name for s in ground.series)
    found = additions(model, catalogue, scales, sizes, motions, repeats, records)
    return Setting(model, case, ground.series, tuple(found), ground.others, base=ground.base)


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
    before: Fit | None = None,
) -> tuple[Ground, Setting, Outcome]:
    """The search; and once more, where what it found lays outliers open that the base's misfit had hidden.

    before: what an earlier search had found.
    """
    setting = replace(set_up(model, case, ground, catalogue), before=before)
    if exact(ground.base):
        return ground, setting, Outcome(ground.judge, ground.base, ground.base, (), ())
    outcome = search(setting, ground.base, ground.judge, progress)
    if model.is_time_model:
        seen, alone = uncovered(outcome.best, ground.bare, ground.marks), None
    else:
        seen = laid_open(outcome.base, outcome.best, ground.bare, ground.marks)
        alone = glitch(outcome) if seen is None else None
    if alone is not None:
        seen = [a | b for a, b in zip(alone, ground.marks, strict=True)]
    if seen is None:
        return ground, setting, outcome
    again = prepare(model, case, seed, seen)
    anew = replace(set_up(model, case, again, catalogue), before=outcome.best)
    found = search(anew, again.base, again.judge, progress)
    # what stands on one sweep's few samples has nothing else for it, however well it explains them
    if alone is None and rather(outcome.judge, outcome.best, found.best):
        return ground, setting, outcome
    return again, anew, found
