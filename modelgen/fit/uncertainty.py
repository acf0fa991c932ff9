"""What the data say about each parameter at the optimum, and which combinations they leave open."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modelgen.errors import InputError
from modelgen.fit.problem import Matrix, Problem, Vector

Places = NDArray[np.intp]
Product = Callable[[Places, Vector], str]

BLIND = 1e-9  # a singular value of the column-scaled J, relative to the largest, below which it is rounding
ROUNDING = (
    1e-5  # share of a parameter in an open direction, in units of the columns' norms, below which it is none
)
MINOR = 0.1  # the same for directions that are merely wider than the bounds, in units of these
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

    A direction is open when its singular value is rounding (1e-9 of the largest). A parameter whose standard
    deviation exceeds the whole span of its bounds counts as undetermined too. estimate_noise: multiply by
    s² = r·r/(n − rank), for residuals whose noise level isn't known; NaN for n = rank.
    Raises InputError, naming the parameter, where a derivative is not finite.
    """
    theta = np.asarray(theta, dtype=float)
    r, J = problem.jacobian(theta)
    scale = column_norms(problem.names, J)
    blind, inverse = split(J / scale)
    free = r.size - theta.size + blind.shape[1]
    noise = (float(np.sqrt(r @ r / free)) if free > 0 else np.nan) if estimate_noise else 1.0
    covariance = noise**2 * inverse / np.outer(scale, scale)
    span = problem.upper - problem.lower
    judged = judge(covariance, blind, scale, span, problem.names, partial(product, problem, theta, J))
    std = np.sqrt(judged.covariance.diagonal())
    with np.errstate(invalid="ignore"):  # a residual of 0 leaves no deviation to relate
        correlation = judged.covariance / np.outer(std, std)
    # a box may be far wider than what is known of a small number within it
    near = np.fmax(np.fmin(1e-9 * problem.width, std), ON_BOUND * std)
    return Uncertainty(
        covariance=judged.covariance,
        std=std,
        correlation=correlation,
        rank=judged.rank,
        determined=judged.determined,
        at_bound=problem.at_bound(theta, near),
        undetermined=judged.undetermined,
        noise=noise,
        residual=r,
        jacobian=J,
    )


@dataclass(frozen=True)
class Judged:
    """What is determined of p parameters: fields as in `Uncertainty`."""

    covariance: Matrix
    determined: NDArray[np.bool_]
    rank: int
    undetermined: tuple[str, ...]


def judge(
    covariance: Matrix, blind: Matrix, scale: Vector, span: Vector, names: tuple[str, ...], powers: Product
) -> Judged:
    """`covariance` (p, p) without what is not determined: what the open directions `blind` (p, q), of
    scale·θ, reach, and what is wider than the `span` (p,) of its bounds.

    powers: the places of parameters and a combination of them, as what product it is, or "".
    """
    seen = np.linalg.norm(blind, axis=1) <= ROUNDING
    weak = np.flatnonzero(seen & (np.sqrt(covariance.diagonal()) > span))
    vague = _vague(covariance, span, weak)
    said = _sentences(blind, scale, names, ROUNDING, powers)
    said += _sentences(vague, 1 / span, names, MINOR, lambda *_: "", " within the bounds")
    determined = seen.copy()
    determined[weak] = False
    known = np.where(np.outer(determined, determined), covariance, np.nan)
    return Judged(known, determined, len(names) - blind.shape[1] - vague.shape[1], said)


def column_norms(names: Sequence[str], J: Matrix) -> Vector:
    """Norms of the columns (p,), 1 for those of zeros. Raises InputError, naming the parameter, for one that
    is not finite."""
    norms = np.linalg.norm(J, axis=0)
    for name, norm in zip(names, norms, strict=True):
        if not np.isfinite(norm):
            raise InputError(f"parameter '{name}': the model's derivative is not finite at the optimum")
    return np.where(norms > 0, norms, 1.0)


def split(unit: Matrix) -> tuple[Matrix, Matrix]:
    """The open directions (p, q), orthonormal, and the inverse of unitᵀ unit (p, p) on the others."""
    p = unit.shape[1]
    if not p:
        return np.zeros((0, 0)), np.zeros((0, 0))
    _, s, Vt = np.linalg.svd(unit, full_matrices=unit.shape[0] < p)
    s = np.append(s, np.zeros(p - s.size))
    seen = s > BLIND * s[0]
    weight = np.where(seen, 1 / np.where(seen, s, 1) ** 2, 0)
    return Vt[~seen].T, (Vt.T * weight) @ Vt


def _vague(covariance: Matrix, span: Vector, weak: Places) -> Matrix:
    """Directions (p, q) among the parameters at `weak`, in units of `span`, wider than the bounds' box."""
    spread, axes = np.linalg.eigh((covariance / np.outer(span, span))[np.ix_(weak, weak)])
    directions = np.zeros((span.size, int(np.sum(spread > 1))))
    directions[weak] = axes[:, spread > 1]
    return directions


def _sentences(
    open_: Matrix, scale: Vector, names: tuple[str, ...], least: float, powers: Product, where: str = ""
) -> tuple[str, ...]:
    """One sentence for each set of parameters that the open directions scale·θ (p, q) tie together.

    least: the share of a parameter in a direction that counts.
    """
    tied = np.abs(open_ @ open_.T) > least**2
    left = [i for i in range(len(names)) if tied[i, i]]
    said = []
    while left:
        group = [left[0]]
        for i in group:  # grows while it is walked: all that are tied, directly or not
            group += [j for j in left if tied[i, j] and j not in group]
        left = [i for i in left if i not in group]
        said.append(_sentence(open_, scale, names, least, np.sort(group), powers, where))
    return tuple(said)


NOTHING = "the data say nothing about"
"""Begins what is said of parameters that the data don't show in any way."""


def _sentence(
    open_: Matrix,
    scale: Vector,
    names: tuple[str, ...],
    least: float,
    group: Places,
    powers: Product,
    where: str,
) -> str:
    """What the data leave open among the parameters at the places `group` (k,)."""
    own = [names[i] for i in group]
    together = " and ".join(filter(None, [", ".join(own[:-1]), own[-1]]))
    U, s, _ = np.linalg.svd(open_[group])
    rank = int(np.sum(s > least))
    if rank == len(own):
        return f"{NOTHING} {together}{where}"
    known = _reduced(U[:, rank:].T, least) * scale[group]
    used = known[0] != 0
    only = powers(group[used], known[0][used]) if len(known) == 1 else ""
    only = only or " and ".join(_combination(row, own) for row in known)
    return f"the data don't determine {together} apart{where}: only {only}"


def product(problem: Problem, theta: Vector, J: Matrix, index: Places, row: Vector) -> str:
    """ "a*b^2/c" if r depends on the parameters at `index` through that alone, "" if not.

    row: the coefficients of the linear combination that is determined near θ; times θ they are the exponents.
    """
    exponents = row * theta[index]
    if not np.all(exponents):
        return ""
    exponents *= np.sign(exponents[0]) / np.abs(exponents).min()
    if not np.allclose(exponents, np.round(exponents), rtol=1e-3, atol=0) or np.abs(exponents).max() > 4:
        return ""
    small = 1e-6 * np.linalg.norm(J[:, index] * theta[index], axis=0).max()
    base = theta.copy()
    base[index[0]] *= 1.1  # at the optimum itself the combination may be 0, which scaling does not change
    r = problem.residual(base)
    for j in range(1, index.size):
        moved = base.copy()
        moved[index[[0, j]]] *= np.exp(0.1 * np.array([exponents[j], -exponents[0]]))
        if not np.linalg.norm(problem.residual(moved) - r) <= small:
            return ""
    powers = [(problem.names[i], round(e)) for i, e in zip(index, exponents, strict=True)]
    return "".join(
        ("*" if e > 0 else "/") + name + (f"^{abs(e)}" if abs(e) > 1 else "") for name, e in powers
    )[1:]


def _reduced(rows: Matrix, least: float) -> Matrix:
    """Reduced row echelon form, so that each combination names few parameters."""
    rows = rows.copy()
    for k in range(len(rows)):
        j = int(np.argmax(np.abs(rows[k]) > 0.1 * np.abs(rows[k:]).max()))
        best = k + int(np.argmax(np.abs(rows[k:, j])))
        rows[[k, best]] = rows[[best, k]]
        rows[k] /= rows[k, j]
        others = np.arange(len(rows)) != k
        rows[others] -= np.outer(rows[others, j], rows[k])
    return np.where(np.abs(rows) < least, 0, rows)


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
