"""The figure of what a model lacks in a time record: the force left over, over displacement and speed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from modelgen.diagnose.verdict import Trace
from modelgen.report import svg
from modelgen.report.axes import dots, label, linear_ticks
from modelgen.report.plots import LOOP_POINTS, panels, same_model, stroke_of
from modelgen.report.thin import Array, every, excerpt

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def drawable(trace: Trace) -> bool:
    """Whether a trace is a force record over a stroke."""
    return bool(stroke_of(trace)) and not np.iscomplexobj(trace.data) and len(trace.x) > 1


def lack(trace: Trace, units: Mapping[str, str], key: str = "l") -> str:
    """Data minus model before (dots), model after minus before (line), over stroke and speed, as an SVG.

    One stretch of about three cycles, that which the model before misses most.
    """
    from matplotlib.figure import Figure

    stroke = stroke_of(trace)
    stretch = excerpt(trace.inputs[stroke], np.sum(np.square(trace.white_before), axis=0))
    i = np.arange(len(trace.x))[stretch]
    i = i[every(len(i), LOOP_POINTS)]
    z, unit = trace.inputs[stroke], units.get(stroke, "")
    speed = np.gradient(z, trace.x) if np.all(np.diff(trace.x) > 0) else np.zeros_like(z)
    speed = trace.inputs.get("v", speed)
    rate = units.get("v", f"{unit}/s" if unit else "")
    name = panels(trace)[0].title
    with svg.style():
        figure = Figure(figsize=(9.6, 3.5))
        room = {"left": 0.055, "right": 0.99, "bottom": 0.13, "top": 0.92, "wspace": 0.14}
        left, right = figure.subplots(1, 2, gridspec_kw=room)
        _over(left, z[i], trace, i, label(stroke, unit))
        _over(right, speed[i], trace, i, label("speed", rate))
        for axes in (left, right):
            axes.set_title(f"missing {name}")
        return svg.inline(figure, f"missing {name} over {stroke} and over speed in {trace.name}", key)


def _over(axes: Axes, x: Array, trace: Trace, i: Array, title: str) -> None:
    dots(axes, x, (trace.data - trace.before)[i], svg.DATA, 2.6)
    if not same_model(trace):
        axes.plot(x, (trace.after - trace.before)[i], color=svg.AFTER, linewidth=1.3)
    axes.axhline(0, color=svg.MUTED, linewidth=0.6)
    axes.set_xlabel(title)
    linear_ticks(axes.xaxis)
    linear_ticks(axes.yaxis)
