"""Tables in the terminal."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table


def table(*columns: str, left: Collection[int] = (0,)) -> Table:
    """A table whose columns hold numbers, but for those that are `left`: they hold text."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    made = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for k, name in enumerate(columns):  # as text: what stands in brackets is a unit, and no colour
        made.add_column(Text(name), justify="left" if k in left else "right", overflow="fold")
    return made
