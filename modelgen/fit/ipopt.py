"""IPOPT through CasADi: bounds and inequality constraints by an interior point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from modelgen.errors import InputError
from modelgen.fit.guard import Guard, callback_class
from modelgen.fit.method import Method, Outcome, Reason, Seed, Watch, at_least, whole
from modelgen.fit.problem import FLAT, ZERO, Matrix, Normal, Problem, Vector
from modelgen.fit.shooting import shoot

PASSES = 6  # the objective's scale is renewed when a pass has brought it down by more than DROP
DROP = 3.0
DAMPING = (
    1e-3  # added to JᵀJ, relative to its diagonal, after a pass that failed; ten times more after the next
)

_REASONS = {
    "Solve_Succeeded": Reason.CONVERGED,
    "Solved_To_Acceptable_Level": Reason.CONVERGED,
    "Maximum_Iterations_Exceeded": Reason.BUDGET,
    "Infeasible_Problem_Detected": Reason.INFEASIBLE,
    "Search_Direction_Becomes_Too_Small": Reason.STALLED,
    "Restoration_Failed": Reason.STALLED,
    "Invalid_Number_Detected": Reason.NOT_FINITE,
}


@dataclass(frozen=True)
class IPOPT(Method):
    """Interior-point method of Wächter & Biegler (2006).

    hessian: "gauss-newton" takes JᵀJ, without the constraints' curvature; "exact" takes `problem.hessian`;
    "limited-memory" builds one from gradients and is slow or fails on stiff problems. The variable is affine,
    x = (θ − start)/width (see Problem.width), and the objective ½ r·r is divided by its value at the start,
    again after each pass that has lowered it much: so `tol`, on the gradient of that, is free of units.

    shooting: for models with states, begin by multiple shooting in this many segments of each recording
    (Bock 1983), whose initial states are unknowns as well; 0 for none. It finds its way from starts at which
    the model, run through, leaves the data or blows up. The uncut problem then has the last word.
    """

    hessian: Literal["gauss-newton", "exact", "limited-memory"] = "gauss-newton"
    max_iter: int = 500
    tol: float = 1e-9
    shooting: int = 0

    def __post_init__(self) -> None:
        whole(1, max_iter=self.max_iter)
        whole(0, shooting=self.shooting)
        at_least(0, tol=self.tol)
        if self.hessian not in ("gauss-newton", "exact", "limited-memory"):
            raise InputError(
                f"hessian '{self.hessian}': 'gauss-newton', 'exact' or 'limited-memory' is wanted"
            )

    @property
    def text(self) -> str:
        cut = f", multiple shooting in {self.shooting} segments" if self.shooting else ""
        return f"IPOPT ({self.hessian} Hessian{cut})"

    def _search(self, problem: Problem, start: Vector, watch: Watch, seed: Seed) -> Outcome:
        if self.hessian == "exact" and problem.hessian is None:
            raise InputError("IPOPT(hessian='exact'): this problem has no exact Hessian; use 'gauss-newton'")
        if self.shooting:
            start = self._shot(problem, start, watch)
        f = watch.normal_equations(start)[0]
        if not np.isfinite(f):
            return watch.outcome(Reason.NOT_FINITE)
        theta, f_start, damping, reason = start, f, 0.0, Reason.BUDGET
        for renewed in range(PASSES):
            scaled = _Scaled(problem, watch, theta, f or 1.0, damping, self.max_iter)
            with scaled.kept_together():
                status, theta = self._pass(scaled, renewed > 0)
            reason = _REASONS.get(status, Reason.FAILED)
            normal = watch.normal_equations(theta)
            before, f = f, normal[0]
            flat = f <= ZERO * f_start or problem.promise(theta, normal) <= FLAT
            if (
                flat and not problem.constraints
            ):  # whatever the solver says: it may want more than rounding allows
                return watch.outcome(Reason.CONVERGED)
            if reason in (Reason.BUDGET, Reason.INFEASIBLE) or watch.iterations >= self.max_iter:
                break
            if reason is Reason.CONVERGED:
                if not f < before / DROP:
                    break
            elif np.isfinite(
                watch.value
            ):  # lost where JᵀJ is singular or misleading: go on from the best point
                damping = max(DAMPING, 10 * damping)
                theta, f = watch.theta, min(f, watch.value)
        return watch.outcome(reason)

    def _shot(self, problem: Problem, start: Vector, watch: Watch) -> Vector:
        """The best θ that multiple shooting comes upon."""
        if problem.segments is None:
            raise InputError(
                f"IPOPT(shooting={self.shooting}): recordings are cut into segments only for a model with "
                "states, and where the noise is independent from sample to sample"
            )
        watch.values(start[None, :])
        cut = problem.segments(self.shooting)
        shoot(problem, cut, start, watch, self.max_iter, self._options(False, self.max_iter))
        return watch.theta

    def _pass(self, scaled: _Scaled, warm: bool) -> tuple[str, Vector]:
        """One run of the solver, from x = 0: its status, and θ at its end."""
        import casadi as ca

        p, m = scaled.center.size, len(scaled.problem.constraints)
        one, dense, none = (ca.Sparsity.dense(k, 1) for k in (1, p, 0))
        g, jac = ca.Sparsity.dense(m, 1), ca.Sparsity.dense(m, p)
        callback = callback_class()
        x = ca.MX.sym("x", p)
        f = callback("f", scaled.objective, {"x": dense}, {"f": one})
        grad_f = callback("grad_f", scaled.gradient, {"x": dense, "p": none}, {"f": one, "grad_f_x": dense})
        options: dict[str, Any] = {"grad_f": grad_f}
        nlp = {"x": x, "f": f(x)}
        if m:
            inside = callback("g", scaled.conditions, {"x": dense}, {"g": g})
            nlp["g"] = inside(x)
            options["jac_g"] = callback(
                "jac_g", scaled.condition_slopes, {"x": dense, "p": none}, {"g": g, "jac_g_x": jac}
            )
        if self.hessian != "limited-memory":
            curvature = scaled.exact_hessian if self.hessian == "exact" else scaled.gauss_newton_hessian
            options["hess_lag"] = callback(
                "hess_lag", curvature, {"x": dense, "p": none, "lam_f": one, "lam_g": g},
                {"triu_hess_gamma_x_x": ca.Sparsity.upper(p)},
            )  # fmt: skip
        left = max(1, self.max_iter - scaled.watch.iterations)
        solver = ca.nlpsol("fit", "ipopt", nlp, options | self._options(warm, left))
        found = solver(
            x0=np.zeros(p), lbx=scaled.low, ubx=scaled.high, lbg=np.zeros(m), ubg=np.full(m, np.inf)
        )
        return solver.stats()["return_status"], scaled.theta(found["x"])

    def _options(self, warm: bool, left: int) -> dict[str, Any]:
        ipopt = {
            "tol": self.tol,
            "max_iter": left,
            "print_level": 0,
            "sb": "yes",
            "bound_relax_factor": 0.0,
            # near a bound is where many optima are, and where a chained start comes from: hardly push inside
            "bound_push": 1e-6,
            "bound_frac": 1e-6,
            "mu_init": 1e-6 if warm else 1e-5,
        }
        if self.hessian == "limited-memory":
            ipopt["hessian_approximation"] = "limited-memory"
        return {f"ipopt.{name}": value for name, value in ipopt.items()} | {
            "print_time": False, "show_eval_warnings": False, "error_on_fail": False,
            "no_nlp_grad": True, "calc_lam_p": False,
        }  # fmt: skip


class _Scaled(Guard):
    """The problem in IPOPT's variable x = (θ − center)/width; each point is evaluated once for all."""

    def __init__(
        self, problem: Problem, watch: Watch, center: Vector, f_center: float, damping: float, max_iter: int
    ) -> None:
        super().__init__()
        self.problem, self.watch, self.center, self.max_iter = problem, watch, center, max_iter
        self.damping = damping
        self.width, self.factor = problem.width, 1 / f_center
        self.low, self.high = (problem.lower - center) / self.width, (problem.upper - center) / self.width
        # a condition's own unit is arbitrary: its slope at the center sets the scale
        slopes = [np.linalg.norm(g.gradient(center) * self.width) for g in problem.constraints]
        self.condition_scale = np.array([1 / slope if slope > 0 else 1.0 for slope in slopes])
        self._at: tuple[bytes, Normal] | None = None

    def theta(self, x: Any) -> Vector:
        """θ (p,) for CasADi's x, kept within the bounds against rounding."""
        theta = self.center + self.width * np.asarray(x, dtype=float).ravel()
        return np.clip(theta, self.problem.lower, self.problem.upper)

    def objective(self, x: Any) -> list[Any]:
        return [0.5 * self.factor * self._normal(x)[0]]

    def gradient(self, x: Any, _: Any) -> list[Any]:
        f, g, _A = self._normal(x)
        self.watch.tell(self.watch.iterations + 1, self.max_iter)  # IPOPT asks once in each iteration
        return [0.5 * self.factor * f, self.factor * self.width * g]

    def gauss_newton_hessian(self, x: Any, _: Any, lam_f: Any, _lam_g: Any) -> list[Any]:
        A = self._normal(x)[2]
        return [self._triangle(float(lam_f) * (A + self.damping * np.diag(A.diagonal())))]

    def exact_hessian(self, x: Any, _: Any, lam_f: Any, _lam_g: Any) -> list[Any]:
        assert self.problem.hessian is not None
        return [self._triangle(float(lam_f) * self.ask(self.problem.hessian, self.theta(x)))]

    def conditions(self, x: Any) -> list[Any]:
        theta = self.theta(x)
        values = [self.ask(g.value, theta) for g in self.problem.constraints]
        return [np.array(values) * self.condition_scale]

    def condition_slopes(self, x: Any, _: Any) -> list[Any]:
        theta = self.theta(x)
        rows = np.array([self.ask(g.gradient, theta) * self.width for g in self.problem.constraints])
        return [*self.conditions(x), rows * self.condition_scale[:, None]]

    def _triangle(self, hessian: Matrix) -> Any:
        import casadi as ca

        return ca.triu(ca.DM(self.factor * hessian * np.outer(self.width, self.width)))

    def _normal(self, x: Any) -> Normal:
        theta = self.theta(x)
        key = theta.tobytes()
        if self._at is None or self._at[0] != key:
            self._at = key, self.ask(self.watch.normal_equations, theta)
        return self._at[1]
