"""How much an objective says of each parameter: basins, variance by Sobol', Fisher information."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from modelgen.errors import ToolError
from modelgen.fit.problem import Matrix, Problem, Vector
from modelgen.fit.pso import uniform

Array = np.ndarray[Any, np.dtype[Any]]


@dataclass(frozen=True, eq=False)
class Cloud:
    """Every point that a search tried: θ (m, p) and the root mean square of its residual (m,)."""

    names: tuple[str, ...]
    theta: Matrix
    rms: Vector

    def width(self, name: str, level: float) -> float:
        """Extent of the points with an rms of at most `level`, NaN for none: ΔF of the GMM paper's Fig. 11.

        It grows towards the basin's width with the number of points.
        """
        inside = self.theta[self.rms <= level, self.names.index(name)]
        return float(np.ptp(inside)) if inside.size else np.nan


def recorded(problem: Problem, samples: int) -> tuple[Problem, list[tuple[Matrix, Vector]]]:
    """The same problem, and a list that fills with all points that are evaluated and their rms.

    It is no longer searched in C, where nobody sees the points.
    """
    seen: list[tuple[Matrix, Vector]] = []

    def batch(thetas: Matrix) -> Vector:
        values = problem.values(thetas)
        seen.append((thetas.copy(), np.sqrt(values / samples)))
        return values

    return replace(problem, objective_batch=batch, compiled=None), seen


def cloud(problem: Problem, seen: Sequence[tuple[Matrix, Vector]]) -> Cloud:
    """All points of a recorded search."""
    return Cloud(problem.names, np.vstack([t for t, _ in seen]), np.concatenate([v for _, v in seen]))


@dataclass(frozen=True)
class Share:
    """Of one parameter: the part of the objective's variance over the box that it makes alone (first), and
    with all others (total)."""

    name: str
    first: float
    total: float


def sobol(problem: Problem, n: int = 4096, seed: int = 0) -> tuple[Share, ...]:
    """Sobol' indices of ln r·r over the box of the bounds (Saltelli et al. 2010, by SALib).

    n: base samples, a power of two; n (p + 2) evaluations. Raises ToolError where SALib is not installed.
    """
    try:
        from SALib.analyze.sobol import analyze
        from SALib.sample.sobol import sample
    except ImportError:
        raise ToolError("Sobol' indices need SALib: pip install 'modelgen[sensitivity]'") from None
    p = len(problem.names)
    box = {"num_vars": p, "names": list(problem.names), "bounds": [[0.0, 1.0]] * p}
    u = np.asarray(sample(box, n, calc_second_order=False, seed=seed))
    low, high = problem.box()
    y = np.log(problem.values(uniform(low, high, u)))
    y = np.where(np.isfinite(y), y, np.nanmax(y[np.isfinite(y)]))
    found = analyze(box, y, calc_second_order=False, seed=seed)
    return tuple(
        Share(*row)
        for row in zip(problem.names, map(float, found["S1"]), map(float, found["ST"]), strict=True)
    )


@dataclass(frozen=True, eq=False)
class Fisher:
    """Relative standard deviations by the information of the data alone.

    together (p,): with all others unknown; alone (p,): with all others known. Their ratio says how much of
    what the data say of a parameter is lost to the others. weakest (p,): the combination that the data say
    least of, relative parameters, of unit length, and its standard deviation.
    """

    names: tuple[str, ...]
    together: Vector
    alone: Vector
    weakest: Vector
    weakest_std: float


def fisher(problem: Problem, theta: ArrayLike, noise: float) -> Fisher:
    """Information JᵀJ/noise² at θ (p,), relative to |θ|; noise: the standard deviation of the residual."""
    theta = np.asarray(theta, dtype=float)
    _, J = problem.jacobian(theta)
    _, s, Vt = np.linalg.svd(J * np.abs(theta) / noise, full_matrices=False)
    together = np.sqrt(np.sum((Vt.T / s) ** 2, axis=1))
    alone = 1 / np.linalg.norm(J * np.abs(theta) / noise, axis=0)
    return Fisher(problem.names, together, alone, Vt[-1], float(1 / s[-1]))
