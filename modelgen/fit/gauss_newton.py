"""Gauss–Newton with Levenberg's damping and bounds: the local method of choice for a fit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelgen.fit.constrained import constrained
from modelgen.fit.method import Method, Outcome, Reason, Seed, Watch, at_least
from modelgen.fit.problem import FLAT, ZERO, Matrix, Normal, Problem, Vector

TINY = 1e-12  # a hardly damped step, relative to the value, that changes nothing any more


@dataclass(frozen=True)
class GaussNewton(Method):
    """Levenberg–Marquardt on the normal equations; each step is the damped quadratic's minimum within bounds.

    The damping follows Nielsen (1999, IMM-REP-1999-05), in units of the Jacobian's column norms (Moré 1978),
    so that parameters need no scaling: an affine change of any of them changes no step. A parameter on a
    bound with the gradient pushing out is frozen; one that a step would take across is put on the bound and
    the others are solved again. tol: relative decrease of r·r at which it stops. damping: the first one, in
    units of the scaled normal matrix (whose diagonal is 1).
    """

    max_iter: int = 500
    tol: float = 1e-13
    damping: float = 0.1

    def __post_init__(self) -> None:
        at_least(1, max_iter=self.max_iter)
        at_least(0, tol=self.tol, damping=self.damping)

    @property
    def text(self) -> str:
        return "Gauss–Newton with Levenberg–Marquardt damping"

    def _search(self, problem: Problem, start: Vector, watch: Watch, seed: Seed) -> Outcome:
        def descend(evaluate: Callable[[Vector], Normal], theta: Vector) -> tuple[Vector, Reason]:
            return self._descend(problem, evaluate, theta, watch)

        if problem.constraints:
            return watch.outcome(constrained(problem, watch.normal_equations, start, descend))
        return watch.outcome(descend(watch.normal_equations, start)[1])

    def _descend(
        self, problem: Problem, evaluate: Callable[[Vector], Normal], theta: Vector, watch: Watch
    ) -> tuple[Vector, Reason]:
        """From θ to the minimum within the bounds of what `evaluate` gives, and why it ended there."""
        lower, upper = problem.lower, problem.upper
        f, g, A = evaluate(theta)
        if not np.isfinite(f):
            return theta, Reason.NOT_FINITE
        floor, mu, nu = ZERO * f, self.damping, 2.0
        D = _scale(A, np.zeros_like(theta))
        for iteration in range(1, self.max_iter + 1):
            free = ~((theta <= lower) & (g > 0) | (theta >= upper) & (g < 0))
            slope = float(np.max(np.abs(g / D)[free], initial=0.0))
            if f <= floor or slope <= 1e-14 * np.sqrt(f):
                return theta, Reason.CONVERGED
            low, high = lower - theta, upper - theta
            step = _step(A, g, D, mu, free, low, high)
            trial = np.where(step <= low, lower, np.where(step >= high, upper, theta + step))
            predicted = -float(step @ (2 * g + A @ step))
            f_new, g_new, A_new = evaluate(trial)
            decrease = f - f_new
            watch.tell(iteration, self.max_iter)
            gain = decrease / predicted if predicted > 0 else -1.0
            if decrease > 0 and gain > 1e-4:
                small = max(decrease, predicted) <= self.tol * f and gain > 0.25
                theta, f, g, A = trial, f_new, g_new, A_new
                D = _scale(A, D)
                mu, nu = max(mu * max(1 / 3, 1 - (2 * gain - 1) ** 3), 1e-16), 2.0
                if small:
                    return theta, Reason.CONVERGED
            elif mu < 1 and np.all(np.abs(step) <= TINY * (np.abs(theta) + 1e-4 * problem.width)):
                return theta, Reason.CONVERGED
            elif 0 <= predicted <= 1e-15 * f:
                # the gain left drowns in rounding; a slope here means that value and gradient disagree
                flat = problem.promise(theta, (f, g, A)) <= FLAT
                return theta, Reason.CONVERGED if flat else Reason.STALLED
            else:
                mu, nu = mu * nu, 2 * nu
        return theta, Reason.BUDGET


def _scale(A: Matrix, before: Vector) -> Vector:
    """The largest column norms of J so far (p,): what goes blind stays damped; 1 for what does nothing."""
    D = np.maximum(np.sqrt(A.diagonal()), before)
    D[D == 0] = 1.0
    return D


def _step(
    A: Matrix, g: Vector, D: Vector, mu: float, free: NDArray[np.bool_], low: Vector, high: Vector
) -> Vector:
    """Minimise g·s + ½ s·(A + μ D²)·s within [low, high], which holds 0: the primal active-set method.

    free: where to begin. Each round goes to the first bound in the way and holds it, or arrives and lets go
    of the bound that pushes inward most; the model falls in every round, so a step is never uphill.
    """
    step, held = np.zeros_like(g), ~free
    for _ in range(4 * g.size):
        index = np.flatnonzero(~held)
        d = D[index]
        M = A[index[:, None], index] / (d[:, None] * d)
        M.flat[:: index.size + 1] += mu
        way = _solve(M, -(g + A[:, held] @ step[held])[index] / d) / d - step[index]
        wall = np.where(way < 0, low[index], high[index])
        part = np.where(way != 0, (wall - step[index]) / np.where(way != 0, way, 1), np.inf)
        if part.min(initial=1) < 1:
            first = int(np.argmin(part))
            step[index] += part[first] * way
            step[index[first]], held[index[first]] = wall[first], True
            continue
        step[index] += way
        if not held.any():
            break
        slope = (g + A @ step) / D + mu * D * step
        inward = np.where(held, np.where(step <= low, -slope, slope), 0)
        if inward.max() <= 1e-12 * np.abs(g / D).max():
            break
        held[np.argmax(inward)] = False
    return step


def _solve(M: Matrix, b: Vector) -> Vector:
    """M x = b for a scaled M; the least x where rounding has made M singular."""
    try:
        return np.asarray(np.linalg.solve(M, b), dtype=float)
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.lstsq(M, b, rcond=1e-15)[0], dtype=float)
