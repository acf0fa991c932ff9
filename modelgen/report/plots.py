"""The figure of a recording: data against the model before and after, and the whitened residual of each."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from modelgen.diagnose.verdict import Mismatch
from modelgen.fit.trace import Trace
from modelgen.report import svg
from modelgen.report.axes import dots, fold, folded_ticks, label, linear_ticks, log_ticks, wants_log
from modelgen.report.thin import Array, every, excerpt, extremes
from modelgen.units import converts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

LINE_BINS, DOTS, LOOP_POINTS = 350, 900, 900
# Fixed margins: a layout engine would take as long as all the drawing.
UPPER = {"left": 0.068, "right": 0.99, "bottom": 0.57, "top": 0.95, "wspace": 0.14}
LOWER = UPPER | {"bottom": 0.09, "top": 0.42}
_NAMES = {"N": "force", "N/mm": "stiffness", "N/m": "stiffness", "mm": "displacement", "m": "displacement"}


@dataclass(frozen=True, eq=False)
class Panel:
    """One real quantity of a recording: what was measured, and the model before and after."""

    title: str
    data: Array
    before: Array
    after: Array
    log: bool = False


def panels(trace: Trace, name: str = "") -> list[Panel]:
    """The real quantities of a recording: modulus and phase of complex data. `name` is the output's."""
    name = name or ("Z" if trace.unit == "ohm" else _NAMES.get(trace.unit, "output"))
    three = (trace.data, trace.before, trace.after)
    if any(np.iscomplexobj(y) for y in three):
        modulus = [np.abs(y) for y in three]
        return [
            _panel(label(f"|{name}|", trace.unit), modulus, log=wants_log(modulus[0], 5)),
            _panel(label(f"phase of {name}", "deg"), _phases(*three)),
        ]
    if trace.measure == "modulus":
        return [_panel(label(f"|{name}|", trace.unit), three, log=wants_log(trace.data, 5))]
    if trace.measure == "phase":
        return [_panel(label(f"phase of {name}", trace.unit), three)]
    return [_panel(label(name, trace.unit), three)]


def _panel(title: str, values: Sequence[Array], log: bool = False) -> Panel:
    data, before, after = values
    return Panel(title, data, before, after, log)


def _phases(*values: Array) -> list[Array]:
    """Phases in degrees on one branch: the models' within half a turn of the data's."""
    data = np.degrees(np.unwrap(np.angle(values[0])))
    near = [np.degrees(np.angle(y)) for y in values[1:]]
    return [data, *(p - 360 * np.round((p - data) / 360) for p in near)]


def same_model(trace: Trace) -> bool:
    """Whether nothing was added to the model: before is after."""
    return np.array_equal(trace.before, trace.after, equal_nan=True)


def stroke_of(trace: Trace) -> str:
    """Name of the input that a force is drawn over: the displacement, or ""."""
    recorded = [k for k, v in trace.inputs.items() if k != trace.axis and len(v) == len(trace.x)]
    return "z" if "z" in recorded else next(iter(recorded), "") if converts(trace.axis_unit, "s") else ""


def recording(
    trace: Trace, mismatch: Iterable[Mismatch] = (), name: str = "", stroke_unit: str = "", key: str = "r"
) -> str:
    """One recording as an SVG: see `draw`."""
    from matplotlib.figure import Figure

    with svg.style():
        figure = Figure(figsize=(9.6, 5.0))
        shown = draw(figure, trace, mismatch, name, stroke_unit)
        return svg.inline(figure, _spoken(trace, shown), key)


def draw(
    figure: Figure | SubFigure,
    trace: Trace,
    mismatch: Iterable[Mismatch] = (),
    name: str = "",
    stroke_unit: str = "",
) -> list[Panel]:
    """One recording: data and model before and after, and below the whitened residual of each."""
    shown = panels(trace, name)
    stroke = stroke_of(trace)
    stroke_unit = stroke_unit or trace.units.get(stroke, "")
    marks = [m for m in mismatch if m.recording in ("", trace.name)]
    if stroke:
        over, loop = figure.subplots(1, 2, gridspec_kw=UPPER | {"width_ratios": (7, 5)})
        stretch = excerpt(trace.inputs[stroke], np.sum(np.square(trace.white_before), axis=0))
        _curves(over, trace, shown[0], stretch)
        _axis(over, trace, trace.x[stretch], marks)
        _loop(loop, trace, shown[0], stretch, stroke, stroke_unit, marks)
    else:
        upper = figure.subplots(1, len(shown), squeeze=False, gridspec_kw=UPPER)[0]
        for axes, panel in zip(upper, shown, strict=True):
            _curves(axes, trace, panel, slice(None))
            _axis(axes, trace, trace.x, marks)
    _residuals(figure, trace, marks)
    return shown


def _spoken(trace: Trace, shown: list[Panel]) -> str:
    what = " and ".join(p.title for p in shown)
    return f"{what} over {trace.axis}, recorded and modelled, and the whitened residual with the noise band"


def _curves(axes: Axes, trace: Trace, panel: Panel, stretch: slice) -> None:
    x = trace.x[stretch]
    ys = [np.asarray(y)[stretch] for y in (panel.data, panel.before, panel.after)]
    _recorded(axes, x, ys[0])
    if not same_model(trace):
        _line(axes, x, ys[1], svg.BEFORE, dashes=(4, 2))
    _line(axes, x, ys[2], svg.AFTER)
    out = trace.outliers[stretch]
    axes.plot(x[out], ys[0][out], "x", color=svg.MARK, markersize=6, markeredgewidth=1.3)
    axes.set_title(panel.title)
    if panel.log:
        axes.set_yscale("log")
        log_ticks(axes.yaxis, ys[0])
    else:
        linear_ticks(axes.yaxis)


def _recorded(axes: Axes, x: Array, y: Array) -> None:
    """Few samples are dots, many a broad pale line under the model's."""
    if len(y) <= 150:
        dots(axes, x, y, svg.DATA, 6.0 if len(y) < 30 else 4.5)
    else:
        i = extremes(y, LINE_BINS)
        axes.plot(x[i], y[i], color=svg.DATA, linewidth=4.4)


def _line(axes: Axes, x: Array, y: Array, color: str, dashes: tuple[float, ...] = ()) -> None:
    i = extremes(y, LINE_BINS)
    alone = "o" if len(y) == 1 else ""
    axes.plot(x[i], y[i], alone, color=color, linewidth=1.3, markersize=3, dashes=dashes or (None, None))


def _axis(axes: Axes, trace: Trace, x: Array, marks: list[Mismatch]) -> None:
    """The recording's own axis below: logarithmic over frequency, and the stretches where the model fails."""
    axes.set_xlabel(label(trace.axis, trace.axis_unit))
    if not converts(trace.axis_unit, "s") and wants_log(x, 4):
        axes.set_xscale("log")
        log_ticks(axes.xaxis, x)
    else:
        axes.margins(x=0.02)
        linear_ticks(axes.xaxis)
    _shade(axes, x, [m for m in marks if m.axis == trace.axis])


def _shade(axes: Axes, x: Array, marks: list[Mismatch]) -> None:
    low, high = float(np.nanmin(x)), float(np.nanmax(x))
    for m in marks:
        start, end = max(m.start, low), min(m.end, high)
        if start <= end:
            axes.axvspan(start, end, color=svg.SHADE, linewidth=0, zorder=0)


def _loop(
    axes: Axes, trace: Trace, panel: Panel, stretch: slice, stroke: str, unit: str, marks: list[Mismatch]
) -> None:
    z = np.asarray(trace.inputs[stroke])[stretch]
    ys = [np.asarray(y)[stretch] for y in (panel.data, panel.before, panel.after)]
    i = every(len(z), LOOP_POINTS)
    broad = 4.4 if len(z) > 150 else 2.2
    axes.plot(z[i], ys[0][i], color=svg.DATA, linewidth=broad, solid_joinstyle="round")
    if not same_model(trace):
        axes.plot(z[i], ys[1][i], color=svg.BEFORE, linewidth=1.3, dashes=(4, 2))
    axes.plot(z[i], ys[2][i], color=svg.AFTER, linewidth=1.3)
    axes.set_title(f"{panel.title} over {label(stroke, unit)}, same stretch")
    axes.set_xlabel(label(stroke, unit))
    linear_ticks(axes.xaxis)
    linear_ticks(axes.yaxis)
    _shade(axes, z, [m for m in marks if m.axis == stroke])


def _residuals(figure: Figure | SubFigure, trace: Trace, marks: list[Mismatch]) -> None:
    """Whitened residuals on one scale, linear to ±3 and logarithmic beyond, over the bands of ±1 and ±2."""
    whites = [("residual of the model, over the noise", trace.white_after, svg.AFTER)]
    if not same_model(trace):
        whites = [
            ("residual before, over the noise", trace.white_before, svg.BEFORE),
            ("residual after", trace.white_after, svg.AFTER),
        ]
    most = max(float(np.max(np.abs(w), initial=0.0, where=np.isfinite(w))) for _, w, _ in whites)
    lower = figure.subplots(1, len(whites), squeeze=False, gridspec_kw=LOWER)[0]
    for axes, (title, white, color) in zip(lower, whites, strict=True):
        _noise_band(axes)
        for c, channel in enumerate(white):
            kept = np.where(trace.outliers, np.nan, channel)
            _residual(axes, trace.x, fold(kept), color, 0.5 if c else 1.0)
        out = trace.x[trace.outliers]
        out = out[every(len(out), 200)]
        foot, across = (
            np.full(len(out), 0.05),
            axes.get_xaxis_transform(),
        )  # without weight
        axes.plot(out, foot, "x", color=svg.MARK, markersize=6, markeredgewidth=1.3, transform=across)
        axes.set_title(title)
        folded_ticks(axes, most)
        _axis(axes, trace, trace.x, marks)


def _residual(axes: Axes, x: Array, y: Array, color: str, alpha: float) -> None:
    if len(y) <= DOTS:
        dots(axes, x, y, color, 5.0 if len(y) < 30 else 2.6, alpha)
    else:
        i = extremes(y, LINE_BINS)
        axes.plot(x[i], y[i], color=color, linewidth=0.7, alpha=alpha)


def _noise_band(axes: Axes) -> None:
    for width in (2, 1):
        axes.axhspan(-width, width, color=svg.BAND, alpha=0.55, linewidth=0, zorder=0)
    for edge in (-2, -1, 1, 2):  # seen through dense residuals as well
        axes.axhline(edge, color=svg.INK, linewidth=0.6, alpha=0.6, dashes=(3, 3), zorder=3)
