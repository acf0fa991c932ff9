"""Cost against points, sets and parameters."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks import point
from benchmarks.timing import Run, race
from benchmarks.transducer import BATCH, Setting, setting
from modelgen.codegen import build
from modelgen.models import magnetostrictive_transducer

POINTS = (16, 64, 256, 1024, 4096)
SETS = (1, 10, 100, 1000)
SHOWN = ("modelgen", "C by hand", "numba", "JAX jit(vmap)", "numpy as written")
Curve = tuple[list[int], list[float]]


def curves(
    sizes: tuple[int, ...], of: Callable[[int], Setting], per: Callable[[int], int]
) -> dict[str, Curve]:
    """ns a point of the batch objective, for each contestant."""
    found: dict[str, Curve] = {}
    for size in sizes:
        s = of(size)
        runs = {w: (lambda s=s, w=w: BATCH[w](s)) for w in SHOWN}
        for e in race("batch", runs, patience=0.05, check=False):
            if e.seconds is not None:
                x, y = found.setdefault(e.who, ([], []))
                x.append(size)
                y.append(e.seconds * 1e9 / per(size))
    return found


def by_parameters(s: Setting) -> dict[str, Curve]:
    """ns a point of value and Jacobian, by how many parameters there are derivatives."""
    model = magnetostrictive_transducer.variant(eddy="series")
    names = [p.name for p in model.scalar_parameters]
    counts = [1, 2, 4, 6, 8, 11]
    ours = []
    for k in counts:
        F = build(model, names[:k])
        ready = F.prepare(f=s.f)
        p, out, jac = ready.p.copy(), np.empty((2, ready.stride)), np.empty((2, k, ready.stride))
        args = [ready.n, ready.stride, *(a.ctypes.data for a in (ready.work, p, out, jac))]
        kernel = F.code.addresses["jacobian_complex"]

        def run() -> Run:
            return lambda: kernel(*args)  # noqa: B023  timed at once

        (entry,) = race("jacobian", {"modelgen": run}, patience=0.05, check=False)
        ours.append((entry.seconds or 0.0) * 1e9 / len(s.f))
    z = race("differences", {"modelgen": lambda: point.differences(s)}, patience=0.05, check=False)[0].seconds
    each = (z or 0.0) * 1e9 / len(s.f) / 13  # one evaluation; two for each derivative, one for the value
    return {"modelgen": (counts, ours), "numpy, differences": (counts, [each * (1 + 2 * k) for k in counts])}


def draw(path: Path) -> None:
    """Three panels into an SVG, PNG or PDF."""
    from matplotlib.figure import Figure

    panels = {
        "points (100 sets)": curves(POINTS, lambda n: setting(n, 100), lambda n: 100 * n),
        "parameter sets (401 points)": curves(SETS, lambda m: setting(401, m), lambda m: 401 * m),
        "parameters with a derivative": by_parameters(setting(401, 1)),
    }
    figure = Figure(figsize=(11, 3.6), layout="constrained")
    axes = figure.subplots(1, 3, sharey=True)
    axes[0].set_ylabel("ns a point")
    for ax, (title, lines) in zip(axes, panels.items(), strict=True):
        for who, (x, y) in lines.items():
            ax.loglog(x, y, "o-", ms=3, label=who, lw=2 if who == "modelgen" else 1)
        ax.set_xlabel(title)
        ax.grid(alpha=0.3)
        ax.legend(fontsize=7)
    figure.savefig(path)
