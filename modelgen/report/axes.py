"""Labels and ticks of the figures: few, round, and in plain text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from modelgen.report.thin import Array
from modelgen.report.words import superscript, unit_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LINEAR_TO = 3.0  # whitened residuals are drawn linearly to three standard deviations
PER_DECADE = 2.0


def label(name: str, unit: str) -> str:
    """A quantity with its unit: F [N]."""
    shown = unit_text(unit)
    return f"{name} [{shown}]" if shown else name


def wants_log(x: Array, ratio: float) -> bool:
    """Whether values are positive and span more than `ratio`."""
    finite = x[np.isfinite(x)]
    return bool(finite.size and finite.min() > 0 and finite.max() > ratio * finite.min())


def fold(y: Array) -> Array:
    """Whitened residuals as they are drawn: linear to ±3, then a decade every two units."""
    size = np.abs(y)
    far = LINEAR_TO + PER_DECADE * np.log10(np.maximum(size, LINEAR_TO) / LINEAR_TO)
    return np.asarray(np.sign(y) * np.where(size > LINEAR_TO, far, size))


def folded_ticks(axes: Axes, most: float) -> None:
    """Ticks of an axis of folded residuals up to ±`most`."""
    most = max(most, 4.0)
    far = [10.0**k for k in range(1, 13) if 10.0**k <= most]
    far = far[:: -(-len(far) // 3)] if far else []
    ticks = [-v for v in reversed(far)] + [-2.0, 0.0, 2.0] + far
    axes.set_yticks(fold(np.array(ticks)), [plain(v) for v in ticks])
    top = float(fold(np.array([1.3 * most]))[0])
    axes.set_ylim(-top, top)


def log_ticks(axis: Any, x: Array) -> None:
    """Ticks at 1, 2, 5 over a decade or two, at powers of ten over more, and none between; round ones as on
    a linear axis where hardly any of these lies inside."""
    from matplotlib.ticker import FixedLocator, NullLocator

    finite = x[np.isfinite(x) & (x > 0)]
    if not finite.size:
        return
    low, high = float(finite.min()), float(finite.max())
    decades = np.log10(high / low)
    first, last = int(np.floor(np.log10(low))), int(np.ceil(np.log10(high)))
    steps = (1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9) if decades < 0.7 else (1, 2, 5) if decades < 2.2 else (1,)
    every = max(1, round(decades / 6))
    ticks = [m * 10.0**k for k in range(first, last + 1, every) for m in steps]
    ticks = [v for v in ticks if low * 0.98 <= v <= high * 1.02]
    axis.set_minor_locator(NullLocator())
    if len(ticks) < 2:
        linear_ticks(axis, most=4)
        return
    axis.set_major_locator(FixedLocator(ticks))
    axis.set_major_formatter(lambda v, _: plain(v))


def linear_ticks(axis: Any, most: int = 7) -> None:
    """A few round ticks with as many figures as their distance needs, and no factor beside the axis."""
    from matplotlib.ticker import Formatter, MaxNLocator

    class Plain(Formatter):
        def __call__(self, v: float, pos: int | None = None) -> str:
            return plain(v)

        def format_ticks(self, values: list[float]) -> list[str]:
            size, step = np.max(np.abs(values), initial=0.0), np.min(np.diff(values), initial=np.inf)
            if not (np.isfinite(step) and 1e-3 <= size < 1e5 and step >= 1e-4):
                return told_apart(values)
            decimals = max(0, -int(np.floor(np.log10(step) + 1e-9)))
            return [f"{v + 0.0:.{decimals}f}".replace("-", "−") for v in np.round(values, 9)]

    axis.set_major_locator(MaxNLocator(most, steps=[1, 2, 5, 10]))
    axis.set_major_formatter(Plain())


def told_apart(values: Sequence[float]) -> list[str]:
    """Ticks with as many figures as no two of them look alike with."""
    for figures in range(4, 13):
        shown = [plain(v, figures) for v in values]
        if len(set(shown)) == len(set(values)):
            break
    return shown


def plain(v: float, figures: int = 4) -> str:
    """A tick: 0.05, 20, 5k, 10⁻⁶; a power's factor has one figure less than `figures`."""
    size = abs(v)
    if size == 0:
        return "0"
    if 1e-3 <= size < 1e3:
        text = f"{v:.{figures}g}"
    elif 1e3 <= size < 1e6:
        text = f"{v / 1e3:.{figures}g}k"
    else:
        exponent = int(np.floor(np.log10(size) + 1e-9))
        factor = f"{v / 10.0**exponent:.{figures - 1}g}"
        power = f"10{superscript(exponent)}"
        text = power if factor == "1" else f"-{power}" if factor == "-1" else f"{factor}·{power}"
    return text.replace("-", "−")


def dots(axes: Axes, x: Array, y: Array, color: str, size: float, alpha: float = 1.0) -> None:
    """Dots as strokes of hardly any length: a tenth of the text that as many markers would need."""
    x = np.asarray(x, dtype=float)
    gap = np.full_like(x, np.nan)
    span = float(np.nanmax(x) - np.nanmin(x)) if len(x) else 0.0
    if span == 0:
        axes.plot(x, y, "o", color=color, markersize=size, markeredgewidth=0, alpha=alpha)
        return
    end = x + 1e-8 * span  # of no length at all a PNG shows nothing
    xs, ys = np.stack([x, end, gap], axis=1).ravel(), np.stack([y, y, gap], axis=1).ravel()
    axes.plot(xs, ys, color=color, linewidth=size, solid_capstyle="round", alpha=alpha, snap=False)
