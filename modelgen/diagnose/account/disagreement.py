"""Recordings that disagree: what effects can't explain may be a device that changed from one to the next."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modelgen.diagnose.hypotheses.hypothesis import Hypothesis, make_hypotheses
from modelgen.diagnose.hypotheses.refit import Fit, mean_square, plain_white
from modelgen.diagnose.hypotheses.setting import ALARM, Outcome, Setting
from modelgen.fit.series import Array

FAR = 1.5
"""Times the noise that the best hypothesis leaves from which recordings are asked whether they agree."""
MOST = 3
"""Parameters that may have changed."""


def disagreement_note(setting: Setting, outcome: Outcome, best: Fit, scale: float) -> tuple[str, ...]:
    """Which parameters, were they of their own in each recording, would explain more than the named effects
    do; nothing where these leave little more than the noise (`scale`)."""
    if len(setting.series) < 2 or _left(best) < FAR * scale:
        return ()
    fit, own = outcome.base, tuple[str, ...]()
    for _ in range(MOST):
        freed = min(_freed(setting, outcome, fit, own), key=lambda x: x[0].bic, default=None)
        if freed is None or freed[0].bic > fit.bic - ALARM:
            break
        fit, own = freed
    if not own or fit.bic > best.bic - ALARM:
        return ()
    names = ", ".join(own)
    return (
        f"recordings disagree: with {names} of {'its' if len(own) == 1 else 'their'} own in each "
        f"(per_recording) the model as it is leaves {_left(fit) / scale:.1f} times the noise, "
        f"with what is named here {_left(best) / scale:.1f}: something changed from one to the next",
    )


def _left(fit: Fit) -> float:
    return float(np.sqrt(mean_square(plain_white(fit))))


def _freed(
    setting: Setting, outcome: Outcome, fit: Fit, own: tuple[str, ...]
) -> list[tuple[Fit, tuple[str, ...]]]:
    """The base with one parameter more of its own in each recording, for each that all share."""
    layout, found = outcome.base.hypothesis.experiment.layout, []
    for name in layout.names:
        if name in own or name not in layout.wrt:
            continue
        more = (*own, name)
        case = replace(setting.case, per_recording=(*setting.case.per_recording, *more))
        for h in make_hypotheses(setting.model, case, setting.series, [()]):
            found.append((outcome.judge.fit(h, [_spread(h, fit)]), more))
    return found


def _spread(h: Hypothesis, fit: Fit) -> Array:
    """The values of a fit, where recordings share them there also for each."""
    values = dict(zip(fit.hypothesis.names, fit.theta.tolist(), strict=True))
    return np.array([values.get(n, values.get(n.partition("[")[0])) for n in h.names], dtype=float)
