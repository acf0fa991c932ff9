"""A paper as data: tables of published numbers, studies of ours beside them, and figures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from modelgen.papers.number import Published

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

Cell = str | float


@dataclass(frozen=True)
class Table:
    """A table of the paper, or numbers of its text: `name` as in the paper, "Table 3", "Sec. 3.1"."""

    name: str
    caption: str
    numbers: tuple[Published, ...]


@dataclass(frozen=True)
class Found:
    """What a study found: sentences, and a table of ours, rows as long as `columns`, of numbers or prose."""

    says: tuple[str, ...]
    columns: tuple[str, ...] = ()
    rows: tuple[tuple[Cell, ...], ...] = ()
    prose: bool = False


@dataclass(frozen=True)
class Study:
    """Something that the paper does not show and a reader should know; `run` takes seconds."""

    title: str
    run: Callable[[], Found]


@dataclass(frozen=True)
class Figure:
    """A figure of the paper drawn from the model. `draw` fills a canvas of `size` [inch]."""

    name: str
    title: str
    says: str
    draw: Callable[[Canvas], None]
    size: tuple[float, float] = (9.0, 3.4)


@dataclass(frozen=True)
class Paper:
    """A paper and all that is computed anew for it."""

    id: str
    title: str
    tables: tuple[Table, ...]
    studies: tuple[Study, ...] = ()
    figures: tuple[Figure, ...] = ()
