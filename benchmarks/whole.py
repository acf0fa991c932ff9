"""Work that has no contestants: two cores, Monte Carlo, a thousand starts, first answers, limits."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

import modelgen.models as models
from benchmarks import fits
from benchmarks.first import first_answers
from benchmarks.transducer import function
from modelgen.codegen import build
from modelgen.codegen.roofline import machine, roofline
from modelgen.fit.montecarlo import propagate

DRAWS = 1_000_000
CORES = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else [0]


@contextmanager
def on(cores: list[int]) -> Iterator[None]:
    """What runs inside has these cores alone, where the system can say so."""
    if hasattr(os, "sched_setaffinity"):
        before = os.sched_getaffinity(0)
        os.sched_setaffinity(0, cores)
        yield
        os.sched_setaffinity(0, before)
    else:
        yield


def least(run: Callable[[], Any], rounds: int = 7) -> float:
    """Seconds."""
    found = []
    for _ in range(rounds):
        start = time.perf_counter()
        run()
        found.append(time.perf_counter() - start)
    return min(found)


def two_cores() -> dict[str, float]:
    """How much faster on two cores: the batch objective, and many starts. Both as calls of this library."""
    compiled, p = fits.problem().compiled, fits.problem()
    assert compiled is not None
    sets, box = np.tile(fits.recording().sets, (20, 1)), (p.lower, p.upper, p.width)
    tasks: dict[str, Callable[[int], Any]] = {
        "batch objective": lambda n: compiled.values(sets, threads=n),
        "starts": lambda n: compiled.descend(fits.recording().sets, box, (500, 1e-13, 0.1), n, True),
    }
    found = {}
    for name, task in tasks.items():
        task(2)
        found[name] = least(lambda t=task: t(1)) / least(lambda t=task: t(2))  # type: ignore[misc]
    return found


def contact() -> float:
    """Seconds of 10⁶ draws of the paper's Table 3 through the contact's damping, on all cores."""
    F = build(models.contact_damping)
    rng = np.random.default_rng(0)
    defaults = {p.name: p.default for p in F.model.scalar_parameters}
    names = [n for n in F.wrt if defaults[n]][:4]
    draws = {n: defaults[n] * (1 + 0.01 * rng.standard_normal(DRAWS)) for n in names}
    propagate(F, {n: x[:1000] for n, x in draws.items()})
    return least(lambda: propagate(F, draws), 2)


def shared() -> dict[str, Any]:
    """What runs on all cores, by name."""
    return {"two cores over one": two_cores(), "contact damping, a million draws [s]": contact()}


def alone() -> dict[str, Any]:
    """What runs on one core, by name."""
    roofs = {r.kernel: r for r in roofline(function())}
    limits = machine()
    return {
        "thousand starts [s]": least(fits.thousand(), 3),
        "thousand starts that reach the optimum": fits.reached(),
        "descent in C alone [s]": least(fits.descent_kernel()) / 20,
        "first answers, anew and cached [s]": first_answers(),
        "share of the limit": {k: roofs[f"{k}_complex"].share for k in ("sumsq", "jacobian", "normal")},
        "machine [ns]": {
            "operation": limits.arithmetic, "division": limits.division, "number moved": limits.memory
        },
    }  # fmt: skip
