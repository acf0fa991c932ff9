"""What no catalogue holds, weighed against the named effects with coloured noise of its own beside each."""

from __future__ import annotations

from modelgen.diagnose.gate.describe import described
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.gate.unlisted import cheaper, is_unlisted
from modelgen.diagnose.hypotheses.open_shapes import fairly_priced
from modelgen.diagnose.hypotheses.ranking import WRONG, standings
from modelgen.diagnose.hypotheses.refit import Fit
from modelgen.diagnose.hypotheses.setting import ALARM, CLOSE, Outcome, Setting
from modelgen.diagnose.noise.recolour import own_colours

LEFT = 20.0
"""ΔBIC that a description without a catalogue must gain before the rest counts as physics."""


RARER, LIKELIER = 4.0, 0.5
"""ΔBIC that it must be ahead of named effects whose probability is more than this, beside it: physics of a
catalogue is about five times as common."""


def outdone(setting: Setting, outcome: Outcome) -> tuple[Fit, float] | None:
    """What no catalogue holds but explains more than the named effects, coloured noise of its own beside
    each: that has peaks, too. Each further effect has to gain as much as to be claimed."""
    rival = cheaper(outcome)
    if rival is None or _as_far(outcome, rival[0]):
        return None
    if outcome.best.ids and rival[1] < RARER:
        fair = fairly_priced(setting, outcome, exempt=is_unlisted)
        if standings(fair)[0].probability > LIKELIER:
            return None
    best, other = own_colours(setting, outcome.judge, (outcome.best, rival[0]))
    count = len(outcome.best.ids)
    return rival if best - other > (ALARM * (1 - count) if count else CLOSE) else None


def _as_far(outcome: Outcome, rival: Fit) -> bool:
    """Whether what no catalogue holds is not much nearer to recordings that neither it nor named effects
    account for."""
    named = outcome.judge.temper > 1.0 and bool(outcome.best.ids)
    return named and outcome.best.chi2 < WRONG**2 * rival.chi2


def nearer(setting: Setting, outcome: Outcome, left: Leftover, times: float = WRONG) -> bool:
    """Whether terms that describe what the best hypothesis leaves are on their own so many times nearer to
    the recordings than it is."""
    terms = described(setting, outcome, left)
    return terms is not None and times**2 * terms.chi2 < outcome.best.chi2


def by_odd_noise(setting: Setting, outcome: Outcome) -> bool:
    """Whether one effect gains little where what no catalogue holds gains far more and is yet but coloured
    noise: in noise that is so odd, little is no evidence."""
    rival = cheaper(outcome) if len(outcome.best.ids) == 1 else None
    if rival is None or rival[1] < LEFT:
        return False
    fits = (outcome.base, outcome.best, rival[0])
    base, best, other = own_colours(setting, outcome.judge, fits)
    return best - other < CLOSE and base - best < 2 * ALARM


def as_leftover(outcome: Outcome, fit: Fit, gain: float) -> Leftover:
    """A fit of what no catalogue holds, as a description."""
    a = fit.hypothesis.added[0]
    return Leftover(gain, outcome.base.chi2 - fit.chi2, a.port.name, a.effect.says)
