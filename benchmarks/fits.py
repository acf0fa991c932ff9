"""Whole fits of M1: swarm, Levenberg–Marquardt from a random start, a thousand starts."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import sympy as sp

from benchmarks.timing import Run
from benchmarks.transducer import HIGH, LOW, SIX, Setting, function, setting, textbook
from modelgen.fit import PSO, GaussNewton, MultiStart, Problem
from modelgen.fit.compiled import Compiled
from modelgen.fit.recorded import Recorded
from modelgen.fit.whitener import Whitener

PARTICLES, ITERATIONS, STARTS = 100, 500, 1000


@cache
def recording() -> Setting:
    """401 frequencies with 1 % noise; sets: random starts."""
    return setting(401, STARTS)


@cache
def problem() -> Problem:
    s, F = recording(), function()
    ready = F.prepare(f=s.f)
    data, weight = np.stack([s.data.real, s.data.imag]), np.ones((2, len(s.f)))
    rows, place = np.arange(2, dtype=np.uintp), np.arange(6, dtype=np.int64)
    padded, whitener = (ready.pad(data), ready.pad(weight)), Whitener(weight)
    recorded = Recorded(ready, "complex", *padded, whitener, rows, place, np.zeros(6), fused=True)
    compiled = Compiled((recorded,), len(SIX))

    def linearise(theta: Any) -> tuple[Any, Any]:
        values, jac = ready.jacobian(theta, "complex")
        return (values - data).ravel(), jac.transpose(0, 2, 1).reshape(-1, 6)

    def residual(theta: Any) -> Any:
        return (ready.values(theta, "complex") - data).ravel()

    middle = (LOW + HIGH) / 2
    return Problem(
        SIX, ("1",) * 6, LOW, HIGH, middle, residual, linearise, n_data=2 * len(s.f), compiled=compiled
    )


def values(thetas: Any) -> Any:
    """What the others' swarms call: our batch objective, so that only the swarms themselves differ."""
    compiled = problem().compiled
    assert compiled is not None
    return compiled.values(thetas)


def swarm_ours() -> Run:
    method = PSO(PARTICLES, ITERATIONS, tol=0.0)
    return lambda: method.run(problem()).value


def by_numpy(thetas: Any) -> Any:
    """The objective as a user of the others would write it."""
    s, (names, Z) = recording(), textbook()
    call = _lambdified(names, Z)
    return (np.abs(call(s.f, *(c[:, None] for c in thetas.T)) - s.data) ** 2).sum(axis=1)


@cache
def _lambdified(names: Any, Z: Any) -> Any:
    return sp.lambdify(names, Z, "numpy", cse=True)


def swarm_pygmo(values: Callable[[Any], Any]) -> Run:
    import pygmo as pg

    class Batch:
        def fitness(self, x: Any) -> Any:
            return values(np.atleast_2d(x))

        def batch_fitness(self, xs: Any) -> Any:
            return values(np.reshape(xs, (-1, 6)))

        def get_bounds(self) -> Any:
            return LOW, HIGH

    def run() -> Any:
        method = pg.pso_gen(gen=ITERATIONS, seed=1)
        method.set_bfe(pg.bfe(pg.member_bfe()))
        where = pg.population(pg.problem(Batch()), PARTICLES, b=pg.bfe(pg.member_bfe()), seed=1)
        return pg.algorithm(method).evolve(where).champion_f[0]

    return run


def swarm_pyswarms() -> Run:
    import logging

    import pyswarms

    logging.disable(logging.INFO)
    options = {"c1": 1.49618, "c2": 1.49618, "w": 0.7298}

    def run() -> Any:
        swarm = pyswarms.single.GlobalBestPSO(PARTICLES, 6, options, bounds=(LOW, HIGH))
        return swarm.optimize(values, ITERATIONS, verbose=False)[0]

    return run


def swarm_pymoo() -> Run:
    from pymoo.algorithms.soo.nonconvex.pso import PSO as Swarm
    from pymoo.core.problem import Problem as Base
    from pymoo.optimize import minimize

    class Batch(Base):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__(n_var=6, n_obj=1, xl=LOW, xu=HIGH)

        def _evaluate(self, x: Any, out: Any, *_: Any, **__: Any) -> None:
            out["F"] = values(x)

    return lambda: minimize(Batch(), Swarm(pop_size=PARTICLES), ("n_gen", ITERATIONS), seed=1).F[0]


def swarm_scipy() -> Run:
    from scipy.optimize import differential_evolution

    box = list(zip(LOW, HIGH, strict=True))
    settings = {"popsize": PARTICLES // 6, "maxiter": ITERATIONS, "tol": 0, "polish": False, "seed": 1}
    return lambda: (
        differential_evolution(
            lambda x: values(x.T), box, vectorized=True, updating="deferred", **settings
        ).fun
    )


def starts() -> Any:
    return recording().sets[:20]


def descent_ours() -> Run:
    method, at = GaussNewton(), iter(np.tile(starts(), (10_000, 1)))
    return lambda: method.run(problem(), next(at)).value


def descent_kernel() -> Run:
    """The run in C alone, from each of 20 starts in one call."""
    p = problem()
    assert p.compiled is not None
    box, run = (p.lower, p.upper, p.width), p.compiled.descend
    return lambda: run(starts(), box, (500, 1e-13, 0.1), threads=1).value


def descent_scipy(method: str) -> Run:
    """With our analytic Jacobian: only the optimiser differs. Parameters scaled to one, as it needs."""
    from scipy.optimize import least_squares

    p, at = problem(), iter(np.tile(starts(), (10_000, 1)))
    scale = HIGH - LOW
    box = {} if method == "lm" else {"bounds": (LOW / scale, HIGH / scale)}
    assert p.linearise is not None
    linearise = p.linearise

    def run() -> Any:
        found = least_squares(
            lambda x: p.residual(x * scale), next(at) / scale, lambda x: linearise(x * scale)[1] * scale,
            method=method, xtol=1e-13, ftol=1e-13, gtol=1e-13, **box,
        )  # fmt: skip
        return 2 * found.cost

    return run


def thousand() -> Run:
    method = MultiStart(starts=STARTS)
    return lambda: method.run(problem()).value


def reached() -> float:
    """Share of a thousand starts that end at the best value."""
    p = problem()
    assert p.compiled is not None
    box = p.lower, p.upper, p.width
    ends = p.compiled.descend(recording().sets, box, (500, 1e-13, 0.1), beyond=True).value
    return float(np.mean(ends < ends.min() * (1 + 1e-6)))


SWARMS: dict[str, Callable[[], Run]] = {
    "modelgen": swarm_ours,
    "pygmo pso_gen, numpy": lambda: swarm_pygmo(by_numpy),
    "pygmo pso_gen, our objective": lambda: swarm_pygmo(values),
    "pyswarms, our objective": swarm_pyswarms,
    "pymoo PSO, our objective": swarm_pymoo,
    "scipy DE, our objective": swarm_scipy,
}
DESCENTS: dict[str, Callable[[], Run]] = {
    "modelgen": descent_ours,
    "scipy least_squares lm": lambda: descent_scipy("lm"),
    "scipy least_squares trf": lambda: descent_scipy("trf"),
}
