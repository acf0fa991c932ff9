"""One step of dx/dt = f: schemes on lists of numbers or expressions, whatever adds and multiplies.

Time runs from s = 0 to 1 over the step of length H, in `steps` equal parts, of which the k-th is made.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

Vector = list[Any]
Rates = Callable[[Any, Vector], Vector]


class Slopes(NamedTuple):
    """f (n,), its Jacobian by x (n, n), and its derivative by s (n,)."""

    rate: Vector
    jacobian: Sequence[Sequence[Any]]
    by_s: Vector


def runge_kutta(f: Rates, x: Vector, H: Any, steps: int, k: Any) -> Vector:
    """The classical scheme of order 4."""
    h = H / steps
    slopes: list[Vector] = []
    for c in (0, 0.5, 0.5, 1):
        here = [v + c * h * d for v, d in zip(x, slopes[-1], strict=True)] if slopes else x
        slopes.append(f((k + c) / steps, here))
    return [v + h / 6 * (a + 2 * b + 2 * c + d) for v, a, b, c, d in zip(x, *slopes, strict=True)]


def rosenbrock(
    f: Rates, slopes: Callable[[Any, Vector], Slopes], x: Vector, H: Any, steps: int, k: Any
) -> Vector:
    """RODAS3: order 3, four stages, L-stable, linear equations alone (Sandu et al. 1997, Atmos. Environ. 31).

    (I/γ − h J) u_i = h f(s_i, x + Σ a_ij u_j) + Σ c_ij u_j + γ_i h² ∂f/∂t, γ = 1/2.
    """
    h = H / steps
    first = slopes(k / steps, x)
    rows = [[-h * d for d in row] for row in first.jacobian]
    solve = _elimination([[v + 2 * (i == j) for j, v in enumerate(row)] for i, row in enumerate(rows)])
    drift = [h / (2 * steps) * d for d in first.by_s]
    a = solve([h * v + d for v, d in zip(first.rate, drift, strict=True)])
    b = solve([h * v + 4 * p + 3 * d for v, p, d in zip(first.rate, a, drift, strict=True)])
    end = (k + 1) / steps
    late = f(end, [v + 2 * p for v, p in zip(x, a, strict=True)])
    c = solve([h * v + p - q for v, p, q in zip(late, a, b, strict=True)])
    near = [v + 2 * p + r for v, p, r in zip(x, a, c, strict=True)]
    late = f(end, near)
    d = solve([h * v + p - q - 8 * r / 3 for v, p, q, r in zip(late, a, b, c, strict=True)])
    return [v + r for v, r in zip(near, d, strict=True)]


def _elimination(A: list[Vector]) -> Callable[[Vector], Vector]:
    """Solves A u = b by LU without pivots: 2 I − h J needs none where J is of a decaying system."""
    n = len(A)
    A = [list(row) for row in A]
    for k in range(n):
        for i in range(k + 1, n):
            A[i][k] = A[i][k] / A[k][k]
            for j in range(k + 1, n):
                A[i][j] = A[i][j] - A[i][k] * A[k][j]

    def solve(b: Vector) -> Vector:
        u = list(b)
        for i in range(n):
            for j in range(i):
                u[i] = u[i] - A[i][j] * u[j]
        for i in reversed(range(n)):
            for j in range(i + 1, n):
                u[i] = u[i] - A[i][j] * u[j]
            u[i] = u[i] / A[i][i]
        return u

    return solve
