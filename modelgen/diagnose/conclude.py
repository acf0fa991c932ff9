"""From a search's outcome to a verdict: gate, ranking, hold-out figures, extended model, what a report
shows."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from modelgen.diagnose.averaged import averaged, parameters
from modelgen.diagnose.evidence import effective
from modelgen.diagnose.gate import Gate, judge_adequacy, modelled
from modelgen.diagnose.generic import Leftover
from modelgen.diagnose.holdout import Held, look_at_holdout
from modelgen.diagnose.locate import locate
from modelgen.diagnose.ranking import Standing, standings, weights
from modelgen.diagnose.refit import Fit, plain_white
from modelgen.diagnose.search import claimless
from modelgen.diagnose.setting import CLOSE, Outcome, Setting
from modelgen.diagnose.show import port_curve, port_sensitivities, traces
from modelgen.diagnose.unlisted import with_rivals
from modelgen.diagnose.verdict import Finding, Trial, Verdict
from modelgen.fit.result import Estimate
from modelgen.fit.series import Array
from modelgen.language import Model


def conclude(
    setting: Setting,
    notes: Sequence[str],
    marks: Sequence[Array],
    oddity: Leftover | None,
    outcome: Outcome,
    out: Path | None,
    begun: float,
) -> Verdict:
    """Put the argument together. A claim from sweeps that the hold-out refutes is withdrawn."""
    sensitivities = port_sensitivities(setting, outcome.base)
    outcome = with_rivals(setting, outcome)
    gate = judge_adequacy(setting, outcome, sensitivities, oddity)
    standing = standings(outcome) if not gate.unknown else ()
    best = outcome.best
    if gate.unknown:
        gate = modelled(setting, outcome, gate)
        best = gate.fit or outcome.base
    held = look_at_holdout(setting, outcome.base, best, gate.scale)
    if best.hypothesis.added and not setting.model.is_time_model and outcome.judge.temper == 1.0:
        worse = _worse(held)
        if worse > REFUTED and gate.unknown:  # terms that describe these recordings alone are no model
            best, held = outcome.base, look_at_holdout(setting, outcome.base, outcome.base, gate.scale)
        elif worse > REFUTED:
            told = (
                f"{', '.join(best.ids)} would explain the fit recordings, but predicts the hold-out worse "
                f"than the model without (χ² greater by {worse:.0f}): not claimed"
            )
            return conclude(setting, (*notes, told), marks, oddity, claimless(setting, outcome), out, begun)
    base_estimates = parameters(outcome.judge, outcome.base)
    after_estimates = parameters(outcome.judge, best) if gate.unknown else averaged(outcome, best)
    findings = _findings(setting, outcome, standing, after_estimates, gate)
    port = findings[0].port if findings else "model"
    shown = traces(setting, outcome.base, best, marks, held, gate.scale)
    law, path = _extended(setting, outcome, best, findings, after_estimates, out)
    return Verdict(
        model=setting.model.id,
        adequate=not findings,
        mismatch=locate(setting.model, setting.series, plain_white(outcome.base), port, gate.floor)
        if findings
        else (),
        effects=findings,
        parameters=after_estimates,
        parameters_before=base_estimates,
        before=held.before,
        after=held.after,
        unit=setting.series[0].unit,
        extended_model=path,
        seconds=time.perf_counter() - begun,
        summary=_summary(setting, findings, held, gate, _spare(best)),
        trials=_trials(outcome),
        traces=shown,
        curve=port_curve(setting, outcome, best, sensitivities, port),
        notes=(*notes, *gate.notes, *_bound_note(setting, outcome.base), *_blind_note(outcome), *held.notes),
        noise=gate.noise,
        law=law,
    )


REFUTED = 9.0
"""Three standard deviations: so much worse does the hold-out's χ² by chance alone not get."""


def _worse(held: Held) -> float:
    """By how much χ² of the hold-out grows with the claim."""
    count = sum(s.data.size for s in held.series)
    return (
        float(count * (held.after.holdout_over_noise**2 - held.before.holdout_over_noise**2))
        if count
        else 0.0
    )


def _findings(
    setting: Setting, outcome: Outcome, standing: Sequence[Standing], after: Sequence[Estimate], gate: Gate
) -> tuple[Finding, ...]:
    known = {e.name: e for e in after}
    if gate.unknown:
        better = " better" if gate.tied else ""
        rest = gate.leftover.says or "the residual is not noise"
        says = f"no effect of the catalogue explains it{better}: {rest}"
        port = gate.leftover.port or "model"
        id = f"unknown_{port}"
        others = () if gate.tied is None else gate.tied.ids
        return (
            Finding(
                id, port, says, gate.probability, "unknown", equivalents=others,
                separating_experiment=_told_apart(setting, outcome, gate), parameters=_own(known, id),
            ),
        )  # fmt: skip
    findings = []
    for s in standing:
        own = _own(known, s.addition.id)
        e = s.addition.effect
        findings.append(
            Finding(
                s.addition.id, s.addition.port.name, e.says, s.probability, s.addition.family, e.source,
                s.equivalents, _experiment(setting, outcome, s) if s.equivalents else None, own, s.share,
            )
        )  # fmt: skip
    return tuple(findings)


def _told_apart(setting: Setting, outcome: Outcome, gate: Gate) -> str | None:
    """The recording that would separate what no catalogue holds from named effects that do as well."""
    from modelgen.diagnose.separate import separate

    if gate.fit is None or gate.tied is None:
        return None
    return separate(setting, outcome, gate.fit, [gate.tied], [])


def _own(known: Mapping[str, Estimate], id: str) -> tuple[Estimate, ...]:
    """The parameters of one effect, under their short names."""
    return tuple(
        replace(e, name=n.removeprefix(f"{id}_")) for n, e in known.items() if n.startswith(f"{id}_")
    )


def _experiment(setting: Setting, outcome: Outcome, s: Standing) -> str | None:
    """The recording that would separate this effect from its equivalents."""
    from modelgen.diagnose.separate import separate

    best = outcome.best
    rest = best.hypothesis.key - {s.addition.key}
    others = sorted(
        (
            f
            for f in outcome.tried
            if rest <= f.hypothesis.key and len(f.ids) == len(best.ids) and set(f.ids) != set(best.ids)
        ),
        key=lambda f: f.bic,
    )
    rivals = [f for f in others if f.bic - best.bic < CLOSE] + list(s.elsewise)
    near = [f for f in others if CLOSE <= f.bic - best.bic < CLOSE + NEAR]
    return separate(setting, outcome, best, rivals, near)


NEAR = 5.0
"""ΔBIC beyond CLOSE within which a hypothesis may come back with the next recording."""


def _trials(outcome: Outcome) -> tuple[Trial, ...]:
    fits = sorted(outcome.tried, key=lambda f: f.bic)[:40]
    if not fits:
        return ()
    odds = weights(fits)
    return tuple(
        Trial(f.ids, " + ".join(a.family for a in f.hypothesis.added), f.bic - outcome.base.bic, f.parameters,
              float(np.sqrt(f.chi2 / effective(f.white))), float(w))
        for f, w in zip(fits, odds, strict=True)
    )  # fmt: skip


def _blind_note(outcome: Outcome) -> tuple[str, ...]:
    ids = sorted({a.id for a in outcome.blind})
    if not ids:
        return ()
    return (f"these recordings can't show {', '.join(ids)}: free parameters of the model do the same",)


def _bound_note(setting: Setting, base: Fit) -> tuple[str, ...]:
    """Which parameters the case's own bounds hold: what they forbid may look like physics left out."""
    held = []
    for p, value in zip(base.hypothesis.experiment.layout.parameters, base.theta, strict=True):
        ends = setting.case.bounds.get(p.name.split("[")[0])
        if ends is not None and np.min(np.abs(value - np.array(ends))) <= 1e-6 * (ends[1] - ends[0]):
            held.append(f"{p.name} lies on its bound of {value:.4g}")
    return (f"{', '.join(held)}: what seems left out may be what this forbids",) if held else ()


FEW = 5
"""With fewer values to spare than this a fit without misfit says nothing."""


def _spare(fit: Fit) -> int:
    """Data values beyond the number of fitted parameters."""
    return effective(fit.white) - fit.parameters


def _summary(setting: Setting, findings: Sequence[Finding], held: Held, gate: Gate, spare: int) -> str:
    model, before, after = setting.model.id, held.before.fit_over_noise, held.after.fit_over_noise
    if not findings and spare < FEW:
        return f"{model} can't be judged: {max(spare, 0)} values more than parameters tell nothing."
    if not findings:
        left = f"what is left is {after:.2f} times the noise, and looks like it"
        return f"{model} explains the recordings: {left}.{_but(setting, held, gate)}"
    if gate.unknown:
        says = gate.leftover.says or "the residual is not noise"
        better = " better" if gate.tied else ""
        told = f"{model} leaves {before:.3g} times the noise, which no effect explains{better}: {says}."
        if findings[0].parameters:
            told += f" With these terms it leaves {after:.3g}."
        return told + (f" These data can't tell it from {' and '.join(gate.tied.ids)}." if gate.tied else "")
    names = " and ".join(f.id for f in findings)
    first = (
        f"{model} lacks {names} (probability {findings[0].probability:.0%}): "
        f"the residual falls from {before:.3g} to {after:.3g} times the noise."
    )
    others = findings[0].equivalents
    second = (
        f" These data can't tell it from {', '.join(others)}."
        if others
        else f" {findings[0].says[0].upper() + findings[0].says[1:]}."
    )
    return first + second


MISSED = 1.5
"""A hold-out is missed when it lies this many times the noise from the model."""


def _but(setting: Setting, held: Held, gate: Gate) -> str:
    """What is odd all the same: a stated noise that is wrong by far, a hold-out that is missed."""
    odd = ""
    if all(s.stated for s in setting.series) and not 0.5 < gate.scale < 2.0:
        odd += f" That is {gate.scale:.2g} times the noise that is stated."
    if (out := held.after.holdout_over_noise or 0.0) > MISSED:
        odd += (
            f" But it misses the held-out recordings by {out:.2g} times the noise: beyond what "
            "was fitted it is not to be trusted."
        )
    return odd


def _extended(
    setting: Setting,
    outcome: Outcome,
    best: Fit,
    findings: Sequence[Finding],
    after: Sequence[Estimate],
    out: Path | None,
) -> tuple[str, str | None]:
    """The law in words, and the path of the extended model (with its C beside it)."""
    from sympy import I, Symbol

    if not best.hypothesis.added:
        return "", None
    model = _with_values(best.hypothesis.experiment.model, after)
    changed = {s.name for s in model.statements} - {s.name for s in setting.model.statements}
    ports = {a.port.equation for a in best.hypothesis.added}
    law = "; ".join(
        f"{s.name} = {s.expr.xreplace({I: Symbol('j')})}"
        for s in model.statements
        if hasattr(s, "expr")
        and (s.name in ports or (s.name in changed and s.name.rsplit("_", 1)[0] not in ports))
    )
    if out is None:
        return law, None
    from modelgen.codegen import generate
    from modelgen.files import write_atomically
    from modelgen.language.write import to_python

    path = out / f"{setting.model.id}_extended.py"
    note = f"{setting.model.id} with {', '.join(best.ids)}, found by modelgen diagnose"
    write_atomically(path, to_python(model, note=note), parents=True)
    generate(model, out)
    return law, str(path)


def _with_values(model: Model, after: Sequence[Estimate]) -> Model:
    """The extended model with the fitted values as defaults, under an id of its own."""
    values = {e.name.split("[")[0]: e.value for e in after}
    new = []
    for p in model.parameters:
        if hasattr(p, "re"):
            parts = {
                k: replace(getattr(p, k), default=values.get(getattr(p, k).name, getattr(p, k).default))
                for k in ("re", "im")
            }
            new.append(replace(p, **{k: _inside(v) for k, v in parts.items()}))
        else:
            new.append(_inside(replace(p, default=values.get(p.name, p.default))))
    return replace(model, id=f"{model.id}_extended", parameters=tuple(new), builder=None, options=())


def _inside(p):  # type: ignore[no-untyped-def]
    if p.default is None:
        return p
    low, high = min(p.bounds[0], p.default), max(p.bounds[1], p.default)
    return replace(p, bounds=(low, high))
