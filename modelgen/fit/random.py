"""Random search: sets drawn from the box, then random changes of the best one (MRE paper, Fig. 14)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from modelgen.fit.method import Method, Outcome, Reason, Seed, Watch, whole
from modelgen.fit.problem import Problem, Vector

BATCH = 64  # changes that are evaluated at once; few are kept, so hardly any are evaluated twice


@dataclass(frozen=True)
class RandomSets(Method):
    """The best of `sets` points, uniform in the box of the bounds (stage 2)."""

    sets: int = 100
    seed: int = 0

    def __post_init__(self) -> None:
        whole(1, sets=self.sets)

    @property
    def text(self) -> str:
        return f"best of {self.sets} random sets"

    def _search(self, problem: Problem, start: Vector, watch: Watch, seed: Seed) -> Outcome:
        rng = np.random.default_rng(self.seed if seed is None else seed)
        low, high = problem.box()
        watch.values(low + (high - low) * rng.random((self.sets, low.size)))
        watch.tell(1, 1)
        return watch.outcome(Reason.BUDGET)


@dataclass(frozen=True)
class RandomChanges(Method):
    """`changes` times, one to `most` parameters are each multiplied by a number from 0 to 2, and the better
    set is kept (stage 3).

    As written one after the other: a batch of changes is evaluated on the same point, and what stands behind
    the first one kept is evaluated anew on the new point. Values leave the box of the bounds only by being
    clipped to it.
    """

    changes: int = 100_000
    most: int = 3
    seed: int = 0

    def __post_init__(self) -> None:
        whole(1, changes=self.changes, most=self.most)

    @property
    def text(self) -> str:
        return f"{self.changes} random changes"

    def _search(self, problem: Problem, start: Vector, watch: Watch, seed: Seed) -> Outcome:
        rng = np.random.default_rng(self.seed if seed is None else seed)
        best, value = start, float(watch.values(start[None, :])[0])
        done, waiting = 0, np.zeros((0, start.size))
        while done < self.changes:
            fresh = min(BATCH - len(waiting), self.changes - done - len(waiting))
            waiting = np.vstack([waiting, self._factors(rng, fresh, start.size)])
            tried = np.clip(best * waiting, problem.lower, problem.upper)
            values = watch.values(tried)
            better = np.flatnonzero(values < value)
            used = int(better[0]) + 1 if better.size else len(waiting)
            if better.size:
                best, value = tried[used - 1], float(values[used - 1])
            waiting, done = waiting[used:], done + used
            watch.tell(done, self.changes)
        return watch.outcome(Reason.BUDGET)

    def _factors(self, rng: np.random.Generator, m: int, p: int) -> np.ndarray:
        """Of m changes: (m, p) factors, 1 for parameters that stay."""
        count = rng.integers(1, min(self.most, p) + 1, m)
        order = rng.permuted(np.tile(np.arange(p), (m, 1)), axis=1)
        return np.where(order < count[:, None], 2 * rng.random((m, p)), 1.0)
