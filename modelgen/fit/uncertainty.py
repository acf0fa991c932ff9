"""What the data say about each parameter at the optimum, and which combinations they leave open."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modelgen.fit.problem import Matrix, Problem, Vector

BLIND = 1e-9  # a singular value of the column-scaled J, relative to the largest, below which it is rounding
TAKES_PART = 1e-5  # share of a parameter in an open direction, in units of the columns' norms, that counts
ON_BOUND = 1e-3  # standard deviations from a bound within which a parameter lies on it


@dataclass(frozen=True)
class Uncertainty:
    """Linearised statistics at an optimum θ of p parameters.

    covariance, correlation: (p, p), std: (p,), in the parameters' units; NaN for what the data do not
    determine. rank: number of combinations that they do. at_bound: a value on its bound, where std describes
    the data alone, not the truncated estimate. undetermined: sentences. noise: the factor that scales the
    stated noise (1 when it is taken as stated). residual: r (n,) and jacobian: J (n, p) at θ, for what comes
    after.
    """

    covariance: Matrix
    std: Vector
    correlation: Matrix
    rank: int
    determined: NDArray[np.bool_]
    at_bound: NDArray[np.bool_]
    undetermined: tuple[str, ...]
    noise: float
    residual: Vector
    jacobian: Matrix


def assess(problem: Problem, theta: ArrayLike, *, estimate_noise: bool = False) -> Uncertainty:
    """Covariance (JᵀJ)⁻¹ from the whitened J at the optimum θ, by an SVD with scaled columns.

    estimate_noise: multiply it by s² = r·r/(n − rank), for residuals whose noise level isn't known; NaN for n
    = rank. A direction counts as open when its singular value is rounding (1e-9 of the largest), or when
    moving along it across the whole of the bounds changes r by less than the noise.
    """
    theta = np.asarray(theta, dtype=float)
    r, J = problem.jacobian(theta)
    norms = np.linalg.norm(J, axis=0)
    scale = np.where(norms > 0, norms, 1.0)
    open_, inverse = _split(J / scale, problem, scale)
    rank = theta.size - open_.shape[1]
    noise = 1.0
    if estimate_noise:
        noise = float(np.sqrt(r @ r / (r.size - rank))) if r.size > rank else np.nan
    determined = np.linalg.norm(open_, axis=1) <= TAKES_PART
    covariance = noise**2 * inverse / np.outer(scale, scale)
    covariance[~determined], covariance[:, ~determined] = np.nan, np.nan
    std = np.sqrt(covariance.diagonal())
    correlation = covariance / np.outer(std, std)
    return Uncertainty(
        covariance=covariance,
        std=std,
        correlation=correlation,
        rank=rank,
        determined=determined,
        at_bound=problem.at_bound(theta, np.fmax(1e-9 * problem.width, ON_BOUND * std)),
        undetermined=_sentences(open_, scale, problem.names),
        noise=noise,
        residual=r,
        jacobian=J,
    )


def _split(unit: Matrix, problem: Problem, scale: Vector) -> tuple[Matrix, Matrix]:
    """The open directions (p, q), orthonormal, and the inverse of unitᵀ unit (p, p) on the others."""
    p = unit.shape[1]
    _, s, Vt = np.linalg.svd(unit, full_matrices=unit.shape[0] < p)
    s = np.append(s, np.zeros(p - s.size))
    # the longest way along a direction, θ = scale⁻¹ v t, that stays in the box of finite bounds
    span = (problem.upper - problem.lower) * scale
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = np.nanmin(np.where(Vt != 0, span / np.abs(Vt), np.inf), axis=1)
        seen = (s > BLIND * s[0]) & (s * reach >= 1)
    weight = np.where(seen, 1 / np.where(seen, s, 1) ** 2, 0)
    return Vt[~seen].T, (Vt.T * weight) @ Vt


def _sentences(open_: Matrix, scale: Vector, names: tuple[str, ...]) -> tuple[str, ...]:
    """One sentence for each set of parameters that open directions (p, q) tie together."""
    tied = np.abs(open_ @ open_.T) > TAKES_PART**2
    left = [i for i in range(len(names)) if tied[i, i]]
    said = []
    while left:
        group = [left[0]]
        for i in group:  # grows while it is walked: all that are tied, directly or not
            group += [j for j in left if tied[i, j] and j not in group]
        left = [i for i in left if i not in group]
        said.append(_sentence(open_[sorted(group)], scale[sorted(group)], [names[i] for i in sorted(group)]))
    return tuple(said)


def _sentence(open_: Matrix, scale: Vector, names: list[str]) -> str:
    """What the data leave open among `names`, whose open directions are the rows of `open_` (k, q)."""
    if len(names) == 1:
        return f"the data say nothing about {names[0]}"
    together = f"{', '.join(names[:-1])} and {names[-1]}"
    U, s, _ = np.linalg.svd(open_)
    rank = int(np.sum(s > TAKES_PART))
    if rank == len(names):
        return f"the data say nothing about {together}"
    known = _reduced(U[:, rank:].T) * scale
    combinations = [_combination(row, names) for row in known]
    return f"the data don't determine {together} apart: only {' and '.join(combinations)}"


def _reduced(rows: Matrix) -> Matrix:
    """Reduced row echelon form, so that each combination names few parameters."""
    rows = rows.copy()
    for k in range(len(rows)):
        j = int(np.argmax(np.abs(rows[k]) > 0.1 * np.abs(rows[k:]).max()))
        best = k + int(np.argmax(np.abs(rows[k:, j])))
        rows[[k, best]] = rows[[best, k]]
        rows[k] /= rows[k, j]
        others = np.arange(len(rows)) != k
        rows[others] -= np.outer(rows[others, j], rows[k])
    return np.where(np.abs(rows) < TAKES_PART, 0, rows)


def _combination(row: Vector, names: list[str]) -> str:
    """A linear combination in words, the first coefficient 1: "R_f + 4.8e14*S33_im"."""
    used = np.flatnonzero(row)
    text = names[used[0]]
    for j in used[1:]:
        c = row[j] / row[used[0]]
        size = f"{abs(c):.3g}".replace("e+", "e")
        factor = "" if size == "1" else f"{size}*"
        text += f" {'-' if c < 0 else '+'} {factor}{names[j]}"
    return text
