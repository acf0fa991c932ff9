"""The figure of what a model lacks in a time record: the force left over, over how the sample moves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from modelgen.fit.trace import Trace
from modelgen.report import svg
from modelgen.report.axes import dots, label, linear_ticks, log_ticks, wants_log
from modelgen.report.plots import LOOP_POINTS, panels, same_model, stroke_of
from modelgen.report.thin import Array, every, excerpt, upward
from modelgen.report.words import in_english
from modelgen.units import converts, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from modelgen.language import Model


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


def moves(unit: str) -> bool:
    """Whether what is in this unit can be a motion, a length or an angle; "" where the unit isn't known."""
    return not unit or converts(unit, "m") or converts(unit, "rad")


def lack(trace: Trace, units: Mapping[str, str], moving: bool, model: Model | None, key: str = "l") -> str:
    """Data minus model before, and model after minus before, over what they may depend on, as an SVG.

    Over stroke, speed and acceleration, in a stretch of about three cycles, the one missed most by the model
    before. Records without cycles are drawn over time and stroke: a relaxation is read over the log of time.
    So are those of what is not `moving` as recorded: what drives a model is not how it moves. `model` says
    which inputs are speed and acceleration.
    """
    from matplotlib.figure import Figure

    stroke = stroke_of(trace)
    misfit = np.sum(np.square(trace.white_before), axis=0)
    i = np.arange(len(trace.x))[excerpt(trace.inputs[stroke], misfit, fewest=400)]
    i = i[every(len(i), LOOP_POINTS)]
    shown = _motion(trace, units, model) if moving and cyclic(trace) else _time_and_stroke(trace, units)
    name = f"missing {panels(trace)[0].title}"
    with svg.style():
        figure = Figure(figsize=(9.6, 3.4))
        room = {"left": 0.055, "right": 0.99, "bottom": 0.13, "top": 0.92, "wspace": 0.18}
        for axes, (title, x) in zip(figure.subplots(1, len(shown), gridspec_kw=room), shown, strict=True):
            _over(axes, x, trace, i, x is trace.x)
            axes.set_xlabel(title)
        figure.axes[0].set_title(name)
        return svg.inline(figure, f"{name} in {trace.name} over {in_english(t for t, _ in shown)}", key)


def _motion(trace: Trace, units: Mapping[str, str], model: Model | None) -> list[tuple[str, Array]]:
    """Stroke, speed and acceleration with their labels; derivatives are the model's where it has them."""
    stroke = stroke_of(trace)
    own = {i.derived: i.name for i in model.inputs if i.name in trace.inputs} if model is not None else {}
    unit, x = units.get(stroke, ""), trace.inputs[stroke]
    moving = [(label(stroke, unit), x)]
    for title, kind in (("speed", "rate"), ("acceleration", "acceleration")):
        if (kind, stroke) in own:  # it may be in another unit: mm/s where the stroke is in µm
            name = own[kind, stroke]
            unit, x = units.get(name, ""), trace.inputs[name]
        else:
            unit, x = _per(unit, trace.axis_unit), np.gradient(x, trace.x)
        moving.append((label(title, unit), x))
    return moving


def _per(unit: str, axis_unit: str) -> str:
    """The unit of a derivative over the axis; "" where one of them isn't known."""
    return tidy(f"({unit})/({axis_unit})") if unit and axis_unit else ""


def _time_and_stroke(trace: Trace, units: Mapping[str, str]) -> list[tuple[str, Array]]:
    stroke = stroke_of(trace)
    return [
        (label(trace.axis, trace.axis_unit), trace.x),
        (label(stroke, units.get(stroke, "")), trace.inputs[stroke]),
    ]


def _over(axes: Axes, x: Array, trace: Trace, i: Array, time: bool) -> None:
    i = i[x[i] > 0] if time and wants_log(x[i][x[i] > 0], 100) else i
    dots(axes, x[i], (trace.data - trace.before)[i], svg.DATA, 3.6)
    if not same_model(trace):
        dots(axes, x[i], (trace.after - trace.before)[i], svg.AFTER, 1.8)
    axes.axhline(0, color=svg.MUTED, linewidth=0.6)
    if time and wants_log(x[i], 100):
        axes.set_xscale("log")
        log_ticks(axes.xaxis, x[i])
    else:
        linear_ticks(axes.xaxis, 5)
    linear_ticks(axes.yaxis)
