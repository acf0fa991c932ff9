"""Claims from recordings over time, looked at again with all that errors of the path may do.

A hysteresis remembers where its path has turned. Noise moves those turns, and corners lie between the
samples: errors that last as long as that memory and look like physics. Under the covariance that they have if
the base is right, claims stand or fall as a whole (errors in variables, to first order): which of them is
right, the recordings as they are tell better.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.refit import Fit, Judge, plain_white
from modelgen.diagnose.hypotheses.setting import ALARM, Outcome, Setting
from modelgen.diagnose.noise.recolour import gross, recolour
from modelgen.diagnose.noise.replica import on
from modelgen.diagnose.search.claim import gains
from modelgen.diagnose.search.fewer import parts
from modelgen.diagnose.search.search import white_judge
from modelgen.fit.path import likeliest
from modelgen.fit.series import Series

DOUBTFUL = 2.0
"""Times the noise that a base may leave which is right: how large errors of a path are is known roughly."""
SLIGHT = 0.02
"""Share of the variance, in the mean, up to which errors of the path are left aside."""
FIRST = 6
"""Accounts that are looked at again."""
SURE = 10 * ALARM
"""ΔBIC that leaves no doubt of a claim."""
ROUNDS = 2
"""Times that an account is fitted under the errors that it makes itself."""


def kept_along_path(setting: Setting, outcome: Outcome) -> tuple[Setting, Outcome] | None:
    """The base as the verdict, where it leaves but noise along its own likeliest path and nothing gains
    enough under the errors of that path; None where claims stand, or those errors are slight or explain
    nothing."""
    if not setting.model.is_time_model or outcome.judge.temper > 1.0:
        return None
    if _doubtless(setting, outcome.base):
        return None
    base, less = outcome.base, setting
    for _ in range(ROUNDS):
        series = _with_path(setting, base)
        if series is None:
            return None
        less = replace(setting, series=series, base=None)
        judge = white_judge(series)
        base = judge.fit(on(base.hypothesis, series), [base.theta])
        if len(outcome.best.ids) == 1 and _sure(judge, base, outcome.best, series):
            return None
    if gross(less, base.white):
        return None
    found = _judged(less, judge, base, outcome)
    return None if found.best.ids else (less, found)


def _doubtless(s: Setting, base: Fit) -> bool:
    """Whether a base leaves more than any noise: than what is stated or, where nobody did, than what a colour
    makes of the scatter between neighbours."""
    found = zip(s.series, plain_white(base), base.white, strict=True)
    left = [np.mean(e**2) if x.stated else min(np.mean(e**2), np.mean(c**2)) for x, e, c in found]
    return any(x > DOUBTFUL**2 for x in left)


def _judged(s: Setting, judge: Judge, base: Fit, outcome: Outcome) -> Outcome:
    """The claims of `outcome` beyond the base, under `judge`."""
    tried = sorted((f for f in outcome.tried if f.ids), key=lambda f: f.bic)[:FIRST]
    if outcome.best.ids and not any(f.hypothesis.key == outcome.best.hypothesis.key for f in tried):
        tried = [outcome.best, *tried]
    fits = [_anew(judge, base, f, s.series) for f in tried]
    best = next((f for f in fits if f.hypothesis.key == outcome.best.hypothesis.key), base)
    fits += parts(s, judge, best) if len(best.ids) > 1 else []
    judge, base, fits = recolour(s, judge, base, fits)
    chosen = base
    for size in range(1, len(best.ids) + 1):
        first = min((f for f in fits if len(f.ids) == size), key=lambda f: f.bic, default=None)
        if first is not None and gains(s, judge, base, chosen, first) and _allowed(chosen, first):
            chosen = first
    return Outcome(judge, base, chosen, tuple(fits), outcome.blind)


def _sure(judge: Judge, base: Fit, best: Fit, series: Sequence[Series]) -> bool:
    """Whether `best` as it is, not fitted again, is by far ahead of the base."""
    seen = judge.look(on(best.hypothesis, series), best.theta)
    return base.bic - seen.bic > SURE and _allowed(base, seen)


def _allowed(old: Fit, new: Fit) -> bool:
    """Whether `new` gains enough with no less noise than what is allowed for.

    How large errors of a path are is known roughly: what they leave free says nothing of the noise elsewhere.
    """
    price = (new.parameters - old.parameters) * float(np.log(effective(new.white)))
    return old.chi2 - new.chi2 - price > ALARM * (len(new.ids) - len(old.ids))


def _anew(judge: Judge, base: Fit, f: Fit, series: Sequence[Series]) -> Fit:
    """`f` fitted over other series of the same recordings, also from the parameters of the base."""
    h = on(f.hypothesis, series)
    known = {n: float(x) for n, x in zip(h.names, f.theta, strict=True) if n not in base.hypothesis.names}
    return judge.fit(h, [f.theta, h.place(base.hypothesis, base.theta, known)])


def _with_path(setting: Setting, account: Fit) -> tuple[Series, ...] | None:
    """The series along the path that force and motion together say if an account is right, with the noise
    that errors of the recorded path make in its output; None where these are slight."""
    e, found, more = account.hypothesis.experiment, [], 0.0
    for k, recording in enumerate(setting.case.fit):
        path = likeliest(replace(e, series=setting.series), setting.case, recording, account.theta, k)
        if path is None:
            return None
        found.append(path[0])
        more = max(more, path[1])
    return tuple(found) if more > SLIGHT else None
