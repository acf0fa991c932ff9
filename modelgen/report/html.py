"""The page: a verdict as one HTML file without a script or anything from outside."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from modelgen.diagnose.verdict import Estimate, Finding, Verdict
from modelgen.errors import InputError
from modelgen.files import write_atomically
from modelgen.fit.given import kind
from modelgen.fit.trace import Trace
from modelgen.language.meant import expressions
from modelgen.report import curve as port_curve
from modelgen.report import lack, plots, words
from modelgen.report.formula import formula, sentence, symbol

if TYPE_CHECKING:
    from modelgen.language import Model
    from modelgen.recordings import Case

FIGURES = 6  # recordings that get a figure; the table has all
HYPOTHESES = 12  # rows before the rest is folded away
BENT = 3.0  # a shift of so many standard deviations is called bent
NOT_EXCLUDED = 10.0  # ΔBIC to the best within which a hypothesis stands


def write_html(
    verdict: Verdict, path: str | Path, case: Case | None = None, model: Model | None = None
) -> None:
    """Write the page whole or not at all. `case` adds its file's name, names of outputs and known constants,
    `model` what moves, and the units of inputs.

    Raises InputError or ToolError, one line, when an argument is of another kind or it can't be written.
    """
    _check_given(verdict, path, case, model)
    write_atomically(path, page(verdict, case, model))


def _check_given(verdict: object, path: object, case: object, model: object) -> None:
    """Raise InputError where one of these is of another kind, as when two have changed places."""
    from modelgen.language import Model
    from modelgen.recordings import Case

    for name, found, wanted, says in (
        ("verdict", verdict, Verdict, "a Verdict"),
        ("path", path, str | Path, "a file's name"),
        ("case", case, Case | None, "a Case"),
        ("model", model, Model | None, "a Model"),
    ):
        if not isinstance(found, wanted):
            raise InputError(
                f"{name}: found {kind(found)}, wanted {says}: it is write_html(verdict, path, case, model)"
            )


def page(verdict: Verdict, case: Case | None = None, model: Model | None = None) -> str:
    """The page as text."""
    units = _units(verdict, model)
    ids = [e.id for e in verdict.effects]
    return template("verdict.html.j2").render(
        v=verdict,
        case_file=case.path.name if case is not None and case.path else "",
        headline=words.headline(verdict),
        summary=words.summary(verdict),
        probability=words.joint_probability(verdict),
        figures=_figures(verdict, case, units),
        rows=[_row(t) for t in verdict.traces],
        curve=Markup(port_curve.port(verdict.curve)) if verdict.curve else "",
        lack=_lack(verdict, units, model),
        laws=[formula(law, ids) for law in verdict.law.split(";")] if verdict.law else [],
        slope=port_curve.slope_text(verdict.curve) if verdict.curve else "",
        hypotheses=_hypotheses(verdict),
        shown=HYPOTHESES,
        parameters=_parameters(verdict),
        effect_parameters=[[_own(p, e) for p in e.parameters] for e in verdict.effects],
        same=all(plots.same_model(t) for t in verdict.traces) if verdict.traces else not verdict.effects,
        has_holdout=math.isfinite(verdict.before.holdout_over_noise) or math.isfinite(verdict.before.holdout),
    )


@cache
def template(name: str) -> Any:
    """A page's template with the filters that pages use."""
    import jinja2

    from modelgen.codegen.emit import templates_folder

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(templates_folder()),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters.update(
        number=words.number, short=words.short, percent=words.percent, unit=words.unit_text,
        unit_cell=words.unit_cell, words=words.name_of, symbol=symbol, sentence=sentence,
        english=words.in_english,
    )  # fmt: skip
    environment.globals["measured"] = words.measured
    return environment.get_template(name)


def rms(white: np.ndarray[Any, Any], outliers: np.ndarray[Any, Any]) -> float:
    """Root mean square of whitened residuals (channels, n) without the outliers: 1 if all is noise."""
    kept = white[:, ~outliers]
    kept = kept[np.isfinite(kept)]
    return float(np.sqrt(np.mean(np.square(kept)))) if kept.size else math.nan


def outside(white: np.ndarray[Any, Any]) -> float:
    """Share of whitened residuals outside ±2; of Gaussian noise alone 4.6 %."""
    return float(np.mean(np.abs(white) > 2)) if white.size else math.nan


def _row(trace: Trace) -> dict[str, Any]:
    return {
        "name": trace.name,
        "holdout": trace.role == "holdout",
        "points": len(trace.x),
        "from": words.short(float(np.nanmin(trace.x))),
        "to": words.short(float(np.nanmax(trace.x))),
        "axis": trace.axis,
        "axis_unit": words.unit_text(trace.axis_unit),
        "before": rms(trace.white_before, trace.outliers),
        "after": rms(trace.white_after, trace.outliers),
        "outside_before": outside(trace.white_before),
        "outside_after": outside(trace.white_after),
        "outliers": int(np.sum(trace.outliers)),
        "same": plots.same_model(trace),
    }


def _figures(verdict: Verdict, case: Case | None, units: Mapping[str, str]) -> list[dict[str, Any]]:
    """A figure for each recording, or for those that the model misses most and the worst hold-out."""
    by_misfit = sorted(verdict.traces, key=lambda t: rms(t.white_before, t.outliers), reverse=True)
    chosen = [t for t in by_misfit if t.role == "holdout"][:2]
    chosen += [t for t in by_misfit if t not in chosen][: FIGURES - len(chosen)]
    found = []
    for k, trace in enumerate(t for t in verdict.traces if t in chosen):
        output, constants = _known(trace, case)
        stroke = plots.stroke_of(trace)
        drawn = plots.recording(trace, verdict.mismatch, output, units.get(stroke, ""), f"r{k}")
        found.append(
            _row(trace)
            | {"svg": Markup(drawn), "complex": np.iscomplexobj(trace.data), "stroke": stroke}
            | {"constants": constants, "where": [m for m in verdict.mismatch if m.recording == trace.name]}
        )
    return found


def _units(verdict: Verdict, model: Model | None) -> dict[str, str]:
    """Units of inputs as they are drawn: a verdict's clock runs in seconds where the model's may not."""
    units = {i.name: i.unit for i in model.inputs} if model is not None else {}
    units |= {m.axis: m.unit for m in verdict.mismatch}
    if verdict.curve:
        units[verdict.curve.x_name] = verdict.curve.x_unit
    return units | {n: u for t in verdict.traces for n, u in t.units.items()}


def _known(trace: Trace, case: Case | None) -> tuple[str, dict[str, float]]:
    """Name of the output and the constants of a recording, as the case has them."""
    for recording in case.recordings if case is not None else ():
        if recording.name == trace.name:
            return next(iter(recording.outputs), ""), dict(recording.constants)
    return "", {}


def _lack(verdict: Verdict, units: Mapping[str, str], model: Model | None) -> dict[str, Any] | None:
    """Time records: what the model before lacks, over stroke and speed, where it is missed most."""
    records = [t for t in verdict.traces if lack.drawable(t) and t.role != "holdout"]
    if verdict.curve or verdict.adequate or not records:
        return None
    trace = max(records, key=lambda t: rms(t.white_before, t.outliers))
    stroke = plots.stroke_of(trace)
    moving = lack.moves(units.get(stroke, "")) and (model is None or _moving(verdict, model, stroke))
    return {
        "svg": Markup(lack.lack(trace, units, moving, model)),
        "name": trace.name,
        "same": plots.same_model(trace),
        "moving": moving,
        "cyclic": lack.cyclic(trace),
    }


def _moving(verdict: Verdict, model: Model, stroke: str) -> bool:
    """Whether the displacement at the port of the verdict, or at any, is the recorded `stroke`, and no
    state's; so it is taken where no port names one."""
    named = [p for p in model.ports if any(p.name == e.port for e in verdict.effects)]
    wanted = {str(x) for p in named or model.ports for n, x in p.variables if n == "z"}
    for s in reversed(model.statements):
        if s.name in wanted:
            wanted |= {x.name for expr in expressions(s) for x in expr.free_symbols}
    wanted |= {i.derived[1] for i in model.inputs if i.derived and i.name in wanted}
    return not wanted or (stroke in wanted and not wanted & {s.name for s in model.states})


def _hypotheses(verdict: Verdict) -> list[dict[str, Any]]:
    """Hypotheses with no more effects than the verdict names, best first, then those with more; with the
    length of their bar in percent and what may be said of them."""
    chosen = {e.id for e in verdict.effects}
    count = max(len(chosen), 1)
    trials = sorted(
        (t for t in verdict.trials if math.isfinite(t.delta_bic)),
        key=lambda t: (len(t.ids) > count, t.delta_bic),
    )
    longest = max((-t.delta_bic for t in trials), default=0.0)
    best = min((t.delta_bic for t in trials if len(t.ids) <= count), default=0.0)
    return [
        {
            "trial": t,
            "name": " + ".join(_placed(i, port) for i, port in zip_longest(t.ids, t.ports, fillvalue="")),
            "bar": 100 * max(-t.delta_bic / longest, 0.0) if longest > 0 else 0.0,
            "chosen": bool(chosen) and set(t.ids) == chosen,
            "stands": bool(chosen) and len(t.ids) <= count and t.delta_bic - best < NOT_EXCLUDED,
        }
        for t in trials
    ]


def _placed(id: str, port: str) -> str:
    return f"{words.name_of(id)} at {port}" if port else words.name_of(id)


def _parameters(verdict: Verdict) -> list[dict[str, Any]]:
    """Parameters before and after; `shift` is in standard deviations of the better fit."""
    before = {e.name: e for e in verdict.parameters_before}
    after = {e.name: e for e in verdict.parameters}
    own = {f"{e.id}_{p.name}" for e in verdict.effects for p in e.parameters}
    names = [n for n in before if n not in own] + [n for n in after if n not in before and n not in own]
    return [_change(n, before.get(n), after.get(n)) for n in names]


def _change(name: str, before: Estimate | None, after: Estimate | None) -> dict[str, Any]:
    shift = math.nan
    if before and after:
        std = after.std if math.isfinite(after.std) and after.std > 0 else before.std
        moved = before.value - after.value
        shift = moved / std if math.isfinite(std) and std > 0 else math.nan
    return {
        "name": name,
        "before": before,
        "after": after,
        "shift": shift,
        "bent": abs(shift) > BENT,
        "bar": 50 * min(math.log1p(abs(shift)) / math.log1p(100), 1) if math.isfinite(shift) else 0,
    }


def _own(parameter: Estimate, effect: Finding) -> tuple[Estimate, str]:
    """An effect's parameter and the short name that the effect has for it."""
    return parameter, parameter.name.removeprefix(f"{effect.id}_")
