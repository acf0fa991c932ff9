"""Drawings of force-displacement loops: the cycles of a motion, or stiffness and loss along a sweep."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from modelgen.files import write_atomically
from modelgen.fit.loops import UNIT, Array, Loops
from modelgen.report import svg
from modelgen.report.axes import label, linear_ticks, log_ticks
from modelgen.report.fits import plot_format
from modelgen.report.words import number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZE, DPI = (9.0, 3.8), 130
MOST = 40  # cycles that are drawn one by one


def write_loops(found: Loops, path: str | Path) -> None:
    """Draw into a file, its format by its name: .svg, .png or .pdf. Whole or not at all.

    Raises InputError for another format or a missing folder, ToolError when the system refuses.
    """
    path = Path(path)
    kind, out = plot_format(path), BytesIO()
    with svg.style(svg.PAPER):
        metadata: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind, {})
        draw(found).savefig(out, format=kind, dpi=DPI, metadata=metadata)
    write_atomically(path, out.getvalue())


def draw(found: Loops) -> Figure:
    """Loops beside the stiffness of each cycle; of a sweep, stiffness and loss angle against frequency."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, layout="constrained")
    left, right = figure.subplots(1, 2)
    if found.swept():
        for axes, name in ((left, "k_s"), (right, "loss_angle")):
            _along(axes, found, name)
    else:
        for z, F in zip(found.z[:MOST], found.F[:MOST], strict=True):
            left.plot(np.append(z, z[0]), np.append(F, F[0]), color=svg.DATA, linewidth=0.8)
        left.plot(found.z.mean(axis=0), found.F.mean(axis=0), color=svg.AFTER)
        left.set_xlabel(label("z", "mm"))
        left.set_ylabel(label("F", "N"))
        linear_ticks(left.xaxis)
        linear_ticks(left.yaxis)
        _drift(right, found)
    return figure


def _along(axes: Any, found: Loops, name: str) -> None:
    """A figure of each cycle with its standard deviation against frequency."""
    f = found.values["f"]
    _bars(axes, f, found.values[name], found.std[name])
    axes.set_xlabel(label("f", "Hz"))
    axes.set_ylabel(label(name.replace("loss_angle", "loss angle"), UNIT[name]))
    axes.set_xscale("log")
    log_ticks(axes.xaxis, f)


def _drift(axes: Any, found: Loops) -> None:
    """k_s of each cycle against the mean, over time: whether the sample changes as it is moved."""
    mean = float(found.values["k_s"].mean())
    _bars(axes, found.t, 100 * (found.values["k_s"] / mean - 1), 100 * found.std["k_s"] / mean)
    axes.set_xlabel(label("t", "s"))
    axes.set_ylabel(f"k_s against {number(mean)} N/mm [%]")
    linear_ticks(axes.xaxis)


def _bars(axes: Any, x: Array, y: Array, std: Array) -> None:
    axes.errorbar(x, y, std, fmt="o", color=svg.AFTER, ecolor=svg.DATA, markersize=2.6, linewidth=0.8)
    linear_ticks(axes.yaxis)
