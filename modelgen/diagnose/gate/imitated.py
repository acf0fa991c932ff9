"""What named effects imitate: what no catalogue holds, and is a far better account of the recordings."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from modelgen.diagnose.gate.describe import described
from modelgen.diagnose.gate.generic import Remains, misreading
from modelgen.diagnose.gate.growing import growing
from modelgen.diagnose.gate.in_time import sudden
from modelgen.diagnose.gate.instrument import lead
from modelgen.diagnose.gate.leftover import NOTHING, Leftover
from modelgen.diagnose.gate.narrow import narrow
from modelgen.diagnose.gate.rivals import LEFT
from modelgen.diagnose.hypotheses.refit import Fit, misfit
from modelgen.diagnose.hypotheses.setting import ALARM, CLOSE, Outcome, Setting
from modelgen.diagnose.search.claim import own_gain

BETTER = 0.9
"""A description without a catalogue is taken before named effects that gain less than this share of its
evidence."""
NEARER = 2.0
"""Far from the recordings, an error of how they were taken leaves less than a half of what named effects do,
in rms, where it is told in their place."""


@dataclass(frozen=True)
class Imitated:
    """What named effects imitate, or None; what is said beside them; and an error of how sweeps were taken
    that would do as well, with as its gain by how much it is ahead of them."""

    other: Leftover | None
    notes: tuple[str, ...] = ()
    error: Leftover | None = None


def imitating(remains: Remains, left: Leftover, oddity: Leftover | None) -> Imitated:
    """What named effects imitate, if anything; else what is said of outliers that have a common cause, and of
    an error that would do as well."""
    outcome = remains.outcome
    if not outcome.best.hypothesis.added:
        found = growing(outcome)
        where = remains.likeliest(remains.of_base).port if found else ""
        return Imitated(found and replace(found, port=where))
    error, ahead = _misread(remains)
    least = CLOSE - ALARM * (len(outcome.best.ids) - 1)  # each effect more has to gain as much to be claimed
    if ahead > least:
        return Imitated(error)
    other = _imitated(remains, left) or narrow(outcome)
    if other is not None:
        return Imitated(other)
    notes: tuple[str, ...] = () if oddity is None else (oddity.says,)
    if ahead < -CLOSE:
        return Imitated(None, notes)
    return Imitated(None, (*notes, f"as well it may be {error.says}"), replace(error, gain=ahead))


def _misread(remains: Remains) -> tuple[Leftover, float]:
    """The likeliest error of how sweeps were taken, and by how much it is ahead of named effects."""
    outcome = remains.outcome
    error = NOTHING if remains.setting.model.is_time_model else misreading(remains.of_base)
    if not error.weights:
        return error, -np.inf
    far = outcome.judge.temper > 1.0
    if far and NEARER**2 * (misfit(outcome.base) - error.chi2) > misfit(outcome.best):
        return error, -np.inf
    return error, lead(outcome.judge, outcome.best, error)


def _imitated(remains: Remains, left: Leftover) -> Leftover | None:
    """What no catalogue holds but fits sweeps better than the named effects do, and by far; or over time what
    is pumped or jumps."""
    setting, outcome = remains.setting, remains.outcome
    if outcome.judge.temper > 1.0:
        return None
    if setting.model.is_time_model:
        return _ahead(*sudden(setting.model, outcome.judge, outcome.base, outcome.best))
    whole = remains.likeliest(remains.of_base)
    found = _ahead(whole, gained(setting, outcome, outcome.best))
    return whole if found is None and _outdescribed(setting, outcome, left, whole) else found


def _outdescribed(setting: Setting, outcome: Outcome, left: Leftover, whole: Leftover) -> bool:
    """Whether named effects leave what is no noise, and terms that describe the `whole` without them are,
    fitted and with the price of all their numbers, ahead."""
    if left.gain < LEFT:
        return False
    terms = described(setting, outcome, whole)
    return terms is not None and outcome.best.bic - terms.bic > LEFT


def _ahead(x: Leftover, named: float) -> Leftover | None:
    """A description, if it gains far more than named effects do beside it."""
    return x if max(named, 0.0) < min(x.gain - LEFT, BETTER * x.gain) else None


def gained(setting: Setting, outcome: Outcome, f: Fit) -> float:
    """What a fit gains on the base, as a description of sweeps would: of tables, each with its own noise."""
    if all(s.measure == "real" for s in setting.series):
        return own_gain(setting, outcome.judge, outcome.base, f)
    return outcome.base.bic - f.bic
