"""Particle swarm optimisation, as in the GMM paper's Fig. 4, and with better conditioned settings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from modelgen.errors import InputError
from modelgen.fit.method import Method, Outcome, Reason, Seed, Watch, at_least, whole
from modelgen.fit.pool import slices
from modelgen.fit.problem import Matrix, Problem, Vector, wide

if TYPE_CHECKING:
    from modelgen.codegen.fitters import Flock
    from modelgen.fit.compiled import Compiled

WALLS = ("reflect", "clip", "infinite")
WORTH = 200_000  # samples times particles; with more, an iteration's work is shared out
STOPS = 20  # reports of progress during a compiled run


@dataclass(frozen=True)
class PSO(Method):
    """Particles fly through the box of the bounds, drawn to their own and to their neighbours' best point.

    v ← w v + c1 r1 (own best − x) + c2 r2 (swarm's best − x), x ← x + v, r1 and r2 uniform in [0, 1] for each
    coordinate (Kennedy & Eberhart 1995, Shi & Eberhart 1998); flow as in the GMM paper, Sec. 2.4, Fig. 4.
    The variable x runs from 0 to 1 across the box: evenly, but by the logarithm where bounds are positive and
    more than two decades apart. The first positions are uniform in it. v_max: greatest speed, as a part of
    the box. bounds_handling: "reflect" mirrors the position and turns the speed, "clip" stops at the wall,
    "infinite" lets particles leave, where nothing is as good as inside. topology: drawn to the best of all
    ("global") or of three neighbours ("ring"). include_start: the first particle sits at the start. tol: the
    extent of the swarm at which it has converged. The default (w = 0.7298, c1 = c2 = 1.49618) is the
    constriction of Clerc & Kennedy (2002).

    A parameter with an infinite bound is searched to 10 |start| from its start; a start of 0 is an
    InputError.
    """

    particles: int = 40
    iterations: int = 500
    w: float = 0.7298
    c1: float = 1.49618
    c2: float = 1.49618
    v_max: float = 0.5
    bounds_handling: Literal["reflect", "clip", "infinite"] = "reflect"
    topology: Literal["global", "ring"] = "ring"
    include_start: bool = True
    tol: float = 1e-9
    seed: int = 0

    def __post_init__(self) -> None:
        whole(1, particles=self.particles, iterations=self.iterations)
        at_least(0, w=self.w, c1=self.c1, c2=self.c2, v_max=self.v_max, tol=self.tol)
        if self.bounds_handling not in WALLS:
            raise InputError(
                f"bounds_handling '{self.bounds_handling}': 'reflect', 'clip' or 'infinite' is wanted"
            )
        if self.topology not in ("global", "ring"):
            raise InputError(f"topology '{self.topology}': 'global' or 'ring' is wanted")

    @classmethod
    def paper(cls, iterations: int = 300, seed: int = 0) -> PSO:
        """The GMM paper's settings (Sec. 4.3): 12 particles, w = 0.5, c1 = c2 = 2, to repeat its numbers.

        The paper states neither V_max nor what happens at the bounds; here they are 0.5 of the box and
        "clip". One of them is needed: these settings lie exactly on the limit of stability in variance, as
        c1 + c2 = 4 = 24 (1 − w²)/(7 − 5w), so the swarm's spread neither grows nor shrinks by itself. With
        six unknowns in the box of Table 7 most single runs miss the global basin: use restarts and a local
        polish.
        """
        return cls(12, iterations, 0.5, 2.0, 2.0, 0.5, "clip", "global", include_start=False, seed=seed)

    @property
    def text(self) -> str:
        return f"particle swarm ({self.particles} particles, {self.iterations} iterations)"

    def _search(self, problem: Problem, start: Vector, watch: Watch, seed: Seed) -> Outcome:
        from modelgen.codegen.fitters import Flock

        low, high = problem.box()
        flock = Flock(
            self.particles, low, high, wide(low, high), (self.w, self.c1, self.c2, self.v_max),
            WALLS.index(self.bounds_handling), self.topology == "ring",
        )  # fmt: skip
        root = np.random.default_rng(self.seed if seed is None else seed).integers(2**64, dtype=np.uint64)
        flock.begin(int(root), place(low, high, start) if self.include_start else None)
        flock.judge(watch.values(flock.theta))
        compiled = None if problem.constraints else problem.compiled
        if compiled is not None and self.particles * compiled.samples <= WORTH:
            self._fly(flock, compiled, watch)
        else:
            self._fly_apart(flock, watch)
        if flock.extent < self.tol:
            return watch.outcome(Reason.COLLAPSED)
        return watch.outcome(Reason.BUDGET if np.isfinite(watch.value) else Reason.NOT_FINITE)

    def _fly(self, flock: Flock, compiled: Compiled, watch: Watch) -> None:
        """All iterations in C, but for some stops to report progress and hear of Ctrl-C."""
        tables, keep = compiled.tables()
        for some in slices(self.iterations, STOPS):
            count = some.stop - some.start
            history = flock.run(tables, count, self.tol)
            watch.evaluations += len(history) * self.particles
            watch.history += [min(watch.value, value) for value in history]
            best = int(np.argmin(flock.value))
            watch.keep(uniform(flock.low, flock.high, flock.own[best]), float(flock.value[best]))
            watch.population = uniform(flock.low, flock.high, flock.own)
            watch.iterations += len(history)
            if watch.progress is not None:
                watch.progress(some.stop / self.iterations, watch.value)
            if len(history) < count or flock.extent < self.tol:
                break
        del keep

    def _fly_apart(self, flock: Flock, watch: Watch) -> None:
        """Move in C, evaluate wherever the problem does."""
        for iteration in range(1, self.iterations + 1):
            flock.move()
            flock.judge(self._evaluate(watch, flock))
            watch.population = uniform(flock.low, flock.high, flock.own)
            watch.tell(iteration, self.iterations)
            if flock.extent < self.tol:
                break

    @staticmethod
    def _evaluate(watch: Watch, flock: Flock) -> Vector:
        """r·r of each particle (m,); +inf outside the box, where the model is not asked."""
        inside = ((flock.x >= 0) & (flock.x <= 1)).all(axis=1)
        values = np.full(len(flock.x), np.inf)
        if inside.any():
            values[inside] = watch.values(flock.theta[inside])
        return values


def uniform(low: Vector, high: Vector, u: Matrix) -> Matrix:
    """Points of the box [low, high] (p,) for u (m, p) in [0, 1]; log-uniform over more than two decades."""
    log = wide(low, high)
    ratio = np.where(log, high / np.where(log, low, 1), 1.0)
    return np.clip(np.where(log, low * ratio**u, low + u * (high - low)), low, high)


def place(low: Vector, high: Vector, theta: Vector) -> Vector:
    """Where θ (p,) lies in the box, 0 to 1: the inverse of `uniform`."""
    log = wide(low, high)
    floor = np.where(log, low, 1)
    by_ratio = np.log(np.where(log, theta, 1) / floor) / np.log(np.where(log, high / floor, np.e))
    return np.clip(np.where(log, by_ratio, (theta - low) / (high - low)), 0, 1)
