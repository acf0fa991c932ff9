"""Searches further out, for sweeps, whose narrow resonances are islands to a local search: swarms in boxes of
several sizes, and descents from many points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

import numpy as np

from modelgen.fit.gauss_newton import GaussNewton
from modelgen.fit.method import Reason
from modelgen.fit.problem import Problem, Vector
from modelgen.fit.pso import PSO

REACHES = (1e5, 1e4, 1e3, 30.0, 1e5, 1e4, 1e3, 30.0)
"""Swarms search within these factors of the start: in thirteen decades no narrow resonance is found."""
SAME = 3
"""An optimum that this many swarms reach, and none beats, is taken for the best there is."""
SCATTERED, WITHIN = 300, (30.0, 1e3)
"""Points from which descents begin, within each of these factors of a known optimum."""
QUICK = 60
"""Their iterations."""
Found = TypeVar("Found")


def swarmed(
    problem: Problem,
    seed: int,
    descend: Callable[[Vector], Found],
    value: Callable[[Found], float],
    least: float,
) -> list[Found]:
    """Where descents lead from the ends of swarms about the problem's start, one after another until SAME of
    them agree on what is no more than `least`, the best that is known without them."""
    found: list[Found] = []
    for k, reach in enumerate(REACHES):
        end = PSO(particles=100, iterations=300).run(_boxed(problem, reach), seed=seed + k)
        found.append(descend(np.asarray(end.theta)))
        least = min(least, value(found[-1]))
        agree = sum(value(f) <= least * (1 + 1e-4) + 1e-6 for f in found) >= SAME
        if agree or end.reason is Reason.INTERRUPTED:
            break
    return found


def scattered(problem: Problem, seed: int, about: Vector) -> Vector:
    """The best end of descents from points about an optimum, by factors, each parameter's by itself.

    Far from the recordings an optimum may be that of something else than its parameters mean: a base whose
    resonance follows another one. A descent takes a thousandth of a swarm's time.
    """
    if problem.compiled is None or problem.constraints:
        return about
    rng, size = np.random.default_rng([seed, 11]), np.where(about != 0, about, 1.0)
    points = [size * reach ** rng.uniform(-1, 1, (SCATTERED, size.size)) for reach in WITHIN]
    begins = np.clip(np.concatenate([about[None], *points]), problem.lower, problem.upper)
    ends = GaussNewton(max_iter=QUICK).descents(problem, begins)
    return np.asarray(ends.theta[np.nanargmin(ends.value)])


def _boxed(p: Problem, reach: float) -> Problem:
    """The problem in a box of `reach` times the start up and down; on both sides of 0 where bounds allow."""
    size = np.where(p.start != 0, np.abs(p.start), 1.0)
    signed = p.lower < 0
    low = np.where(signed, -min(reach, 30.0) * size, size / reach)
    high = np.where(signed, min(reach, 30.0) * size, size * reach)
    return replace(p, lower=np.maximum(p.lower, np.minimum(low, p.start)), upper=np.minimum(p.upper, high))
