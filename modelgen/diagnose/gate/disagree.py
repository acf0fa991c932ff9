"""Recordings that disagree: what effects can't explain may be a device that changed from one to the next."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modelgen.diagnose.gate.gate import Gate
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.gate.rivals import LEFT
from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.hypothesis import Hypothesis, make_hypotheses
from modelgen.diagnose.hypotheses.refit import Fit, mean_square, plain_white
from modelgen.diagnose.hypotheses.setting import ALARM, Outcome, Setting
from modelgen.effects.motion import nearest_port
from modelgen.fit.series import Array

MOST = 3
"""Parameters that may have changed."""
ODDS = 20.0
"""How sure it is at most, over its being one of the catalogue after all."""
EXPLAINS = 1.25
"""Times the noise up to which what the model leaves of each recording alone is no more than that."""
SEEN = 2.0
"""Standard deviations of χ² beyond the noise that named effects must leave for another account."""


def freed(setting: Setting, outcome: Outcome) -> tuple[Fit, tuple[str, ...]]:
    """The base with the parameters that gain by it of their own in each recording, and their names."""
    fit, own = outcome.base, tuple[str, ...]()
    for _ in range(MOST):
        more = min(_one_more(setting, outcome, fit, own), key=lambda x: x[0].bic, default=None)
        if more is None or more[0].bic > fit.bic - ALARM:
            break
        fit, own = more
    return fit, own


def disagreeing(setting: Setting, outcome: Outcome, gate: Gate) -> Gate | None:
    """The gate for sweeps under known conditions that the model explains one by one and not together, where
    that is far better than all that the catalogue holds, and than what describes what it doesn't: something
    depends on those conditions."""
    differs, found = _differing(setting), gate.fit or outcome.best
    n = effective(found.white)
    beyond = (mean_square(plain_white(found)) / gate.floor - 1) * np.sqrt(n / 2)
    missing = gate.unknown or bool(outcome.best.ids)
    if not differs or not missing or beyond < SEEN:
        return None
    fit, own = freed(setting, outcome)
    lead = found.bic - fit.bic
    if not own or lead < LEFT or _left(fit) > EXPLAINS * gate.scale:
        return None
    names = " and ".join(own)
    says = (
        f"it explains each recording with a value of its own of {names}, and not all with one: what differs "
        f"between them, {' and '.join(differs)}, changes {'it' if len(own) == 1 else 'them'}, or the device "
        "has changed meanwhile"
    )
    port = nearest_port(setting.model, own[0])
    left = Leftover(lead, outcome.base.chi2 - fit.chi2, port.name if port else "", says)
    return replace(
        gate, unknown=True, leftover=left, probability=ODDS / (1 + ODDS), notes=(), fit=fit, tied=None
    )


def disagreement_note(setting: Setting, outcome: Outcome, best: Fit, scale: float) -> tuple[str, ...]:
    """Which parameters, were they of their own in each recording, would explain more than the named effects
    do; nothing where these leave little more than the noise (`scale`)."""
    if len(setting.series) < 2 or _left(best) < FAR * scale:
        return ()
    fit, own = freed(setting, outcome)
    if not own or fit.bic > best.bic - ALARM:
        return ()
    names = ", ".join(own)
    return (
        f"recordings disagree: with {names} of {'its' if len(own) == 1 else 'their'} own in each "
        f"(per_recording) the model as it is leaves {_left(fit) / scale:.1f} times the noise, "
        f"with what is named here {_left(best) / scale:.1f}: something changed from one to the next",
    )


FAR = 1.5
"""Times the noise that the best hypothesis leaves from which recordings are asked whether they agree."""


def _differing(setting: Setting) -> tuple[str, ...]:
    """Names of what is known to differ between sweeps."""
    first, *others = (dict(s.constants) for s in setting.series)
    if setting.model.is_time_model:
        return ()
    return tuple(n for n in first if any(o.get(n) != first[n] for o in others))


def _left(fit: Fit) -> float:
    return float(np.sqrt(mean_square(plain_white(fit))))


def _one_more(
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
