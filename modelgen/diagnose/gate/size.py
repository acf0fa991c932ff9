"""How much is left of a fit, and whether that is more than noise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.gate.rivals import LEFT
from modelgen.diagnose.gate.wholly import FAR
from modelgen.diagnose.hypotheses.refit import mean_square
from modelgen.diagnose.hypotheses.setting import Outcome, Setting
from modelgen.diagnose.noise.follows import ignores_motion
from modelgen.diagnose.noise.noise import FITS, first_order, fitful, scatter
from modelgen.diagnose.noise.recolour import GROSS_ESTIMATED, beyond
from modelgen.diagnose.noise.replica import motion_matters
from modelgen.diagnose.search.claim import CREDIBLE
from modelgen.fit.series import Array


def roughness(setting: Setting, plain: Sequence[Array]) -> float:
    """The mean square of what neighbours scatter of residuals."""
    pairs = zip(setting.series, plain, strict=True)
    return float(np.mean([scatter(s, x) ** 2 for s, e in pairs for x in e]))


def is_gross(setting: Setting, plain: Sequence[Array], stated: bool, scatter: float) -> bool:
    """Whether residuals are far larger than noise that scatters so, and no noise that nobody stated."""
    rms = np.sqrt(mean_square(plain))
    if stated or (setting.model.is_time_model and any(map(fitful, plain))):
        return bool(rms > FITS * beyond(scatter))
    # a level that was estimated of the base's residual holds what the base misses from sample to sample
    limit = GROSS_ESTIMATED * min(1.0, scatter)
    if rms <= limit or all(first_order(e, len(plain)) for e in plain):
        return False
    return not ignores_motion(setting.model, setting.series, plain)


def is_far(outcome: Outcome, left: Leftover, after: float, scatter: float, told: bool) -> bool:
    """Whether what the best hypothesis leaves is more than noise: of a noise that is independent, as errors
    of a motion are not, and whose level nobody has `told`, more than the scatter between neighbours."""
    if left.gain > LEFT or outcome.judge.temper > 1.0:
        return True
    whiteners = outcome.judge.whiteners
    independent = all(w.order == 0 and w.root is None for w in whiteners) and not motion_matters(whiteners)
    return not told and independent and after > FAR**2 * scatter


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


def floor_of(after: float, scatter: float, count: int, stated: bool, far: bool) -> float:
    """Mean square of whitened residuals that is noise.

    Far from the data: the scatter between neighbours, not below what is stated. Else what is stated, where
    the best hypothesis' residual agrees with it (or too few samples tell); else that residual.
    """
    if far:
        return min(after, max(scatter, 1.0 if stated else 0.0))
    return 1.0 if stated and (count < 60 or 1 / CREDIBLE**2 < after < CREDIBLE**2) else after
