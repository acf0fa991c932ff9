"""Propagation of distributions by Monte Carlo (JCGM 101:2008) through a compiled model without inputs."""

from __future__ import annotations

import os
from collections.abc import Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from modelgen.codegen import Function
from modelgen.errors import InputError
from modelgen.fit.farm import draw_many

Array = np.ndarray[Any, np.dtype[Any]]
CHUNK = 20000


@dataclass(frozen=True)
class Spread:
    """Of one quantity: mean, standard deviation and the shortest interval of coverage `level`.

    lost: draws for which the model has no value, left out of the rest.
    """

    mean: float
    std: float
    low: float
    high: float
    level: float
    draws: int
    lost: int


def propagate(function: Function, draws: Mapping[str, Array], executor: Executor | None = None) -> Array:
    """The first output of the model (m,) at m draws of some parameters; the others take their defaults.

    The compiled model runs on all cores: its calls hold no lock. executor: where it runs instead.
    """
    sizes = {len(x) for x in draws.values()}
    if len(sizes) != 1:
        raise InputError(f"draws of different sizes {sorted(sizes)}, one size is wanted")
    (m,) = sizes
    if executor is not None:
        return np.asarray(draw_many(function, draws, executor))
    parts = [slice(k, k + CHUNK) for k in range(0, m, CHUNK)]
    function.tiers.library()

    def run(part: slice) -> Array:
        out = function(**{n: x[part] for n, x in draws.items()})
        return np.asarray(out[0] if isinstance(out, tuple) else out)

    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        return np.concatenate(list(pool.map(run, parts)))


def spread(values: Array, level: float = 0.99) -> Spread:
    """Statistics of draws (m,) (JCGM 101, 7.6 and 7.7). Raises InputError where fewer than 2 are finite."""
    finite = np.sort(values[np.isfinite(values)])
    if finite.size < 2:
        raise InputError(f"{finite.size} of {values.size} draws have a value: there is no spread to tell")
    covered = min(round(level * finite.size), finite.size - 1)
    widths = finite[covered:] - finite[: finite.size - covered]
    k = int(np.argmin(widths))
    return Spread(
        float(finite.mean()), float(finite.std(ddof=1)), float(finite[k]), float(finite[k + covered]),
        level, values.size, values.size - finite.size,
    )  # fmt: skip
