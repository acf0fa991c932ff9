"""The plot of a fit: each recording against the model, and its residual over the noise."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from modelgen.errors import InputError
from modelgen.files import write_atomically
from modelgen.fit.result import FitResult
from modelgen.report import plots, svg
from modelgen.report.words import number

if TYPE_CHECKING:
    from matplotlib.figure import Figure, SubFigure

    from modelgen.fit.trace import Trace

FORMATS = (".svg", ".png", ".pdf")
MOST = 12  # recordings in one figure
LEFT = plots.UPPER["left"]
HEIGHT, DPI = 5.3, 130  # of one recording [in]


def plot_format(path: Path) -> str:
    """The format that a file's name asks for. Raises InputError for another than FORMATS."""
    if path.suffix.lower() not in FORMATS:
        raise InputError(f"cannot plot into {path}: the name must end in one of {', '.join(FORMATS)}")
    return path.suffix.lower()[1:]


def write_plot(result: FitResult, path: str | Path) -> None:
    """Draw a fit into a file, its format by its name: .svg, .png or .pdf. Whole or not at all.

    Raises InputError for another format, a missing folder or a fit in stages, ToolError when the system
    refuses.
    """
    path = Path(path)
    kind, out = plot_format(path), BytesIO()
    if not result.traces:
        raise InputError(f"a fit in stages has no plot: {path} is not written")
    with svg.style(svg.PAPER):
        metadata: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind, {})
        draw(result).savefig(out, format=kind, dpi=DPI, metadata=metadata)
    write_atomically(path, out.getvalue())


def draw(result: FitResult) -> Figure:
    """The figure: one block for each recording, those fitted worst if they are too many."""
    from matplotlib.figure import Figure

    over = {r.file: r.rms_over_noise for r in result.recordings}
    traces = result.traces
    if len(traces) > MOST:
        worst = sorted(traces, key=lambda t: -over.get(t.name, 0.0))[:MOST]
        traces = tuple(t for t in traces if t in worst)
    blocks = max(1, len(traces))
    figure = Figure(figsize=(9.6, HEIGHT * blocks + 0.35))
    room: Any = figure.subfigures(blocks + 1, 1, height_ratios=(0.35, *[HEIGHT] * blocks))
    shown = "" if len(traces) == len(result.traces) else f"; {MOST} of {len(result.traces)} recordings"
    room[0].text(LEFT, 0.2, f"{result.model}{shown}", fontsize=12, color=svg.INK)
    _legend(room[0])
    for block, trace in zip(room[1:], traces, strict=False):
        _block(block, trace, over.get(trace.name, float("nan")))
    return figure


def _block(block: Any, trace: Trace, over: float) -> None:
    head, body = block.subfigures(2, 1, height_ratios=(0.3, 5.0))
    plots.draw(body, trace)
    points = f"{len(trace.x)} point{'s' if len(trace.x) != 1 else ''}"
    role = ", held out" if trace.role == "holdout" else ""
    says = f"{trace.name}{role}: {points}, residual {number(over)} times the noise"
    head.text(LEFT, 0.3, says, fontsize=9.5, weight="bold", color=svg.INK)


def _legend(room: SubFigure) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    room.legend(
        handles=[
            Line2D([], [], color=svg.DATA, linewidth=4.4, label="recorded"),
            Line2D([], [], color=svg.AFTER, linewidth=1.3, label="model"),
            Patch(color=svg.BAND, label="noise, ±1 and ±2 standard deviations"),
        ],
        loc="lower right", bbox_to_anchor=(0.99, -0.05), ncols=3, frameon=False, labelcolor=svg.INK,
    )  # fmt: skip
