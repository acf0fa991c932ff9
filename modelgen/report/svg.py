"""A matplotlib figure as a small inline SVG in the page's colours, which follow light, dark and print."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
from io import StringIO
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Colours by their place in matplotlib's cycle, which `style` sets: one drawing serves a page and a file.
INK, MUTED, GRID, DATA, BEFORE, AFTER, MARK, BAND, SHADE = (f"C{k}" for k in range(9))
_VARIABLES = ("ink", "muted", "rule", "data", "before", "after", "mark", "band", "shade")
# Stand-ins for the page's CSS variables, told apart from every other colour by their value.
PAGE = tuple(f"#0102{k:02x}" for k in range(3, 3 + len(_VARIABLES)))
# Those of the page by daylight (templates/style.css).
PAPER = (
    "#1b1f24", "#5c6670", "#e3e6e9", "#9aa3ac", "#c2500a", "#0b66a8", "#a3227f", "#dfe5ea", "#fbf0d2",
)  # fmt: skip

_STYLE = {
    "svg.fonttype": "none",
    "path.simplify": False,
    "text.parse_math": False,  # a "$" in a unit is no formula
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.titlecolor": INK,
    "axes.labelsize": 9.0,
    "axes.labelcolor": MUTED,
    "axes.edgecolor": MUTED,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.5,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "text.color": INK,
    "lines.linewidth": 1.2,
    "lines.solid_capstyle": "round",
}
_GROUNDS = ("figure.facecolor", "savefig.facecolor", "axes.facecolor")


@contextmanager
def style(colours: tuple[str, ...] = PAGE) -> Iterator[None]:
    """Figures made inside look alike and print as text and plain paths."""
    from cycler import cycler
    from matplotlib import rc_context

    ground = "none" if colours is PAGE else "white"
    with rc_context(_STYLE | {"axes.prop_cycle": cycler(color=colours)} | dict.fromkeys(_GROUNDS, ground)):
        yield


def inline(figure: Figure, label: str, key: str) -> str:
    """The figure as an `<svg>` element; `label` is read out in its place, `key` sets its ids apart."""
    import matplotlib
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    out = StringIO()
    with matplotlib.rc_context({"svg.hashsalt": key}):
        FigureCanvasSVG(figure).print_svg(out, metadata={"Date": None, "Creator": None})
    text = out.getvalue()
    text = text[text.index("<svg") :]
    box = re.search(r'viewBox="([^"]+)"', text)
    body = text[text.index(">") + 1 :]
    body = re.sub(r"<metadata>.*?</metadata>|<style[^>]*>.*?</style>|<!--.*?-->", "", body, flags=re.S)
    body = re.sub(r'<g id="[^"]*"', "<g", body)  # nothing refers to groups
    body = _own_ids(body, key)
    body = re.sub(r"font: ([\d.]+px) [^;\"]*", r"font-size: \1", body)
    body = re.sub(r"<[^>]*>", lambda tag: re.sub(r"-?\d+\.\d{3,}", _shorter, tag[0]), body)  # texts stay
    body = re.sub(r"#0102[0-9a-f]{2}\b", _variable, body)
    body = re.sub(r"\s*\n\s*", "\n", body)
    head = f'<svg viewBox="{box[1] if box else ""}" role="img" aria-label="{escape(label)}">'
    return head + body


def _shorter(found: re.Match[str]) -> str:
    return f"{float(found[0]):.2f}".rstrip("0").rstrip(".")


def _variable(found: re.Match[str]) -> str:
    at = PAGE.index(found[0]) if found[0] in PAGE else -1
    return f"var(--{_VARIABLES[at]})" if at >= 0 else found[0]


def _own_ids(body: str, key: str) -> str:
    """Prefix the ids of clip paths and markers, and all references to them."""
    body = re.sub(r' id="(\w+)"', rf' id="{key}-\1"', body)
    return re.sub(r'(url\(#|href="#)(\w+)', rf"\1{key}-\2", body)
