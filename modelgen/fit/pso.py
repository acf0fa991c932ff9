"""Particle swarm optimisation, as in the GMM paper's Fig. 4, and with better conditioned settings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from modelgen.errors import InputError
from modelgen.fit.method import Method, Outcome, Reason, Seed, Watch, at_least
from modelgen.fit.problem import Matrix, Problem, Vector, wide


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
        at_least(1, particles=self.particles, iterations=self.iterations)
        at_least(0, w=self.w, c1=self.c1, c2=self.c2, v_max=self.v_max, tol=self.tol)
        if self.bounds_handling not in ("reflect", "clip", "infinite"):
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
        rng = np.random.default_rng(self.seed if seed is None else seed)
        low, high = problem.box()
        x = rng.random((self.particles, low.size))
        if self.include_start:
            x[0] = place(low, high, start)
        v = rng.uniform(-self.v_max, self.v_max, x.shape)
        own, value = x, watch.values(uniform(low, high, x))
        for iteration in range(1, self.iterations + 1):
            leader = self._leader(own, value)
            r1, r2 = rng.random((2, *x.shape))
            v = self.w * v + self.c1 * r1 * (own - x) + self.c2 * r2 * (leader - x)
            x, v = self._contain(x, np.clip(v, -self.v_max, self.v_max))
            trial = self._evaluate(watch, x, low, high)
            better = trial < value
            own, value = np.where(better[:, None], x, own), np.where(better, trial, value)
            watch.population = uniform(low, high, own)
            watch.tell(iteration, self.iterations)
            if max(np.ptp(own, axis=0).max(), np.abs(v).max()) < self.tol:
                return watch.outcome(Reason.COLLAPSED)
        return watch.outcome(Reason.BUDGET if np.isfinite(watch.value) else Reason.NOT_FINITE)

    def _leader(self, own: Matrix, value: Vector) -> Matrix:
        """The best point known to each particle: (1, p) for all, or (m, p)."""
        if self.topology == "global":
            return own[None, np.argmin(value)]
        ring = np.arange(len(value)) + np.array([[-1], [0], [1]])
        best = np.argmin(value[ring % len(value)], axis=0)
        return own[(np.arange(len(value)) + best - 1) % len(value)]

    def _contain(self, x: Matrix, v: Matrix) -> tuple[Matrix, Matrix]:
        """Move by v and deal with the walls at 0 and 1."""
        new = x + v
        out = (new < 0) | (new > 1)
        if self.bounds_handling == "infinite":
            return new, v
        if self.bounds_handling == "clip":
            return np.clip(new, 0, 1), np.where(out, 0, v)
        return np.clip(np.where(new < 0, -new, np.where(new > 1, 2 - new, new)), 0, 1), np.where(out, -v, v)

    @staticmethod
    def _evaluate(watch: Watch, x: Matrix, low: Vector, high: Vector) -> Vector:
        """r·r of each particle (m,); +inf outside the box, where the model is not asked."""
        inside = ((x >= 0) & (x <= 1)).all(axis=1)
        values = np.full(len(x), np.inf)
        if inside.any():
            values[inside] = watch.values(uniform(low, high, x[inside]))
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
