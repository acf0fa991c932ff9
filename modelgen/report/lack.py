"""The figure of what a model lacks in a time record: the force left over, over displacement and speed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from modelgen.diagnose.verdict import Trace
from modelgen.report import svg
from modelgen.report.axes import dots, label, linear_ticks, log_ticks, wants_log
from modelgen.report.plots import LOOP_POINTS, panels, same_model, stroke_of
from modelgen.report.thin import Array, every, excerpt, upward

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def drawable(trace: Trace) -> bool:
    """Whether a trace is a force record over a stroke."""
    return (
        bool(stroke_of(trace))
        and not np.iscomplexobj(trace.data)
        and bool(np.all(np.diff(trace.x) > 0))
        and len(trace.x) > 1
    )


def cyclic(trace: Trace) -> bool:
    """Whether the stroke goes to and fro at least twice; a ramp, a step or a hold doesn't."""
    z = trace.inputs[stroke_of(trace)]
    return upward(z) >= 2


def lack(trace: Trace, units: Mapping[str, str], key: str = "l") -> str:
    """Data minus model before (dots), model after minus before (line), over stroke and speed, as an SVG.

    One stretch of about three cycles, the one missed most by the model before. Records without cycles are drawn
    over time and stroke: a relaxation is read over the logarithm of time.
    """
    from matplotlib.figure import Figure

    stroke = stroke_of(trace)
    z, unit = trace.inputs[stroke], units.get(stroke, "")
    i = np.arange(len(z))[excerpt(z, np.sum(np.square(trace.white_before), axis=0))]
    i = i[every(len(i), LOOP_POINTS)]
    name = f"missing {panels(trace)[0].title}"
    with svg.style():
        figure = Figure(figsize=(9.6, 3.5))
        room = {"left": 0.055, "right": 0.99, "bottom": 0.13, "top": 0.92, "wspace": 0.14}
        left, right = figure.subplots(1, 2, gridspec_kw=room)
        if cyclic(trace):
            speed = trace.inputs.get("v", np.gradient(z, trace.x))
            rate = units.get("v", f"{unit}/s" if unit else "")
            _over(left, z, trace, i, label(stroke, unit))
            _over(right, speed, trace, i, label("speed", rate))
        else:
            later = i[trace.x[i] > 0]
            _over(
                left,
                trace.x,
                trace,
                later,
                label(trace.axis, trace.axis_unit),
                wants_log(trace.x[later], 100),
            )
            _over(right, z, trace, i, label(stroke, unit))
        for axes in (left, right):
            axes.set_title(name)
        beside = "speed" if cyclic(trace) else trace.axis
        return svg.inline(figure, f"{name} over {stroke} and {beside} in {trace.name}", key)


def _over(axes: Axes, x: Array, trace: Trace, i: Array, title: str, log: bool = False) -> None:
    dots(axes, x[i], (trace.data - trace.before)[i], svg.DATA, 3.4)
    if not same_model(trace):
        axes.plot(x[i], (trace.after - trace.before)[i], color=svg.AFTER, linewidth=1.3)
    axes.axhline(0, color=svg.MUTED, linewidth=0.6)
    axes.set_xlabel(title)
    if log:
        axes.set_xscale("log")
        log_ticks(axes.xaxis, x[i])
    else:
        linear_ticks(axes.xaxis)
    linear_ticks(axes.yaxis)
