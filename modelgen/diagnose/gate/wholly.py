"""One function of what is known that accounts for all of the recordings, where named effects do not."""

from __future__ import annotations

import numpy as np

from modelgen.diagnose.gate.describe import described
from modelgen.diagnose.gate.generic import Remains, misreading
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.gate.rivals import LEFT
from modelgen.diagnose.hypotheses.functions import LEVEL
from modelgen.diagnose.hypotheses.refit import Fit, mean_square, misfit, plain_white
from modelgen.diagnose.noise.recolour import own_colours
from modelgen.diagnose.search.claim import CREDIBLE

FAR = 1.5
"""Times the noise that named effects leave from which they may be but the nearest that the catalogue has."""


def wholly_described(remains: Remains, floor: float, unknown: bool, after: float) -> Leftover | None:
    """Functions of displacement and speed, or an error of how a sweep is taken, that leave but noise, where
    even the best named effects, which leave `after` in the mean square, stay far from the recordings; the end
    of a channel's range also where these leave but noise, and it is nearer."""
    setting, outcome, best = remains.setting, remains.outcome, remains.outcome.best
    far = bool(best.ids) and (outcome.judge.temper > 1.0 or after > FAR**2 * floor)
    if not setting.model.is_time_model:
        far = far and outcome.judge.temper > 1.0
        return _by_the_instrument(remains, floor) if far or unknown else None
    if unknown or not best.ids:
        return None
    for left in _accounts(remains, far):
        terms = described(setting, outcome, left)
        if terms is None or not but_noise(terms, floor) or (not far and misfit(terms) > misfit(best)):
            continue
        lead = best.bic - terms.bic
        if outcome.judge.temper == 1.0:  # a colour that the named effects have left is no noise of the terms'
            named, other = own_colours(setting, outcome.judge, (best, terms))
            lead = named - other
        if lead > LEFT:
            return left
    return None


def _accounts(remains: Remains, far: bool) -> list[Leftover]:
    """What may account for all of a record over time: the ends of channels alone, unless named effects are
    far."""
    if not far:  # a channel's end is an account of one number; what smooth terms leave is likelier
        return [x for x in remains.ends_of_base if x.gain > LEFT]
    found = remains.of_base
    whole = remains.likeliest(found)
    return [whole, *(x for x in found if x.terms[:1] == (LEVEL,) and x.chi2 > whole.chi2)]


def but_noise(f: Fit, floor: float) -> bool:
    """Whether a fit leaves no more than noise of the mean square `floor`."""
    return mean_square(plain_white(f)) < CREDIBLE**2 * floor


def _by_the_instrument(remains: Remains, floor: float) -> Leftover | None:
    """An error of how sweeps are taken, if it leaves but noise."""
    base, found = remains.outcome.base, misreading(remains.of_base)
    count = sum(np.count_nonzero(e) for e in base.white)
    left = (misfit(base) - found.chi2) / max(count, 1)
    return found if found.gain > LEFT and left < CREDIBLE**2 * floor else None
