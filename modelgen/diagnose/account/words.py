"""A verdict in words: its summary, and notes on what recordings and bounds hide."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from modelgen.diagnose.account.holdout import Held, not_better, taken
from modelgen.diagnose.gate.gate import Gate
from modelgen.diagnose.hypotheses.refit import Fit, enough, spare_values
from modelgen.diagnose.hypotheses.setting import Outcome, Setting
from modelgen.diagnose.verdict import Finding


def blind_note(setting: Setting, outcome: Outcome) -> tuple[str, ...]:
    """What none of its laws, at no port, would be seen by."""
    blind = {a.key for a in outcome.blind}
    ids = sorted({a.id for a in outcome.blind} - {a.id for a in setting.additions if a.key not in blind})
    if not ids:
        return ()
    return (f"these recordings can't show {', '.join(ids)}: free parameters of the model do the same",)


def bound_note(setting: Setting, base: Fit) -> tuple[str, ...]:
    """Which parameters the case's own bounds hold: what they forbid may look like physics left out."""
    held = []
    for p, value in zip(base.hypothesis.experiment.layout.parameters, base.theta, strict=True):
        ends = setting.case.bounds.get(p.name.split("[")[0])
        width = np.inf if ends is None else ends[1] - ends[0]
        if ends is not None and np.min(np.abs(value - np.array(ends))) <= 1e-6 * min(width, np.abs(value)):
            held.append(f"{p.name} lies on its bound of {value:.4g}")
    return (f"{', '.join(held)}: what seems left out may be what this forbids",) if held else ()


def summary(
    setting: Setting, findings: Sequence[Finding], held: Held, gate: Gate, best: Fit, smooth: bool
) -> str:
    """The verdict in a sentence or two; `smooth`: an error that nobody stated is counted as noise."""
    model, before, after = setting.model.id, held.before.fit_over_noise, held.after.fit_over_noise
    if not findings and not enough(best):
        spare = max(spare_values(best), 0)
        return f"{model} can't be judged: {spare} values more than parameters tell nothing."
    if not findings:
        like = "like a smooth error of the instrument that nobody stated" if smooth else "like it"
        left = f"what is left is {after:.2f} times the noise, and looks {like}"
        return f"{model} explains the recordings: {left}.{_but(setting, held, gate)}"
    if gate.unknown:
        says = gate.leftover.says or "the residual is not noise"
        better = " better" if gate.tied else ""
        told = f"{model} leaves {before:.3g} times the noise, which no effect explains{better}: {says}."
        if findings[0].parameters:
            told += f" With these terms it leaves {after:.3g}."
        return told + (f" These data can't tell it from {' and '.join(gate.tied.ids)}." if gate.tied else "")
    names = " and ".join(f.id for f in findings)
    falls = f"the residual falls from {before:.3g} to {after:.3g} times the noise"
    if gate.beside:
        falls = f"the residual, {after:.3g} times the noise, is taken for a smooth error of the instrument"
    first = f"{model} lacks {names} (probability {findings[0].probability:.0%}): {falls}."
    others = findings[0].equivalents
    second = (
        f" These data can't tell it from {', '.join(others)}."
        if others
        else f" {findings[0].says[0].upper() + findings[0].says[1:]}."
    )
    return first + second


WORSE = 9.0
"""Three standard deviations: so much worse does the hold-out's χ² by chance alone not get."""


def holdout_note(held: Held, doubted: bool) -> tuple[str, ...]:
    """Whether the named effects predict the held-out recordings worse than the model without them, or than
    what they leave of the fitted ones and what is uncertain of their parameters foresee; `doubted` where they
    explain little of them."""
    before, after = held.before.holdout_over_noise, held.after.holdout_over_noise
    count = sum(s.data.size for s in held.series)
    if count and count * (after**2 - before**2) > WORSE:
        sure = ", and is half as sure" if doubted else ""
        return (
            f"beyond what was fitted the claim is not to be trusted{sure}: it misses the held-out recordings "
            f"by {after:.3g} times the noise, the model without it by {before:.3g}",
        )
    if doubted and not_better(held):
        return (
            f"the claim is half as sure, as it predicts the held-out recordings no better than the model "
            f"without it: it misses them by {after:.3g} times the noise, the model by {before:.3g}",
        )
    if doubted:
        return (
            f"the claim is half as sure, as it explains little but what was fitted: of what the model misses "
            f"there it takes away {taken(held.before.fit_over_noise, held.after.fit_over_noise):.0%}, of the "
            f"held-out recordings {taken(before, after):.0%}",
        )
    if not after > MISSED * _foreseen(held) or after == before:
        return ()
    return (
        f"beyond what was fitted the law is not quite right: it misses the held-out recordings by "
        f"{after:.3g} times the noise, where {_foreseen(held):.3g} is to be expected",
    )


MISSED = 1.5
"""A hold-out is missed when it lies this many times as far from the model as is to be expected."""


GROWS = 1.02
"""Times the residual before beyond which it is said that it has grown, though less is left over the noise."""


def weighed_note(setting: Setting, outcome: Outcome, held: Held) -> tuple[str, ...]:
    """That a residual grows in its own unit where it falls over a noise that differs from sample to sample:
    two figures of one table."""
    before, after, whiteners = held.before, held.after, outcome.judge.whiteners
    if not (after.fit > GROWS * before.fit and after.fit_over_noise < before.fit_over_noise):
        return ()
    plain = all(w.ar is None and w.root is None for w in whiteners)
    one_unit = len(setting.model.outputs) == 1 and all(s.measure != "phase" for s in setting.series)
    if not (plain and one_unit and any(np.ptp(np.abs(w.weight)) for w in whiteners)):
        return ()
    return (
        f"in {setting.series[0].unit} the residual grows: what is explained lies where the noise, which "
        "differs from sample to sample, is small",
    )


def _foreseen(held: Held) -> float:
    """The hold-out's residual over the noise that is to be expected: as is left of what was fitted, and as
    the parameters are uncertain."""
    uncertain = held.after.foreseen if np.isfinite(held.after.foreseen) else 1.0
    return max(1.0, held.after.fit_over_noise) * uncertain


def _but(setting: Setting, held: Held, gate: Gate) -> str:
    """What is odd all the same: a stated noise that is wrong by far, a hold-out that is missed."""
    odd = ""
    stated = all(s.stated for s in setting.series) and not setting.averaged
    if stated and not 0.5 < gate.scale < 2.0:
        odd += f" That is {gate.scale:.2g} times the noise that is stated."
    if (out := held.after.holdout_over_noise or 0.0) > MISSED * _foreseen(held):
        odd += (
            f" But it misses the held-out recordings by {out:.2g} times the noise: beyond what "
            "was fitted it is not to be trusted."
        )
    return odd
