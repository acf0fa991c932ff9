"""Whether an instrument's smooth error turns with the phase of what it measures.

A wrong factor, Z (1 + ε), does; an error that adds to the two readings of a bridge, Z + |Z| ε, doesn't. Both
are "relative", and across a resonance, where the phase of Z turns by itself, each is rough to the other.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from modelgen.diagnose.hypotheses.refit import Fit
from modelgen.fit.series import Series

CLEAR = 10.0
"""By how much χ² must fall before an error is taken not to turn: a factor is the rule."""
MISSING = 0.1
"""And by this share of what is beyond the noise: missing physics, too, looks smaller in one of the frames."""


def framed(series: Sequence[Series], fit: Fit) -> tuple[Series, ...]:
    """Sweeps in the frame in which a smooth error that is stated of them leaves the base a smaller χ².

    The covariances of both frames have one determinant, so that χ² is the whole likelihood; the fit's
    parameters follow at first order.
    """
    if not any(s.whitener.root is not None and s.measure == "complex" for s in series):
        return tuple(series)
    still = tuple(s.unturned() if s.measure == "complex" else s for s in series)
    turning, fixed = (_left(fit, x) for x in (series, still))
    beyond = max(0.0, fixed - sum(s.data.size for s in series))
    return still if fixed < turning - CLEAR - MISSING * beyond else tuple(series)


def _left(fit: Fit, series: Sequence[Series]) -> float:
    """χ² after a step of the parameters."""
    r, J = fit.hypothesis.experiment.linearised(fit.theta, [s.whitener for s in series])
    q, _ = np.linalg.qr(J / np.maximum(np.linalg.norm(J, axis=0), 1e-300))
    left = r - q @ (q.T @ r)
    return float(left @ left)
