"""What a recording has of its own, fitted to it alone: the shared parameters are held."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modelgen.fit.experiment import Experiment
from modelgen.fit.gauss_newton import GaussNewton
from modelgen.fit.multistart import MultiStart
from modelgen.fit.problem import Problem, Vector

FAR = 2.0
"""Times the residual of other recordings from which a fit has probably ended in a wrong valley: an
oscillation that is a period off, an angle beyond the top."""
STARTS = 24


def fitted_alone(
    e: Experiment, own: NDArray[np.bool_], theta: Vector, others: Sequence[Vector], level: float
) -> Vector:
    """θ (p,) of one recording with those of its parameters fitted that are its `own` (p,).

    They start as in other recordings: from `theta`, and where that leaves far more than the mean square
    `level` that those leave, from `others` (own parameters only) and from all over their bounds.
    """
    if not own.any():
        return theta
    problem = e.problem_of(own, theta)
    ends = [GaussNewton().run(problem)]
    limit = FAR**2 * level * problem.n_data
    if not ends[0].value <= limit:
        ends += [GaussNewton().run(problem, np.clip(x, problem.lower, problem.upper)) for x in others]
    if not min(x.value for x in ends) <= limit:
        ends.append(MultiStart(starts=STARTS).run(_bounded(problem, others), seed=0))
    full = theta.copy()
    full[own] = min(ends, key=lambda x: x.value).theta
    return full


def _bounded(problem: Problem, others: Sequence[Vector]) -> Problem:
    """`problem` with finite bounds: where it has none, as far as ten times the values of other recordings, or
    1 where all of them are 0."""
    far = 10 * np.max(np.abs([problem.start, *others]), axis=0)
    far = np.where(far > 0, far, 1.0)
    low = np.where(np.isfinite(problem.lower), problem.lower, -far)
    return replace(problem, lower=low, upper=np.where(np.isfinite(problem.upper), problem.upper, far))
