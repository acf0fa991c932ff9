"""Many starts of one method, for objectives with several basins."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from modelgen.errors import InputError
from modelgen.fit.gauss_newton import GaussNewton, ended
from modelgen.fit.method import OUTSIDE, Method, Outcome, Reason, Seed, Watch, part, whole
from modelgen.fit.pool import slices
from modelgen.fit.problem import Matrix, Problem, Vector
from modelgen.fit.pso import uniform

if TYPE_CHECKING:
    from modelgen.fit.farm import Farm

SAME = 1e-6  # relative difference of r·r within which two starts have reached the same optimum
AT_ONCE = 256  # starts between two reports of progress
SMALL = 1e-12  # r·r, relative to the first start's, that counts as 0


@dataclass(frozen=True)
class MultiStart(Method):
    """Run `inner` from the given start and from a Latin hypercube of others, and keep the best.

    The hypercube fills the box of the bounds, by the logarithm where they are positive and more than two
    decades apart; an infinite bound counts as 10 |start| from the start. The outcome says how many `starts`
    `reached` the best value, and where each ended (population). farm: where the starts run, if not here.
    """

    inner: Method = field(default_factory=lambda: GaussNewton(beyond=True))
    starts: int = 20
    seed: int = 0
    farm: Farm | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.inner, Method):
            raise InputError(
                f"setting inner = {self.inner!r}: a method is wanted; the count is MultiStart(starts=20)"
            )
        whole(1, starts=self.starts)

    @property
    def text(self) -> str:
        return f"{self.inner.text}, from {self.starts} starts"

    def _search(self, problem: Problem, start: Vector, watch: Watch, seed: Seed) -> Outcome:
        rng = np.random.default_rng(self.seed if seed is None else seed)
        low, high = problem.box()
        begins = np.vstack([start, uniform(low, high, latin_hypercube(self.starts - 1, low.size, rng))])
        ends = self._ends(problem, begins, watch, rng)
        best = min(ends, key=lambda end: watch.merit(end.theta, end.value))
        interrupted = ends[-1].reason is Reason.INTERRUPTED
        found = watch.outcome(Reason.INTERRUPTED if interrupted else best.reason)
        began = problem.value(start)
        enough = found.value * (1 + SAME) + (SMALL * began if np.isfinite(began) else 0.0)
        reached = sum(end.value <= min(enough, OUTSIDE) for end in ends)
        return replace(
            found, population=np.array([end.theta for end in ends]), reached=reached, starts=len(ends)
        )

    def _ends(
        self, problem: Problem, begins: Matrix, watch: Watch, rng: np.random.Generator
    ) -> list[Outcome]:
        """The outcome from each start: in C all at once, where that can be, else one after the other."""
        ends: list[Outcome] = []
        if self.farm is not None:
            ends = self.farm.ends(problem, self.inner, begins, rng)
            for end in ends:
                watch.absorb(end)
            return ends
        if isinstance(self.inner, GaussNewton) and problem.compiled is not None and not problem.constraints:
            for some in slices(len(begins), -(-len(begins) // AT_ONCE)):
                found = self.inner.descents(problem, begins[some], kept=True)
                values = ((value,) for value in found.value.tolist())
                ends += [ended(watch, found, k, value) for k, value in enumerate(values)]
                if watch.progress is not None:
                    watch.progress(len(ends) / len(begins), watch.value)
                if found.interrupted:
                    break
            return ends
        for done, begin in enumerate(begins):
            ends.append(self.inner.run(problem, begin, part(watch.progress, done, self.starts), rng))
            watch.absorb(ends[-1])
            if ends[-1].reason is Reason.INTERRUPTED:
                break
        return ends


def latin_hypercube(m: int, p: int, rng: np.random.Generator) -> Matrix:
    """m points (m, p) in the unit cube, one in each of m layers along every axis (McKay et al. 1979)."""
    layers = rng.permuted(np.tile(np.arange(m)[:, None], p), axis=0)
    return (layers + rng.random((m, p))) / max(m, 1)
