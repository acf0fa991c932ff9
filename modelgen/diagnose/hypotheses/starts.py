"""Where fits of a base begin."""

from __future__ import annotations

import numpy as np

from modelgen.diagnose.hypotheses.hypothesis import Hypothesis, centre
from modelgen.diagnose.hypotheses.own_units import in_own_units
from modelgen.fit.whitener import Array


def base_starts(h: Hypothesis, seed: int, count: int = 8) -> list[Array]:
    """Starts for the base: its defaults, ones in the recordings' own units, points spread over the bounds.

    Parameters with bounds many decades apart, or none, are spread by the logarithm about both in turn.
    """
    p = h.experiment.layout.parameters
    defaults = np.array([q.default if q.default is not None else centre(q) for q in p])
    own = in_own_units(h.experiment, defaults)
    rng = np.random.default_rng(seed)
    starts = [defaults, own]
    for turn in range(count - len(starts)):
        default = starts[turn % 2]
        x = default.copy()
        for k, q in enumerate(p):
            low, high = q.bounds
            if not np.isfinite(high - low):
                x[k] = default[k] * float(np.exp(rng.normal(0, 1.0))) if default[k] else default[k]
            elif (low > 0 and high / low > 100) or (low == 0 and high > 100 * default[k] > 0):
                x[k] = np.clip(default[k] * float(np.exp(rng.normal(0, 2.0))), low, high)
            else:
                x[k] = rng.uniform(low, high)
        starts.append(x)
    return starts[:count]
