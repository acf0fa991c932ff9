"""What is said beside a verdict: of the noise, of what is left, of what would do as well."""

from __future__ import annotations

import numpy as np

from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.hypotheses.ranking import standings
from modelgen.diagnose.hypotheses.setting import Outcome, Setting
from modelgen.diagnose.noise.smooth_error import part_of_reading
from modelgen.fit.series import input_noise


def beside_note(outcome: Outcome, after: float) -> tuple[str, ...]:
    """What named effects need beside them, which nobody stated."""
    error = "a smooth error of the instrument that nobody stated"
    names, size = " and ".join(outcome.best.ids), f"{np.sqrt(after):.1f} times the noise"
    return (f"{names} would do beside {error}, {size}; as well they may stand in for all of it",)


def smooth_note(setting: Setting, outcome: Outcome, left: Leftover) -> tuple[str, ...]:
    """What a smooth error of the instrument that nobody stated would have to be, where one is counted as
    noise, and what is `left` is no other error of how sweeps were taken."""
    found = outcome.judge.smooth
    if found is None or left.weights:
        return ()
    size = part_of_reading(setting.series, found)
    where = "the same in all sweeps" if found.shared else "in each sweep its own"
    return (
        f"counted as noise: a smooth error of the instrument of {100 * size:.1g} % of the reading, {where}, "
        f"alike within a factor of {np.exp(found.length):.2g} in frequency; if the instrument is known to be "
        "better, physics is missing that nothing here explains better",
    )


FULLY = 0.99
"""Part of a misfit beyond which it isn't told by how much it is short of all."""
LIKE = 1.05
"""Times the noise below which a residual is told from it by how it goes, not by its size."""


def far_notes(
    outcome: Outcome, unknown: bool, left: Leftover, explained: float, rest: float
) -> tuple[str, ...]:
    """How far the rest is from noise, and what the named effects have explained."""
    if not outcome.best.ids:
        return ()
    if not unknown:
        says = f": {left.says}" if left.says else "" if rest < LIKE else ": not noise"
        part = f"{explained:.0%}" if explained < FULLY else f"more than {FULLY:.0%}"
        far = f"still left is {rest:.1f} times the noise"
        size = far if rest >= LIKE else "what is left is small, but no noise"
        return (f"the named effects explain {part} of the misfit; {size}{says}",)
    if outcome.judge.temper == 1.0 or explained < 1 - FULLY:
        return ()
    kinds = ((s.addition.id, *s.equivalents) for s in standings(outcome))
    listed = ([i for i in ids if not i.startswith("unknown_")] for ids in kinds)
    names = " and ".join(" or ".join(ids) for ids in listed if ids)
    return (f"the best that the catalogue has, {names}, explains {explained:.0%} of the misfit",)


def level_note(scale: float) -> tuple[str, ...]:
    """By how much the residual that is taken for noise is more, or less, than what was stated."""
    if abs(np.log(scale)) < np.log(NOTED):
        return ()
    more = "; if that is right, something is still missing which nothing here explains better"
    return (
        f"what is left is {scale:.2g} times the noise that is stated, and is counted as the noise"
        f"{more if scale > 1 else ''}",
    )


MOSTLY = 2.0
"""Times the stated noise of an output from which it is told that errors of the motion make most of it."""


def motion_note(setting: Setting, outcome: Outcome) -> tuple[str, ...]:
    """That errors of a motion which nobody stated, or larger than stated, make most of the noise."""
    model, moved = setting.model, setting.model.moved
    shares = [w.share for w in outcome.judge.whiteners if w.smear is not None and w.share is not None]
    share = np.concatenate(shares) if shares else np.zeros(0)
    share = share[share > 0]
    stated = all(s.stated for s in setting.series)
    if not moved or not stated or not share.size:
        return ()
    times = float(np.median(1 / share))
    known = [input_noise(model, setting.case, r).get(moved) for r in setting.case.fit]
    if times < MOSTLY or all(known):
        return ()
    return (
        f"errors of {moved}, as it scatters from sample to sample, make most of the noise: {times:.2g} times "
        f"what is stated of {' and '.join(o.name for o in model.outputs)}",
    )


NOTED = 1.15
"""Times the stated noise, or as much less, from which it is said that the noise was another."""


def noise_words(setting: Setting, outcome: Outcome, after: float, stated: bool) -> str:
    """How large and how coloured the best hypothesis' residual is."""
    colour = [w for w in outcome.judge.whiteners if w.order]
    level = f"{np.sqrt(after):.2f} times the {'stated' if stated else 'local'} level"
    words = f"residual of the best hypothesis at {level}"
    if any(w.slow for w in colour):
        words += ", coloured (it falls with a power of the frequency)"
    elif colour:
        words += f", coloured (autoregressive, order up to {max(w.order for w in colour)})"
    if any(w.root is not None for w in outcome.judge.whiteners):
        path = "errors of the recorded path or of rounding"
        error = path if setting.model.is_time_model else "a smooth calibration error"
        words += f", with {error} in its covariance"
    return words
