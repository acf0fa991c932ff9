"""Gauss–Newton with Levenberg's damping and bounds: the local method of choice for a fit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from modelgen.fit.constrained import constrained
from modelgen.fit.method import Method, Outcome, Reason, Seed, Watch, at_least, whole
from modelgen.fit.problem import Matrix, Normal, Problem, Vector

if TYPE_CHECKING:
    from modelgen.fit.compiled import Ends


@dataclass(frozen=True)
class GaussNewton(Method):
    """Levenberg–Marquardt on the normal equations; each step is the damped quadratic's minimum within bounds.

    The steps are made in C (templates/fit.c.j2), and so is the whole run where a problem is `compiled`.

    The damping follows Nielsen (1999, IMM-REP-1999-05), in units of the Jacobian's column norms (Moré 1978),
    so that parameters need no scaling: an affine change of any of them changes no step. A parameter on a
    bound with the gradient pushing out is frozen; one that a step would take across is put on the bound and
    the others are solved again. tol: relative decrease of r·r at which it stops. damping: the first one, in
    units of the scaled normal matrix (whose diagonal is 1).

    beyond: a run that a wall holds goes on from there as if there were none (100 iterations at most), comes
    back to the nearest point of the box, descends once more within it, and keeps the better of both ends: the
    way round a valley that a wall has cut off from its bottom. Problems with constraints keep to their walls.
    """

    max_iter: int = 500
    tol: float = 1e-13
    damping: float = 0.1
    beyond: bool = False

    def __post_init__(self) -> None:
        whole(1, max_iter=self.max_iter)
        at_least(0, tol=self.tol, damping=self.damping)

    @property
    def text(self) -> str:
        return "Gauss–Newton with Levenberg–Marquardt damping"

    def _search(self, problem: Problem, start: Vector, watch: Watch, seed: Seed) -> Outcome:
        def descend(evaluate: Callable[[Vector], Normal], theta: Vector) -> tuple[Vector, Reason]:
            return self._descend(problem, evaluate, theta, watch)

        if problem.constraints:
            return watch.outcome(constrained(problem, watch.normal_equations, start, descend))
        if problem.compiled is not None:
            ends = self.descents(problem, start[None], kept=True)
            return ended(watch, ends, 0, tuple(ends.history.tolist()))
        return watch.outcome(descend(watch.normal_equations, start)[1])

    def descents(self, problem: Problem, starts: Matrix, kept: bool = False) -> Ends:
        """Where the runs from each of `starts` (m, p) end, all in C; `problem` is compiled.

        kept: Ctrl-C ends them, and what they have found is kept.
        """
        assert problem.compiled is not None
        box = (problem.lower, problem.upper, problem.width)
        settings = self.max_iter, self.tol, self.damping
        return problem.compiled.descend(starts, box, settings, beyond=self.beyond, kept=kept)

    def _descend(
        self, problem: Problem, evaluate: Callable[[Vector], Normal], theta: Vector, watch: Watch
    ) -> tuple[Vector, Reason]:
        """From θ to the minimum within the bounds of what `evaluate` gives, and why it ended there."""
        from modelgen.codegen.fitters import RUNNING, Descent

        settings = self.max_iter, self.tol, self.damping, self.beyond and not problem.constraints
        run = Descent(problem.lower, problem.upper, problem.width, *settings)
        status = run.begin(theta, *evaluate(theta))
        while status == RUNNING:
            status = run.propose()
            if status == RUNNING:
                status = run.judge(*evaluate(run.trial.copy()))
                watch.tell(int(run.s.iteration), self.max_iter)
        return run.theta, reason(status)


def reason(status: int) -> Reason:
    """Why a run ended, from C's status."""
    return (Reason.CONVERGED, Reason.CONVERGED, Reason.BUDGET, Reason.STALLED, Reason.NOT_FINITE)[status]


def ended(watch: Watch, ends: Ends, k: int, history: tuple[float, ...]) -> Outcome:
    """The outcome of descent k in C."""
    counts = int(ends.evaluations[k]), int(ends.iterations[k])
    why = Reason.INTERRUPTED if ends.interrupted else reason(int(ends.status[k]))
    outcome = Outcome(ends.theta[k], float(ends.value[k]), *counts, why, history)
    watch.absorb(outcome)
    return outcome
