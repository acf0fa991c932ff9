"""The figure of what is missing at a port, with the identified law through it, and what its slope says."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from modelgen.diagnose.verdict import PortCurve
from modelgen.report import svg
from modelgen.report.axes import dots, label, linear_ticks, log_ticks
from modelgen.report.thin import Array, every
from modelgen.report.words import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DOTS = 900


def port(curve: PortCurve, key: str = "c") -> str:
    """What would have to be added at a port, with the identified law through it, as an SVG."""
    from matplotlib.figure import Figure

    with svg.style():
        parts = _parts(curve)
        figure = Figure(figsize=(9.6, 3.5 if len(parts) > 1 else 3.9))
        room = {"left": 0.06, "right": 0.99, "bottom": 0.13, "top": 0.92, "wspace": 0.14}
        for axes, part in zip(
            figure.subplots(1, len(parts), squeeze=False, gridspec_kw=room)[0], parts, strict=True
        ):
            _part(axes, curve, *part)
        title = f"what the data imply at the {curve.port} port over {curve.x_name}: {curve.quantity}"
        return svg.inline(figure, f"{title}{'' if curve.law is None else ', with the identified law'}", key)


def _parts(curve: PortCurve) -> list[tuple[str, Array, Array | None, Array | None, bool]]:
    """(title, implied, its standard deviation, law, logarithmic) of each panel."""
    y, law, std = curve.implied, curve.law, curve.std
    if not np.iscomplexobj(y):
        return [(label(curve.quantity, curve.unit), y, std, law, False)]
    if not curve.log_x:
        real, imaginary = (None, None) if law is None else (law.real, law.imag)
        return [
            (label(f"{curve.quantity}, real part", curve.unit), y.real, std, real, False),
            (label("imaginary part", curve.unit), y.imag, std, imaginary, False),
        ]
    phase = np.degrees(np.angle(y))
    turn = None if law is None else np.degrees(np.angle(law))
    if turn is not None:
        phase = phase - 360 * np.round((phase - turn) / 360)
    spread = None if std is None else np.degrees(np.minimum(std / np.abs(y), np.pi))
    modulus = None if law is None else np.abs(law)
    return [
        (label(f"{curve.quantity}, modulus", curve.unit), np.abs(y), std, modulus, True),
        (label("phase", "deg"), phase, spread, turn, False),
    ]


def _part(
    axes: Axes, curve: PortCurve, title: str, y: Array, std: Array | None, law: Array | None, log: bool
) -> None:
    i = every(len(y), DOTS)
    x = curve.x
    known = determined(curve)
    if std is not None:
        low, high = y[i] - std[i], y[i] + std[i]
        floor = 0.05 * np.nanmin(y[known]) if log and known.any() else -np.inf
        axes.vlines(x[i], np.maximum(low, floor), high, color=svg.DATA, linewidth=1.0, alpha=0.6)
    dots(axes, x[i], y[i], svg.DATA, 3.4)
    if law is not None:
        k = np.argsort(x, kind="stable")
        axes.plot(x[k], law[k], color=svg.AFTER, linewidth=1.8)
    axes.set_title(title)
    axes.set_xlabel(label(curve.x_name, curve.x_unit))
    _limits(axes, y[known] if known.any() else y, law, log)
    if curve.log_x and np.all(x > 0):
        axes.set_xscale("log")
        log_ticks(axes.xaxis, x)
    else:
        linear_ticks(axes.xaxis)
        axes.axhline(0, color=svg.MUTED, linewidth=0.6)


def _limits(axes: Axes, y: Array, law: Array | None, log: bool) -> None:
    """Room for what is determined and for the law, not for the noise beside them."""
    both = y if law is None else np.concatenate([y, law])
    both = both[np.isfinite(both) & ((both > 0) | (not log))]
    if not both.size:
        return
    if log:
        low, high = float(both.min()) / 1.6, float(both.max()) * 1.6
        axes.set_ylim(low, high)  # first: what lies far off would overflow in a logarithmic axis of its own
        axes.set_yscale("log")
        log_ticks(axes.yaxis, np.array([low, high]))
        return
    low, high = np.min(both), np.max(both)
    room = 0.12 * (high - low) or abs(high) or 1.0
    axes.set_ylim(low - room, high + room)
    linear_ticks(axes.yaxis)


def determined(curve: PortCurve) -> Array:
    """Which samples of the implied quantity stand out of their own uncertainty."""
    finite = np.isfinite(curve.implied) & (np.abs(curve.implied) > 0)
    return finite if curve.std is None else finite & (np.abs(curve.implied) > 2 * curve.std)


def slope_and_phase(curve: PortCurve) -> tuple[float, float, bool] | None:
    """d ln|·| / d ln x and phase [deg] of what is determined, and whether both are constant there.

    Of the law, or of the implied quantity where there is none; None where it is not complex over a log axis.
    """
    known = determined(curve) & (curve.x > 0)
    if not np.iscomplexobj(curve.implied) or not curve.log_x or known.sum() < 5:
        return None
    order = np.argsort(curve.x[known], kind="stable")
    x = np.log(curve.x[known][order])
    y = (curve.implied if curve.law is None else curve.law)[known][order]
    if x[-1] - x[0] < 0.3 or np.any(y == 0):
        return None
    slope, offset = np.polyfit(x, np.log(np.abs(y)), 1)
    bend = np.log(np.abs(y)) - slope * x - offset
    phase = np.degrees(np.angle(y))
    most, turn = (0.15, 30.0) if curve.law is None else (0.05, 15.0)  # noise scatters the former
    steady = np.std(bend) < most and np.ptp(np.percentile(phase, (10, 90))) < turn
    return float(slope), float(np.median(phase)), bool(steady)


def slope_text(curve: PortCurve) -> str:
    """What slope and phase say, for the caption; "" where they say nothing."""
    found = slope_and_phase(curve)
    if found is None:
        return ""
    slope, phase, steady = found
    text = f"Slope {number(slope, 2)}, phase {phase:.0f}°".replace("-", "−")
    if not steady:
        return f"{text} on average; both change along the axis."
    meaning = _meaning(slope, phase, curve)
    return f"{text}{': ' + meaning if meaning else ''}."


def _meaning(slope: float, phase: float, curve: PortCurve) -> str:
    """The element that has this slope and phase, reckoned as an impedance."""
    shift = {"N/m": -1, "N/mm": -1, "H": 1}.get(curve.unit)  # Z = K/jω, Z = jωL
    if shift is None and curve.unit not in ("ohm", "N*s/m", "N*s/mm"):
        return ""
    slope, phase = slope + (shift or 0), phase + 90 * (shift or 0)
    coil = curve.unit in ("ohm", "H")
    elements = (
        (0, 0, "a resistance" if coil else "a dashpot"),
        (1, 90, "an inductance" if coil else "a mass"),
        (-1, -90, "a capacitance in series" if coil else "a spring"),
        (-1, 0, "a loss that does not depend on rate"),
        (0.5, 45, "the mark of diffusion"),
    )
    for s, p, element in elements:
        if abs(slope - s) < 0.06 and abs(phase - p) < 8:
            return element
    return "a power law, its phase that of its slope" if abs(phase - 90 * slope) < 8 else ""
