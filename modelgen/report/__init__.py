"""What a verdict looks like: one self-contained HTML page, and a few lines in the terminal."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from modelgen.report.html import write_html
    from modelgen.report.terminal import print_verdict

_HOME = {"write_html": "html", "print_verdict": "terminal"}

__all__ = ["print_verdict", "write_html"]


def __getattr__(name: str) -> Any:
    """Loads matplotlib and jinja2 only for a page, rich only for a terminal."""
    if name in _HOME:
        return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
