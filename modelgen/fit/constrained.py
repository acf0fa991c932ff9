"""Inequality constraints for a least-squares method that knows bounds only."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from modelgen.fit.method import FEASIBLE, Reason
from modelgen.fit.problem import Inequality, Normal, Problem, Vector

ROUNDS = 30
STIFFER = 10.0  # the weight grows by this factor when a round has not brought the violation well down

Evaluate = Callable[[Vector], Normal]
Descend = Callable[[Evaluate, Vector], tuple[Vector, Reason]]


def constrained(problem: Problem, evaluate: Evaluate, start: Vector, descend: Descend) -> Reason:
    """Augmented Lagrangian of Hestenes, Powell and Rockafellar: minimise r·r + w Σ min(0, g − λ/w)², round by
    round.

    After each round λ ← max(0, λ − w g). The added terms are squares, so each round is again a least-squares
    problem. Conditions are scaled by their slope at the start, in units of `problem.width`. `evaluate` gives
    r·r, Jᵀr, JᵀJ; `descend` minimises such a function from a point. Returns why the last round ended.
    """
    conditions = problem.constraints
    slopes = np.array([np.linalg.norm(g.gradient(start) * problem.width) for g in conditions])
    scale = 1 / np.where(slopes > 0, slopes, 1.0)
    multipliers = np.zeros(len(conditions))
    A = evaluate(start)[2]
    weight = float(np.mean(A.diagonal() * problem.width**2)) or 1.0
    theta, worst, reason = start, np.inf, Reason.BUDGET
    for _ in range(ROUNDS):
        theta, reason = descend(_augmented(evaluate, conditions, scale, multipliers, weight), theta)
        values = scale * [g.value(theta) for g in conditions]
        change = np.maximum(-multipliers, -weight * values)
        multipliers = multipliers + change
        gap = float(np.max(np.abs(change)) / weight)  # violated, or inactive though its multiplier is not 0
        if gap <= 0.1 * FEASIBLE or reason is Reason.NOT_FINITE:
            return reason
        if gap > 0.25 * worst:
            weight *= STIFFER
        worst = gap
    return Reason.INFEASIBLE if worst > FEASIBLE else reason


def _augmented(
    evaluate: Evaluate, conditions: tuple[Inequality, ...], scale: Vector, multipliers: Vector, weight: float
) -> Evaluate:
    """`evaluate` with the conditions' terms added to value, gradient and Gauss–Newton matrix."""

    def whole(theta: Vector) -> Normal:
        f, g, A = evaluate(theta)
        for condition, factor, multiplier in zip(conditions, scale, multipliers, strict=True):
            term = factor * condition.value(theta) - multiplier / weight
            if term < 0:
                slope = factor * condition.gradient(theta)
                f, g, A = f + weight * term**2, g + weight * term * slope, A + weight * np.outer(slope, slope)
        return f, g, A

    return whole
