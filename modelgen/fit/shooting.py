"""Multiple shooting as a program for IPOPT: parameters and the states at each join, which must meet."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from modelgen.fit.guard import Guard, callback_class
from modelgen.fit.problem import Matrix, Problem, Vector

if TYPE_CHECKING:
    from modelgen.fit.method import Watch
    from modelgen.fit.segments import Leg, Segments

TRIES = 12  # steps that bring the states at a join near the data, at the first parameters
TIES = (1.0, 10.0, 100.0, 1000.0)
"""What a gap between two segments costs, in stages, before it must close: against r·r as the stage finds it,
and relative to the states' own size. From the data's own states the parameters are drawn to where the model
runs through, instead of falling, at bad parameters, to a path that joins and fits nothing."""
STAGE = 60  # iterations of a stage


def shoot(
    problem: Problem, cut: Segments, start: Vector, watch: Watch, max_iter: int, options: dict[str, Any]
) -> None:
    """Minimise r·r over θ and the states at all joins, from `start` (p,).

    Every θ on the way is tried on the uncut problem, too: the best of them is in `watch`.
    """
    nodes = first_states(cut, start)
    point = np.concatenate([start, nodes[np.flatnonzero(cut.joins)].ravel()])
    for tie in (*TIES, np.inf):
        left = min(STAGE, max_iter - watch.iterations)
        if left < 1:
            break
        stage = Shooting(problem, cut, point, tie, watch, max_iter)
        with stage.kept_together():
            point = stage.solve(options | {"ipopt.max_iter": left})


def first_states(cut: Segments, theta: Vector) -> Matrix:
    """States at each segment's start (segments, s): where the one before ends, brought nearer to the data."""
    found, end = np.zeros((len(cut.parts), cut.states)), np.zeros(cut.states)
    for k, joins in enumerate(cut.joins):
        if joins:
            found[k] = _nearer(cut, k, theta, end)
        end = cut.run(k, theta, found[k]).end
        end = np.where(np.isfinite(end), end, found[k])
    return found


def _nearer(cut: Segments, k: int, theta: Vector, start: Vector) -> Vector:
    """Levenberg–Marquardt steps in the states alone, as long as they help."""
    x, leg, mu = start, cut.run(k, theta, start), 1e-3
    for _ in range(TRIES):
        J, r = leg.residual_slope[:, -cut.states :], leg.residual
        A = J.T @ J
        if not (np.isfinite(A).all() and A.any()):
            break
        step = np.linalg.lstsq(A + mu * np.diag(A.diagonal()), -J.T @ r, rcond=1e-12)[0]
        tried = cut.run(k, theta, x + step)
        if float(tried.residual @ tried.residual) < float(r @ r):
            x, leg, mu = x + step, tried, mu / 10
        else:
            mu *= 10
    return x


class Shooting(Guard):
    """One stage, in x = (θ, states at the joins) less `center`, over their units; each point evaluated once.

    tie: the price of gaps; infinite where they must close.
    """

    def __init__(
        self, problem: Problem, cut: Segments, center: Vector, tie: float, watch: Watch, max_iter: int
    ) -> None:
        super().__init__()
        self.problem, self.cut, self.watch, self.max_iter = problem, cut, watch, max_iter
        self.join, self.p = np.flatnonzero(cut.joins), problem.start.size
        self.count, self.center, self.hard = self.join.size * cut.states, center, not np.isfinite(tie)
        size = np.sqrt(np.mean(center[self.p :].reshape(-1, cut.states) ** 2, axis=0))
        self.scale = np.tile(np.where(size > 0, size, 1.0), self.join.size)
        self.unit = np.concatenate([problem.width, self.scale])
        self.columns = list(self._columns())
        self._at: tuple[bytes, list[Leg]] | None = None
        self.factor = 1 / (sum(float(g.residual @ g.residual) for g in self._legs(center)) or 1.0)
        self.tie = 0.0 if self.hard else tie / max(self.count, 1)

    def solve(self, options: dict[str, Any]) -> Vector:
        """Run the solver; θ and states at its end; where they are not finite, `center`."""
        import casadi as ca

        n, callback = self.p + self.count, callback_class()
        one, dense, none = (ca.Sparsity.dense(k, 1) for k in (1, n, 0))
        conditions = self.count if self.hard else 0
        g, given, x = ca.Sparsity.dense(conditions, 1), {"x": dense, "p": none}, ca.MX.sym("x", n)
        self.hessian_pattern, self.slope_pattern = self._patterns()
        f = callback("f", self.objective, {"x": dense}, {"f": one})
        nlp, calls = {"x": x, "f": f(x)}, {
            "grad_f": callback("grad_f", self.gradient, given, {"f": one, "grad_f_x": dense}),
            "hess_lag": callback(
                "hess_lag", self.hessian, given | {"lam_f": one, "lam_g": g},
                {"triu_hess_gamma_x_x": self.hessian_pattern},
            ),
        }  # fmt: skip
        if self.hard:
            meet = callback("g", self.gaps, {"x": dense}, {"g": g})
            nlp["g"] = meet(x)
            slopes = {"g": g, "jac_g_x": self.slope_pattern}
            calls["jac_g"] = callback("jac_g", self.gap_slopes, given, slopes)
        solver = ca.nlpsol("shooting", "ipopt", nlp, options | calls)
        free, zero = np.full(self.count, np.inf), np.zeros(conditions)
        low = np.concatenate([(self.problem.lower - self.center[: self.p]) / self.problem.width, -free])
        high = np.concatenate([(self.problem.upper - self.center[: self.p]) / self.problem.width, free])
        point = self._point(solver(x0=np.zeros(n), lbx=low, ubx=high, lbg=zero, ubg=zero)["x"])
        return point if np.isfinite(point).all() else self.center

    def objective(self, x: Any) -> list[Any]:
        value = self.factor * sum(float(g.residual @ g.residual) for g in self._run(x))
        if self.tie:
            value += self.tie * float(np.sum(self._gaps(x) ** 2))
        return [0.5 * value]

    def gradient(self, x: Any, _: Any) -> list[Any]:
        self.ask(self.watch.values, self._point(x)[None, : self.p])
        self.watch.tell(self.watch.iterations + 1, self.max_iter)  # IPOPT asks once in each iteration
        total = np.zeros(self.p + self.count)
        for leg, at in zip(self._run(x), self.columns, strict=True):
            total[at] += (leg.residual_slope.T @ leg.residual)[: len(at)]
        total *= self.factor * self.unit
        if self.tie:
            total += self.tie * (self._gap_slopes(x).T @ self._gaps(x))
        return [*self.objective(x), total]

    def hessian(self, x: Any, _: Any, lam_f: Any, _lam_g: Any) -> list[Any]:
        """JᵀJ (Gauss–Newton): what the residuals and the joins curve themselves is left out."""
        import casadi as ca

        total = np.zeros((self.p + self.count,) * 2)
        for leg, at in zip(self._run(x), self.columns, strict=True):
            J = leg.residual_slope[:, : len(at)]
            total[np.ix_(at, at)] += J.T @ J
        total *= self.factor * np.outer(self.unit, self.unit)
        if self.tie:
            slopes = self._gap_slopes(x)
            total += self.tie * (slopes.T @ slopes)
        return [ca.project(ca.DM(float(lam_f) * total), self.hessian_pattern)]

    def gaps(self, x: Any) -> list[Any]:
        return [self._gaps(x)]

    def gap_slopes(self, x: Any, _: Any) -> list[Any]:
        import casadi as ca

        return [self._gaps(x), ca.project(ca.DM(self._gap_slopes(x)), self.slope_pattern)]

    def _gaps(self, x: Any) -> Vector:
        """What lies between the end of a segment and the states that the next one begins with, in `scale`."""
        legs, starts = self._run(x), self._point(x)[self.p :]
        return (np.concatenate([legs[k - 1].end for k in self.join]) - starts) / self.scale

    def _gap_slopes(self, x: Any) -> Matrix:
        slopes, s, legs = self._empty(), self.cut.states, self._run(x)
        for row, k in enumerate(self.join):
            at = self.columns[k - 1]
            slopes[row * s : (row + 1) * s, at] = legs[k - 1].end_slope[:, : len(at)]
        return np.asarray(slopes * self.unit / self.scale[:, None])

    def _empty(self) -> Matrix:
        """Slopes of the gaps by the states at the joins themselves."""
        return np.hstack([np.zeros((self.count, self.p)), -np.eye(self.count)])

    def _patterns(self) -> tuple[Any, Any]:
        """Sparsity of the Hessian's upper triangle and of the gaps' slopes."""
        import casadi as ca

        hessian, slopes, s = np.eye(self.p + self.count), self._empty(), self.cut.states
        for at in self.columns:
            hessian[np.ix_(at, at)] = 1
        for row, k in enumerate(self.join):
            slopes[row * s : (row + 1) * s, self.columns[k - 1]] = 1
        if self.tie:
            hessian += slopes.T @ slopes != 0
        found = [ca.sparsify(ca.DM(a)).sparsity() for a in (np.triu(hessian), slopes)]
        return found[0], found[1]

    def _columns(self) -> Iterator[NDArray[np.intp]]:
        """Where the columns of each segment stand in x: θ, and its states if it joins another."""
        node, s = self.p, self.cut.states
        for joins in self.cut.joins:
            own = np.arange(node, node + s if joins else node)
            node += own.size
            yield np.concatenate([np.arange(self.p), own])

    def _point(self, x: Any) -> Vector:
        point = self.center + self.unit * np.asarray(x, dtype=float).ravel()
        point[: self.p] = np.clip(point[: self.p], self.problem.lower, self.problem.upper)
        return point

    def _run(self, x: Any) -> list[Leg]:
        point = self._point(x)
        key = point.tobytes()
        if self._at is None or self._at[0] != key:
            self._at = key, self.ask(self._legs, point)
        return self._at[1]

    def _legs(self, point: Vector) -> list[Leg]:
        theta, nodes = point[: self.p], np.zeros((len(self.cut.parts), self.cut.states))
        nodes[self.join] = point[self.p :].reshape(-1, self.cut.states)
        return [self.cut.run(k, theta, node) for k, node in enumerate(nodes)]
