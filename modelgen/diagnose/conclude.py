"""From a search's outcome to a verdict: gate, ranking, hold-out figures, extended model, what a report
shows."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from modelgen.diagnose.account.extended import extended
from modelgen.diagnose.account.holdout import carries_over, look_at_holdout
from modelgen.diagnose.account.locate import locate
from modelgen.diagnose.account.show import port_curve, port_sensitivities, traces
from modelgen.diagnose.account.trials import trials
from modelgen.diagnose.account.words import blind_note, bound_note, holdout_note, summary, weighed_note
from modelgen.diagnose.gate.disagree import disagreeing, disagreement_note
from modelgen.diagnose.gate.exact import exact, nothing_left
from modelgen.diagnose.gate.gate import Gate, judge_adequacy, modelled
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.gate.likeliest_path import kept_along_path
from modelgen.diagnose.gate.notes import motion_note, smooth_note
from modelgen.diagnose.gate.rather import rather_described
from modelgen.diagnose.gate.rivals import by_odd_noise
from modelgen.diagnose.gate.size import reach
from modelgen.diagnose.gate.unlisted import is_unlisted, named_rather, with_rivals
from modelgen.diagnose.gate.vague import likely, of_many, told
from modelgen.diagnose.hypotheses.averaged import as_one, averaged, parameters
from modelgen.diagnose.hypotheses.moderate import moderated
from modelgen.diagnose.hypotheses.open_shapes import fairly_priced
from modelgen.diagnose.hypotheses.ranking import Standing, as_ranked, close, standings
from modelgen.diagnose.hypotheses.refit import Fit, enough, mean_square, plain_white
from modelgen.diagnose.hypotheses.setting import CLOSE, TEMPER, Outcome, Setting, nearest
from modelgen.diagnose.verdict import Finding, Verdict
from modelgen.fit.result import Estimate
from modelgen.fit.series import Array


@dataclass(frozen=True)
class Decision:
    """What is claimed: named effects (`standing`), or unknown physics where the gate says so; `best` is the
    fit that the verdict shows, `vague` notes on effects that could not be named."""

    setting: Setting
    outcome: Outcome
    gate: Gate
    best: Fit
    standing: tuple[Standing, ...] = ()
    vague: tuple[str, ...] = ()


def conclude(
    setting: Setting,
    notes: Sequence[str],
    marks: Sequence[Array],
    oddity: Leftover | None,
    outcome: Outcome,
    out: Path | None,
    begun: float,
) -> Verdict:
    """Put the argument together. Held-out recordings are looked at when all is decided."""
    sensitivities = port_sensitivities(setting, outcome.base)
    decided = _decide(setting, outcome, sensitivities, oddity)
    setting, outcome, gate, best = decided.setting, decided.outcome, decided.gate, decided.best
    base = best if best is outcome.base else nearest(setting, outcome.base)
    held = look_at_holdout(setting, replace(outcome, base=base), best, gate.scale)
    base_estimates = parameters(outcome.judge, base)
    after_estimates = parameters(outcome.judge, best) if gate.unknown else averaged(outcome, best)
    doubted = bool(decided.standing) and not carries_over(held)
    standing = _halved(decided.standing) if doubted else decided.standing
    findings = _findings(setting, outcome, standing, after_estimates, gate)
    port = findings[0].port if findings else "model"
    shown = traces(setting, base, best, marks, held, gate.scale)
    law, path = extended(setting, best, after_estimates, out)
    return Verdict(
        model=setting.model.id,
        adequate=not findings,
        mismatch=locate(setting.model, setting.series, plain_white(base), port, gate.floor)
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
        summary=summary(setting, findings, held, gate, best, outcome.judge.smooth is not None),
        trials=trials(outcome),
        traces=shown,
        curve=port_curve(setting, best, sensitivities, port),
        notes=(
            *notes, *gate.notes, *decided.vague, *smooth_note(setting, outcome, gate.leftover),
            *motion_note(setting, outcome),
            *disagreement_note(setting, outcome, best, gate.scale),
            *bound_note(setting, base), *blind_note(setting, outcome),
            *(as_one(outcome.judge, best) if standing else ()),
            *held.notes, *weighed_note(setting, outcome, held), *holdout_note(held, doubted),
        ),
        noise=gate.noise,
        law=law,
        judged=bool(findings) or enough(best),
    )  # fmt: skip


def _decide(
    setting: Setting, outcome: Outcome, sensitivities: Mapping[str, Array], oddity: Leftover | None
) -> Decision:
    """Gate the best hypothesis, then name what it holds, or model what nothing names."""
    if exact(outcome.base):
        return Decision(setting, outcome, nothing_left(outcome, enough(outcome.base)), outcome.base)
    outcome = named_rather(with_rivals(setting, rather_described(setting, outcome)))
    if by_odd_noise(setting, outcome):
        outcome = replace(outcome, best=outcome.base)
    gate = judge_adequacy(setting, outcome, sensitivities, oddity)
    if outcome.best.ids or gate.unknown:
        setting, outcome, gate = _stands(setting, outcome, gate, sensitivities, oddity)
    gate = modelled(setting, outcome, gate) if gate.unknown else gate
    gate = disagreeing(setting, outcome, gate) or gate
    if gate.unknown:
        return Decision(setting, outcome, gate, gate.fit or outcome.base)
    outcome, standing, vague = told(setting, outcome, standings(outcome))
    if not vague:
        outcome = fairly_priced(setting, outcome, exempt=is_unlisted)
        standing = standings(outcome)
        many = of_many(setting, outcome, standing, gate)
        if many is not None:
            return Decision(setting, outcome, many, outcome.best)
        outcome, standing, vague = likely(setting, outcome, standing)
    standing = _as_far_as_it_reaches(setting, outcome, gate, standing)
    return Decision(setting, outcome, gate, moderated(outcome.judge, outcome.best), standing, vague)


def _halved(standing: Sequence[Standing]) -> tuple[Standing, ...]:
    """Names whose effects explain little but the recordings that they were fitted to."""
    return tuple(replace(x, probability=x.probability / 2) for x in standing)


def _as_far_as_it_reaches(
    setting: Setting, outcome: Outcome, gate: Gate, standing: tuple[Standing, ...]
) -> tuple[Standing, ...]:
    """Less sure names where far more than noise is left: by the part of the way to the recordings that is
    missing; half as sure those that need a smooth error beside them that nobody stated; and by the odds of an
    error of how the sweeps were taken, where one would do as well."""
    if gate.beside:
        return _beside(_halved(standing), gate.leftover.port or _only_port(setting))
    before, after = (mean_square(plain_white(f)) for f in (nearest(setting, outcome.base), outcome.best))
    reached = reach(before, after, gate.floor)
    if gate.error is not None:
        reached /= 1 + float(np.exp(gate.error.gain / (2 * TEMPER))) / COMMONER
    less_sure = tuple(replace(x, probability=x.probability * reached) for x in standing)
    return less_sure if gate.error is None else _beside(less_sure, gate.error.port)


COMMONER = 5.0
"""Times as common as an error of how sweeps are taken is physics of the catalogue."""


def _beside(standing: Sequence[Standing], port: str) -> tuple[Standing, ...]:
    """Names with what is unknown at the port among their equivalents."""
    rest = f"unknown_{port}"
    return tuple(replace(x, equivalents=tuple(dict.fromkeys((*x.equivalents, rest)))) for x in standing)


def _stands(
    setting: Setting,
    outcome: Outcome,
    gate: Gate,
    sensitivities: Mapping[str, Array],
    oddity: Leftover | None,
) -> tuple[Setting, Outcome, Gate]:
    """What is claimed, or nothing where errors of the recorded path explain as much."""
    found = kept_along_path(setting, outcome)
    if found is None:
        return setting, outcome, gate
    again = judge_adequacy(*found, sensitivities, oddity)
    return (setting, outcome, gate) if again.unknown else (*found, again)


def _findings(
    setting: Setting, outcome: Outcome, standing: Sequence[Standing], after: Sequence[Estimate], gate: Gate
) -> tuple[Finding, ...]:
    known = {e.name: e for e in after}
    if gate.unknown:
        better = " better" if gate.tied else ""
        rest = gate.leftover.says or "the residual is not noise"
        says = f"no effect of the catalogue explains it{better}: {rest}"
        port = gate.leftover.port or _only_port(setting)
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
                s.equivalents, _experiment(setting, outcome, gate, s) if s.equivalents else None, own,
                s.share,
            )
        )  # fmt: skip
    return tuple(findings)


def _only_port(setting: Setting) -> str:
    """Where physics that nothing describes must be, if there is but one place."""
    names = {p.name for p in setting.model.ports}
    return names.pop() if len(names) == 1 else "model"


def _told_apart(setting: Setting, outcome: Outcome, gate: Gate) -> str | None:
    """The recording that would separate what no catalogue holds from named effects that do as well."""
    from modelgen.diagnose.experiment.separate import separate

    if gate.fit is None or gate.tied is None:
        return None
    return separate(setting, outcome, gate.fit, [gate.tied], [])


def _own(known: Mapping[str, Estimate], id: str) -> tuple[Estimate, ...]:
    """The parameters of one effect, under their short names."""
    return tuple(
        replace(e, name=n.removeprefix(f"{id}_")) for n, e in known.items() if n.startswith(f"{id}_")
    )


NEAR = 5.0
"""ΔBIC beyond CLOSE within which a hypothesis may come back with the next recording."""
LAWS = 20.0
"""… if it is another law of what is told already."""
MOST = 5
"""Hypotheses that may come back, that a recording has to exclude."""


ANOTHER = "the same sweeps by another instrument would tell whether what is left is an error of this one"


def _experiment(setting: Setting, outcome: Outcome, gate: Gate, s: Standing) -> str:
    """The recording that would separate this effect from its equivalents; without hypotheses to be separated
    these are other names of the same law (`Effect.alike`), or a smooth error has to be seen or not."""
    from modelgen.diagnose.experiment.separate import separate

    best = outcome.best
    rest = best.hypothesis.key - {s.addition.key}
    others = sorted(
        (
            f
            for f in outcome.tried
            if rest <= f.hypothesis.key
            and len(f.ids) == len(best.ids)
            and f.hypothesis.key != best.hypothesis.key
        ),
        key=lambda f: f.bic,
    )
    rivals = [f for f in others if set(f.ids) != set(best.ids) and close(outcome, f)] + list(s.elsewise)
    named = {i for f in (best, *rivals) for i in f.ids}
    near = [
        f
        for f in others
        if not any(f is r for r in rivals)
        and f.bic - best.bic < CLOSE + (LAWS if set(f.ids) <= named else NEAR)
    ]
    told = separate(setting, outcome, best, [as_ranked(outcome, f) for f in rivals], near[:MOST])
    if told is not None:
        return told
    if gate.beside:
        return ANOTHER
    same = " and ".join((s.addition.id, *s.equivalents))
    return f"no recording of this menu would tell them apart: {same} are the same function of what was varied"
