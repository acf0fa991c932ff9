"""Which recording would tell apart the hypotheses that the data do not exclude.

Any of them may be true: each plan of a menu is made as each of them says, the others are fitted to it and to
what is there already. A plan is worth the probability that only the truth would be left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modelgen.diagnose.experiment.foresee import excluded
from modelgen.diagnose.experiment.hopes import hopes
from modelgen.diagnose.experiment.menu import TIMES, Plan, often, plans
from modelgen.diagnose.experiment.rivals import Rivals, same
from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.ranking import weights
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import Outcome, Setting

MOST = 5
"""Rivals of the best hypothesis that a recording has to tell apart."""
SURE = 0.93
"""Worth from which no dearer plan is looked for."""
FAIR = 0.05
"""Worth below which no plan is proposed."""
BETTER = 0.05
"""Worth that a dearer plan must have more."""
CLOSELY = 4
"""Plans that are looked at closely: a count, not a time, so that all machines propose the same."""
LIKELY = 0.5
"""Chance from which a hypothesis, were it true, is said to be told from the others."""
CLEAR = 6.0
"""χ² below which a rival is excluded by needing more parameters, if at all."""
ROUGH = 4.0
"""χ² per sample from which errors of the best hypothesis hide more than noise does: averaging is no help."""


@dataclass(frozen=True, eq=False)
class Proposal:
    """A recording; the smallest χ² and BIC by which a rival would then stay behind the truth; its worth; and
    the hypotheses that it would leave alone, were they true; together: each with those that say the same."""

    plan: Plan
    separation: float
    lead: float
    worth: float
    tells: tuple[Fit, ...]
    together: bool = False


def separate(
    setting: Setting,
    outcome: Outcome,
    best: Fit,
    rivals: Sequence[Fit],
    near: Sequence[Fit] = (),
) -> str | None:
    """One sentence: which recording would separate `best` from its `rivals` best, and by how much χ².

    near: hypotheses that the data exclude by little. None without rivals. The figure is the smallest misfit
    that a rival would be left with, all its parameters fitted again to old and new recording, the new one
    without noise. Where this is to be expected only if some of the hypotheses are true, the sentence says so.
    """
    rivals = list(rivals)[:MOST]
    if not rivals:
        return None
    found = propose(setting, outcome.judge, best, rivals, near)
    ours, theirs = _names(best, rivals)
    if found is None and all(same(best, r) for r in rivals):
        return f"no recording of this menu would tell them apart: {ours} and {theirs} say the same"
    if found is None:
        kinds = "rate, amplitude or mean" if setting.model.is_time_model else "band, load or amplitude"
        return (
            f"no recording of this menu would tell them apart: {ours} and {theirs}, by another {kinds}, "
            f"averaged {TIMES[-1]} times"
        )
    by, what = (
        (found.separation, "chi-square")
        if found.separation > CLEAR
        else (found.lead, "BIC, which has a price for each parameter")
    )
    figure = f"{float(f'{by:.2g}'):g} ({what})"
    least = "at least " if len(rivals) > 1 or len(found.tells) > 1 else ""
    fits = (best, *rivals)
    alike = [r for r in rivals if found.together and set(r.ids) != set(best.ids) and same(best, r)]
    if alike:
        known = {i for f in (best, *alike) for i in f.ids}
        others = [r for r in rivals if not set(r.ids) <= known] or rivals
        ours = " or ".join(dict.fromkeys(" + ".join(_own(f, fits)) for f in (best, *alike)))
        ours, theirs = f"{ours} (one and the same so far)", _names(best, others)[1]
    told = f"{_said(setting, found.plan)} would separate {ours} from {theirs} by {least}{figure}"
    if all(any(f is t for t in found.tells) for f in fits):
        return told
    there = " or ".join(dict.fromkeys(" + ".join(_own(f, fits)) for f in found.tells))
    return f"{told}, if {there} is what is there"


def _said(setting: Setting, plan: Plan) -> str:
    """A plan in words, of several recordings with the name of the one that it is made in the manner of."""
    if len(setting.series) < 2:
        return plan.says
    name = setting.series[_longest(setting)].name
    return plan.says.replace("the same motion", f"the same motion as in {name}", 1)


def _longest(setting: Setting) -> int:
    """The recording with most samples."""
    return int(np.argmax([s.n for s in setting.series]))


def _own(fit: Fit, fits: Sequence[Fit]) -> list[str]:
    """What a hypothesis has that not all have."""
    return [i for i in fit.ids if not all(i in f.ids for f in fits)] or list(fit.ids)


def _names(best: Fit, rivals: Sequence[Fit]) -> tuple[str, str]:
    """What differs, by name."""
    others = {i for r in rivals for i in r.ids}
    theirs = [i for i in dict.fromkeys(i for r in rivals for i in r.ids) if i not in best.ids] or sorted(
        others
    )
    listed = " and ".join([", ".join(theirs[:-1]), theirs[-1]] if len(theirs) > 1 else theirs)
    return " + ".join(_own(best, rivals)) or "the model as it is", listed or "the model as it is"


def propose(
    setting: Setting,
    judge: Judge,
    best: Fit,
    rivals: Sequence[Fit],
    near: Sequence[Fit] = (),
) -> Proposal | None:
    """The plan of the greatest worth that leaves one hypothesis alone; or where some are one law under
    several names, so that hardly any would, that leaves these and nothing else."""
    k = _longest(setting)
    scale = max(1.0, best.chi2 / effective(best.white))
    fits = (best, *rivals)
    group = Rivals(setting, judge, fits, tuple(near), k, scale)
    alone = _best(group)
    twins = [f for f in fits if any(set(g.ids) != set(f.ids) and same(f, g) for g in fits)]
    if not twins or (alone is not None and alone.worth > LIKELY):
        return alone
    if all(same(best, r) for r in rivals):
        return alone  # another law of one of them is too seldom what is there
    laws = _other_laws(twins, near)
    rest = tuple(f for f in near if not any(f is x for x in laws))
    both = _best(replace(group, fits=(*fits, *laws), near=rest, together=True))
    return max((p for p in (alone, both) if p is not None), key=lambda p: p.worth, default=None)


def _best(group: Rivals) -> Proposal | None:
    """The plan of the greatest worth, or the one of least trouble that is SURE; of the CLOSELY most hopeful
    ones."""
    odds = weights(group.fits).tolist()
    top: Proposal | None = None
    for plan, hope in _promising(group, odds)[:CLOSELY]:
        if top is not None and top.worth > SURE:
            break
        better = max(FAIR, top.worth + BETTER if top else 0.0)
        found = _foreseen(group, plan, odds) if hope > better else None
        if found is not None and found.worth > better and _parts(found):
            top = found
    return top


def _other_laws(twins: Sequence[Fit], near: Sequence[Fit]) -> list[Fit]:
    """The next law of each of those that are the same law under several names: by that they differ."""
    found: dict[frozenset[str], Fit] = {}
    for f in near:
        if any(set(t.ids) == set(f.ids) for t in twins) and not any(same(f, t) for t in twins):
            found.setdefault(frozenset(f.ids), f)
    return list(found.values())


def _parts(found: Proposal) -> bool:
    """Whether rivals would stay behind: what leaves one of them ahead is no separation."""
    return found.separation > CLEAR or found.lead > 0


def _promising(group: Rivals, odds: Sequence[float]) -> list[tuple[Plan, float]]:
    """Plans with what they would be worth were all rivals linear: of those near the greatest the one that is
    the least trouble, then the greatest first."""
    found: list[tuple[Plan, float]] = []
    for plan in _menu(group, group.fits[0]):
        made = [p for p in often(plan) if p.averaged == 1 or group.scale < ROUGH]
        if plan.again and group.judge.temper > 1.0:
            continue  # errors of models come again
        if not made:
            continue
        worth = hopes(group, plan, [p.averaged for p in made], odds)
        found += [(p, float(w)) for p, w in zip(made, worth, strict=True) if w > FAIR]
    found.sort(key=lambda x: -x[1])
    first = min((x for x in found if x[1] > SURE * found[0][1]), key=lambda x: x[0].cost, default=None)
    return sorted(found, key=lambda x: x is not first)


def _menu(group: Rivals, best: Fit) -> tuple[Plan, ...]:
    """What could be recorded in the manner of the longest recording, the least trouble first."""
    setting, k = group.setting, group.k
    e = best.hypothesis.experiment
    fitted = dict(zip(e.layout.wrt, e.local(best.theta, k).tolist(), strict=True))
    known = {p.name: p.default for p in setting.model.scalar_parameters if p.default is not None}
    known |= {**setting.case.constants, **setting.series[k].constants, **fitted}
    held = {n: v for n, v in known.items() if n not in fitted or n in setting.series[k].constants}
    reference = replace(setting.series[k], constants=held)
    series = [reference if i == k else s for i, s in enumerate(setting.series)]
    return plans(setting.model, series, k, known)


def _foreseen(group: Rivals, plan: Plan, odds: Sequence[float]) -> Proposal:
    """What a plan is worth."""
    found = [excluded(group, plan, i) for i in range(len(group.fits))]
    likely = min(LIKELY, max(x.chance for x in found))
    tells = [i for i, x in enumerate(found) if x.chance >= likely]
    separation, lead = min(found[i].behind for i in tells), min(found[i].lead for i in tells)
    worth = sum(w * x.chance for w, x in zip(odds, found, strict=True))
    told = tuple(group.fits[i] for i in tells)
    return Proposal(plan, float(separation), float(lead), float(worth), told, group.together)
