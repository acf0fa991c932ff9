"""Least-squares problems with a known answer, for the tests of the estimator."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from modelgen.fit import Problem

T = np.linspace(0, 2, 40)


def problem(
    names: str, lower: Any, upper: Any, start: Any, residual: Callable[..., Any], **more: Any
) -> Problem:
    """A Problem with dimensionless parameters, named by a string of words; scalar bounds hold for all."""
    words = tuple(names.split())
    full = [np.broadcast_to(np.asarray(a, float), len(words)) for a in (lower, upper, start)]
    at = np.where(np.isnan(full[2]), np.nan_to_num(full[0]) / 2 + np.nan_to_num(full[1]) / 2, full[2])
    return Problem(words, ("1",) * len(words), *full, residual, **({"n_data": residual(at).size} | more))


def linear(A: Any, b: Any, lower: Any, upper: Any, start: Any, **more: Any) -> Problem:
    """r = A θ − b, with its Jacobian."""
    A, b = np.asarray(A, float), np.asarray(b, float)
    names = " ".join(f"x{i}" for i in range(A.shape[1]))
    return problem(
        names, lower, upper, start, lambda x: A @ x - b, linearise=lambda x: (A @ x - b, A), **more
    )


def rosenbrock(lower: Any = -5, upper: Any = 5, start: Sequence[float] = (-1.2, 1.0)) -> Problem:
    """Rosenbrock's valley as least squares: optimum (1, 1), value 0."""

    def r(x: Any) -> Any:
        return np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]])

    def J(x: Any) -> Any:
        return np.array([[-20 * x[0], 10.0], [-1.0, 0.0]])

    def hessian(x: Any) -> Any:
        return J(x).T @ J(x) + r(x)[0] * np.array([[-20.0, 0.0], [0.0, 0.0]])

    return problem("a b", lower, upper, start, r, linearise=lambda x: (r(x), J(x)), hessian=hessian)


def decay(
    data: Any, sigma: float, *, batch: bool = True, lower: Any = 0, upper: Any = (10, 10, 5)
) -> Problem:
    """data = a exp(−k t) + c over T, white noise of known sigma."""

    def r(x: Any) -> Any:
        return (x[0] * np.exp(-x[1] * T) + x[2] - data) / sigma

    def J(x: Any) -> Any:
        e = np.exp(-x[1] * T)
        return np.column_stack([e, -x[0] * T * e, np.ones_like(T)]) / sigma

    def sums(X: Any) -> Any:
        return (((X[:, :1] * np.exp(-X[:, 1:2] * T) + X[:, 2:] - data) / sigma) ** 2).sum(axis=1)

    return problem(
        "a k c",
        lower,
        upper,
        (1, 1, 1),
        r,
        linearise=lambda x: (r(x), J(x)),
        objective_batch=sums if batch else None,
    )
