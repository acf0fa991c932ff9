"""How much is left of a fit, and whether that is more than noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.gate.rivals import LEFT
from modelgen.diagnose.gate.wholly import FAR
from modelgen.diagnose.hypotheses.refit import mean_square, plain_white
from modelgen.diagnose.hypotheses.setting import Outcome, Setting, nearest
from modelgen.diagnose.noise.follows import ignores_motion
from modelgen.diagnose.noise.noise import FITS, first_order, fitful, scatter
from modelgen.diagnose.noise.recolour import GROSS_ESTIMATED, beyond
from modelgen.diagnose.noise.replica import motion_matters
from modelgen.diagnose.search.claim import CREDIBLE

FEWEST = 8
"""Samples that tell what neighbours scatter by."""
FEW = 60
"""Residuals that tell no level of their own."""


@dataclass(frozen=True)
class Size:
    """Mean squares of `count` residuals: of the base `before`, of the best hypothesis `after`, and by what
    neighbours scatter of these, `rough`, where there are `many` samples; `stated`: whether their noise is."""

    before: float
    after: float
    rough: float
    count: int
    many: bool
    stated: bool

    @classmethod
    def of(cls, setting: Setting, outcome: Outcome) -> Size:
        plain = plain_white(outcome.best)
        before = mean_square(plain_white(nearest(setting, outcome.base)))
        many = plain[0].shape[1] >= FEWEST
        pairs = zip(setting.series, plain, strict=True)
        rough = float(np.mean([scatter(s, x) ** 2 for s, e in pairs for x in e])) if many else 1.0
        stated = all(s.stated for s in setting.series)
        return cls(before, mean_square(plain), rough, sum(e.size for e in plain), many, stated)

    def floor(self, far: bool, after: float | None = None) -> float:
        """Mean square of whitened residuals that is noise, of those of the best hypothesis or `after`.

        Far from the data: the scatter between neighbours, not below what is stated. Else what is stated,
        where the residual agrees with it (or too few samples tell); else that residual.
        """
        after = self.after if after is None else after
        if far:
            return min(after, max(self.rough, 1.0 if self.stated else 0.0))
        agrees = self.count < FEW or 1 / CREDIBLE**2 < after < CREDIBLE**2
        return 1.0 if self.stated and agrees else after


def is_gross(setting: Setting, outcome: Outcome, size: Size) -> bool:
    """Whether residuals are far larger than noise that scatters as theirs, and no noise that nobody
    stated."""
    if not size.many or smooth_beside(setting, outcome):
        return False
    plain, scatters, rms = plain_white(outcome.best), float(np.sqrt(size.rough)), np.sqrt(size.after)
    if size.stated or (setting.model.is_time_model and any(map(fitful, plain))):
        return bool(rms > FITS * beyond(scatters))
    # a level that was estimated of the base's residual holds what the base misses from sample to sample
    limit = GROSS_ESTIMATED * min(1.0, scatters)
    if rms <= limit or all(first_order(e, len(plain)) for e in plain):
        return False
    return not ignores_motion(setting.model, setting.series, plain)


def is_far(outcome: Outcome, left: Leftover, size: Size) -> bool:
    """Whether what the best hypothesis leaves is more than noise: of a noise that is independent, as errors
    of a motion are not, and whose level nobody has told, more than the scatter between neighbours."""
    if left.gain > LEFT or outcome.judge.temper > 1.0:
        return True
    whiteners, told = outcome.judge.whiteners, size.stated or not size.many
    independent = all(w.order == 0 and w.root is None for w in whiteners) and not motion_matters(whiteners)
    return not told and independent and size.after > FAR**2 * size.rough


def smooth_beside(setting: Setting, outcome: Outcome) -> bool:
    """Whether a smooth error that nobody stated is counted as noise."""
    pairs = zip(setting.series, outcome.judge.whiteners, strict=True)
    return any(w.root is not None and s.whitener.root is None for s, w in pairs)


def reach(before: float, after: float, floor: float) -> float:
    """The part of the way to the recordings, in rms, that a hypothesis goes from the base's mean square
    residual to its own; 1 where that is little more than noise."""
    if after < FAR**2 * floor or before <= after:
        return 1.0
    return 1 - float(np.sqrt((after - floor) / (before - floor)))
