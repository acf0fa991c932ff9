"""A least-squares problem which says what it can give, so that an optimiser asks for what it needs.

The objective is r·r, r the whitened residual: with the noise well stated it is χ² and about n at the optimum.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modelgen.errors import InputError

if TYPE_CHECKING:
    from modelgen.fit.compiled import Compiled
    from modelgen.fit.segments import Segments

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Normal = tuple[float, Vector, Matrix]

WIDE = 100.0  # positive bounds further apart than this factor are searched by the logarithm
ZERO = 1e-28  # r·r, relative to the start's, that is rounding
FLAT = 1e-10  # part of r·r: if no more is to be gained, a search that cannot go on has converged
REACH = 10.0  # without bounds, a search box reaches this many |start| to either side


@dataclass(frozen=True)
class Inequality:
    """A condition g(θ) ≥ 0, such as passivity: `value` gives g, `gradient` its p derivatives."""

    says: str
    value: Callable[[Vector], float]
    gradient: Callable[[Vector], Vector]


@dataclass(frozen=True)
class Problem:
    """Find θ (p,) within bounds such that residual(θ) (n,) has the least sum of squares.

    names, units: of the p free parameters; lower, upper: bounds, may be infinite; start: NaN means the centre
    of the bounds (the geometric one where they are positive and more than two decades apart).
    residual: θ → r (n,), whitened and real. The rest is optional, and `provides` names what is there:
    linearise: θ → r, J = ∂r/∂θ (n, p).  normal: θ → r·r, Jᵀr, JᵀJ.  objective_batch: (m, p) → (m,) sums r·r.
    hessian: θ → Hessian of ½ r·r (p, p).  segments: m → the recordings of a time model, cut into m each.
    constraints: conditions g(θ) ≥ 0.
    Values that are not finite count as +inf. Raises InputError, which names the parameter.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    lower: Vector
    upper: Vector
    start: Vector
    residual: Callable[[Vector], Vector]
    linearise: Callable[[Vector], tuple[Vector, Matrix]] | None = None
    normal: Callable[[Vector], Normal] | None = None
    objective_batch: Callable[[Matrix], Vector] | None = None
    hessian: Callable[[Vector], Matrix] | None = None
    segments: Callable[[int], Segments] | None = None
    constraints: tuple[Inequality, ...] = ()
    compiled: Compiled | None = None
    _: KW_ONLY
    n_data: int

    def __post_init__(self) -> None:
        for name in ("lower", "upper", "start"):
            array = np.array(getattr(self, name), dtype=float)
            if array.shape != (len(self.names),):
                raise InputError(f"{name}: {len(self.names)} values wanted, found shape {array.shape}")
            object.__setattr__(self, name, array)
        if len(self.units) != len(self.names):
            raise InputError(f"{len(self.names)} parameters but {len(self.units)} units")
        for row in zip(self.names, self.lower, self.upper, self.start, strict=True):
            _check(*row)
        if self.n_data < len(self.names):
            names = ", ".join(self.names)
            raise InputError(
                f"{self.n_data} data values cannot determine {len(self.names)} parameters ({names})"
            )
        centre = np.where(np.isnan(self.start), _centre(self.lower, self.upper), self.start)
        object.__setattr__(self, "start", centre)
        for array in (self.lower, self.upper, self.start):
            array.setflags(write=False)

    @property
    def provides(self) -> frozenset[str]:
        """Which of the optional routes are there, by name."""
        routes = ("linearise", "normal", "objective_batch", "hessian", "segments")
        return frozenset(["residual", *(name for name in routes if getattr(self, name) is not None)])

    @cached_property
    def width(self) -> Vector:
        """The affine scale of each parameter (p,): the span of its bounds, else |start|, else 1.

        Bounds that are searched by the logarithm say nothing of the scale: there it is |start|, too.
        """
        span = self.upper - self.lower
        own = np.where(self.start != 0, np.abs(self.start), 1.0)
        return np.where(np.isfinite(span) & ~wide(self.lower, self.upper), span, own)

    def value(self, theta: ArrayLike) -> float:
        """r·r at θ (p,); +inf where it is not finite."""
        return float(self.values(np.asarray(theta, dtype=float)[None, :])[0])

    def values(self, thetas: ArrayLike) -> Vector:
        """r·r at each row of θ (m, p), in one call if `objective_batch` is given; +inf where not finite."""
        rows = np.ascontiguousarray(thetas, dtype=float)
        if self.objective_batch is not None:
            sums = np.asarray(self.objective_batch(rows), dtype=float)
        else:
            sums = np.array([_square(self.residual(row)) for row in rows])
        return np.where(np.isfinite(sums), sums, np.inf)

    def jacobian(self, theta: ArrayLike) -> tuple[Vector, Matrix]:
        """r (n,) and J (n, p): `linearise`, or central differences that stay within the bounds."""
        theta = np.asarray(theta, dtype=float)
        return self.linearise(theta) if self.linearise is not None else self._differences(theta)

    def normal_equations(self, theta: Vector) -> Normal:
        """r·r, Jᵀr (p,) and JᵀJ (p, p) by the cheapest route; r·r = +inf where anything is not finite."""
        if self.normal is not None:
            value, gradient, matrix = self.normal(theta)
        else:
            r, J = self.jacobian(theta)
            value, gradient, matrix = float(r @ r), J.T @ r, J.T @ J
        # a sum is finite only if every term is, and costs less than asking each
        total = value + gradient.sum() + matrix.sum()
        return (float(value) if np.isfinite(total) else np.inf), gradient, matrix

    def violation(self, theta: Vector) -> float:
        """How far θ is outside the constraints: the largest -g/‖∇g‖ in units of `width`, 0 inside."""
        worst = 0.0
        for g in self.constraints:
            value = g.value(theta)
            if not value >= 0:
                worst = max(worst, -value / (float(np.linalg.norm(g.gradient(theta) * self.width)) or 1.0))
        return worst if worst == worst else np.inf

    def promise(self, theta: Vector, normal: Normal) -> float:
        """The part of r·r that one more Gauss–Newton step promises to remove: 0 at an optimum."""
        f, g, A = normal
        near = 1e-6 * self.width
        held = (theta - self.lower <= near) & (g > 0) | (self.upper - theta <= near) & (g < 0)
        norms = np.sqrt(A.diagonal())
        free = ~held & (norms > 0)
        unit = A[np.ix_(free, free)] / np.outer(norms[free], norms[free])
        slope = g[free] / norms[free]
        return float(slope @ np.linalg.lstsq(unit, slope, rcond=1e-12)[0]) / f if f > 0 else 0.0

    def at_bound(self, theta: Vector, tolerance: Vector | None = None) -> NDArray[np.bool_]:
        """Which parameters (p,) lie on a bound, to `tolerance` (p,), else to 1e-9 of their width."""
        near = 1e-9 * self.width if tolerance is None else tolerance
        return (theta - self.lower <= near) | (self.upper - theta <= near)

    def box(self) -> tuple[Vector, Vector]:
        """A finite search box: the bounds, and where one is infinite start ± 10 |start|.

        Raises InputError, naming the parameter, where there is neither a bound nor a start other than 0.
        """
        for name, lo, hi, start in zip(self.names, self.lower, self.upper, self.start, strict=True):
            if start == 0 and not (np.isfinite(lo) and np.isfinite(hi)):
                raise InputError(
                    f"parameter '{name}': a search needs two finite bounds or a start other than 0, "
                    f"found bounds [{lo:g}, {hi:g}] and start 0"
                )
        reach = REACH * np.abs(self.start)
        low = np.where(np.isfinite(self.lower), self.lower, self.start - reach)
        high = np.where(np.isfinite(self.upper), self.upper, self.start + reach)
        return low, high

    def fixed(self, index: int, value: float) -> Problem:
        """The same problem with parameter `index` held at `value`: one parameter less. Needs p ≥ 2."""
        keep = np.arange(len(self.names)) != index

        def whole(rest: Vector) -> Vector:
            theta = np.empty((*rest.shape[:-1], keep.size))
            theta[..., keep], theta[..., index] = rest, value
            return theta

        def linearise(rest: Vector) -> tuple[Vector, Matrix]:
            r, J = self.jacobian(whole(rest))
            return r, J[:, keep]

        def normal(rest: Vector) -> Normal:
            f, g, A = self.normal_equations(whole(rest))
            return f, g[keep], A[np.ix_(keep, keep)]

        def hold(g: Inequality) -> Inequality:
            return Inequality(
                g.says, lambda rest: g.value(whole(rest)), lambda rest: g.gradient(whole(rest))[keep]
            )

        pick = [i for i in range(keep.size) if i != index]
        batch, hessian = self.objective_batch, self.hessian
        return replace(
            self,
            names=tuple(self.names[i] for i in pick),
            units=tuple(self.units[i] for i in pick),
            lower=self.lower[keep],
            upper=self.upper[keep],
            start=self.start[keep],
            residual=lambda rest: self.residual(whole(rest)),
            linearise=linearise if self.linearise is not None else None,
            normal=normal if self.normal is not None else None,
            objective_batch=batch and (lambda rest: batch(whole(rest))),
            hessian=hessian and (lambda rest: hessian(whole(rest))[np.ix_(keep, keep)]),
            segments=None,
            constraints=tuple(map(hold, self.constraints)),
            compiled=self.compiled and self.compiled.fixed(index, value),
        )

    def _differences(self, theta: Vector) -> tuple[Vector, Matrix]:
        # steps of ε^(1/3) balance rounding and the cubic term; 1e-4 of the width stands in for a value near 0
        steps = np.cbrt(np.finfo(float).eps) * np.maximum(np.abs(theta), 1e-4 * self.width)
        r = np.asarray(self.residual(theta), dtype=float)
        J = np.empty((r.size, theta.size))
        for j, step in enumerate(steps):
            ends = []
            for side in (-step, step):
                shifted = theta.copy()
                shifted[j] = np.clip(theta[j] + side, self.lower[j], self.upper[j])
                value = np.asarray(self.residual(shifted), dtype=float)
                ends.append((shifted[j], value) if np.isfinite(value).all() else (theta[j], r))
            (a, ra), (b, rb) = ends
            J[:, j] = (rb - ra) / (b - a) if b > a else np.nan
        return r, J


def _check(name: str, lower: float, upper: float, start: float) -> None:
    """Raise InputError when the bounds or the start of one parameter make no sense."""
    if np.isnan(lower) or np.isnan(upper):
        raise InputError(f"parameter '{name}': a bound is not a number")
    if lower > upper:
        raise InputError(f"parameter '{name}': bounds [{lower:g}, {upper:g}] are reversed")
    if lower == upper:
        raise InputError(f"parameter '{name}': both bounds are {lower:g}; make it a constant instead")
    if start < lower or start > upper or np.isinf(start):
        raise InputError(f"parameter '{name}': start {start:g} is outside its bounds [{lower:g}, {upper:g}]")
    if np.isnan(start) and not (np.isfinite(lower) and np.isfinite(upper)):
        raise InputError(
            f"parameter '{name}': a start or finite bounds are wanted, found [{lower:g}, {upper:g}]"
        )


def wide(lower: Vector, upper: Vector) -> NDArray[np.bool_]:
    """Which bounds are positive and more than two decades apart."""
    return (lower > 0) & (upper > WIDE * lower)


def _centre(lower: Vector, upper: Vector) -> Vector:
    positive = wide(lower, upper)
    with np.errstate(invalid="ignore"):
        geometric = np.sqrt(np.where(positive, lower, 1)) * np.sqrt(np.where(positive, upper, 1))
        return np.where(positive, geometric, lower / 2 + upper / 2)


def _square(r: Vector) -> float:
    r = np.asarray(r, dtype=float)
    return float(r @ r)
