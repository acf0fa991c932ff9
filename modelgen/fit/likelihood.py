"""Profile likelihood: an interval that follows curvature and bounds, where the linear one does not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike

from modelgen.errors import InputError, did_you_mean
from modelgen.fit.gauss_newton import GaussNewton
from modelgen.fit.method import Method, Reason
from modelgen.fit.problem import Problem, Vector
from modelgen.fit.uncertainty import assess

CLOSE = 1e-3  # relative error of an end's depth √Δ
DOUBLINGS = 12  # how often the search for an end widens before it is called open


@dataclass(frozen=True)
class Profile:
    """Interval [low, high] of one parameter at confidence `level`, and the points (k,) that were tried with
    their r·r.

    low_open, high_open: the interval ends at a bound of the parameter, or at ±inf, where the data still allow
    it. better: θ with a smaller r·r than the given optimum's, if one turned up.
    """

    name: str
    level: float
    low: float
    high: float
    low_open: bool
    high_open: bool
    points: Vector
    values: Vector
    better: Vector | None = None


def profile(
    problem: Problem,
    index: int | str,
    optimum: ArrayLike,
    *,
    level: float = 0.95,
    estimate_noise: bool = False,
    method: Method | None = None,
) -> Profile:
    """Where min over the others of r·r exceeds its optimum by the quantile of χ² with one degree of freedom
    (Wilks).

    index: the parameter, by place or name. optimum: θ (p,). estimate_noise: measure the excess in units of
    s² = r·r/(n − p). method: for the others, Gauss–Newton if not given.
    Raises InputError for an unknown parameter.
    """
    if isinstance(index, str):
        if index not in problem.names:
            raise InputError(f"unknown parameter '{index}'{did_you_mean(index, problem.names)}")
        index = problem.names.index(index)
    if not 0 < level < 1:
        raise InputError(f"level = {level:g}: a confidence between 0 and 1 is wanted, such as 0.95")
    optimum = np.asarray(optimum, dtype=float)
    known = assess(problem, optimum, estimate_noise=estimate_noise)
    search = _Search(problem, index, optimum, known.noise or 1.0, method or GaussNewton())
    depth = NormalDist().inv_cdf((1 + level) / 2)
    guess = known.std[index] if np.isfinite(known.std[index]) else 0.1 * problem.width[index]
    low, low_open = search.end(-guess * depth, depth, float(problem.lower[index]))
    high, high_open = search.end(guess * depth, depth, float(problem.upper[index]))
    points = sorted(search.seen)
    return Profile(
        problem.names[index], level, low, high, low_open, high_open,
        np.array(points), np.array([search.seen[x] for x in points]), search.better,
    )  # fmt: skip


def basin(
    problem: Problem, index: int | str, optimum: ArrayLike, value: float, method: Method | None = None
) -> tuple[float, float]:
    """Where min over the others of r·r, from `optimum` (p,) outwards to both sides, reaches `value`.

    An end is the parameter's bound where that is reached before. Raises InputError for an unknown parameter,
    and where the optimum itself is not below `value`.
    """
    if isinstance(index, str):
        if index not in problem.names:
            raise InputError(f"unknown parameter '{index}'{did_you_mean(index, problem.names)}")
        index = problem.names.index(index)
    optimum = np.asarray(optimum, dtype=float)
    search = _Search(problem, index, optimum, 1.0, method or GaussNewton())
    if not value > search.least:
        raise InputError(f"the optimum's r·r = {search.least:g} is not below {value:g}: there is no basin")
    depth = float(np.sqrt(value - search.least))
    std = assess(problem, optimum).std[index]
    step = depth * std if np.isfinite(std) and std > 0 else 0.1 * problem.width[index]
    low, _ = search.end(-step, depth, float(problem.lower[index]))
    high, _ = search.end(step, depth, float(problem.upper[index]))
    return low, high


class _Search:
    """Profile points of one parameter: each refit of the others starts from the nearest one done."""

    def __init__(self, problem: Problem, index: int, optimum: Vector, noise: float, method: Method) -> None:
        self.problem, self.index, self.noise, self.method = problem, index, noise, method
        self.optimum = float(optimum[index])
        self.least = problem.value(optimum)
        self.better: Vector | None = None
        self.seen = {self.optimum: self.least}
        self._others = {self.optimum: np.delete(optimum, index)}

    def depth(self, x: float) -> float:
        """√Δ at θ_index = x, in standard deviations: about linear in x, which the search makes use of."""
        value, others = self._refit(x)
        self.seen[x], self._others[x] = value, others
        if value < self.least * (1 - 1e-9) and (
            self.better is None or value < self.problem.value(self.better)
        ):
            self.better = np.insert(others, self.index, x)
        return float(np.sqrt(max(value - self.least, 0.0))) / self.noise

    def end(self, step: float, depth: float, bound: float) -> tuple[float, bool]:
        """Where √Δ reaches `depth`, going by `step` at first, and whether the bound comes before."""
        inner, outer, step = self.optimum, self.optimum, step
        for _ in range(DOUBLINGS):
            outer = max(outer + step, bound) if step < 0 else min(outer + step, bound)
            found = self.depth(outer)
            if found >= depth:
                crossing = _crossing(self.depth, inner, outer, found, depth, self._known(inner))
                return float(crossing), False
            if outer == bound:
                return bound, True
            inner, step = outer, 2 * step
        return bound, True

    def _known(self, x: float) -> float:
        return float(np.sqrt(max(self.seen[x] - self.least, 0.0))) / self.noise

    def _refit(self, x: float) -> tuple[float, Vector]:
        nearest = min(self._others, key=lambda done: abs(done - x))
        others = self._others[nearest]
        if not others.size:
            return self.problem.value([x]), others
        outcome = self.method.run(self.problem.fixed(self.index, x), others)
        if outcome.reason is Reason.INTERRUPTED:  # half a profile is no use to anyone
            raise KeyboardInterrupt
        return outcome.value, outcome.theta


def _crossing(
    depth_at: Callable[[float], float], inner: float, outer: float, high: float, depth: float, low: float
) -> float:
    """The x from `inner` (depth `low`) to `outer` (depth `high`) with the wanted depth: Illinois method."""
    a, fa, b, fb = inner, low - depth, outer, min(high, 1e6 * depth) - depth
    for _ in range(60):
        x = b - fb * (b - a) / (fb - fa)
        fx = min(depth_at(x), 1e6 * depth) - depth
        if abs(fx) <= CLOSE * depth or abs(b - a) <= 1e-12 * abs(b):
            return x
        if fx * fb < 0:
            a, fa = b, fb
        else:
            fa /= 2
        b, fb = x, fx
    return b
