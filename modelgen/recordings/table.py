"""CSV with one header line of `name [unit]`: read fast, and when a cell is wrong, say which one.

Text of other programs as well: columns apart by blanks, comments that start with an asterisk, and impedances
as loudspeaker programs exchange them (.zma), which have no header.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date, time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import InputError, did_you_mean
from modelgen.files import leads_nowhere

HUGE = 1e60
"""No measured number is above it, and squares of squares of what is below do not overflow."""


def fail(message: str) -> InputError:
    """An InputError of one line, whatever the user's names and cells contain."""
    return InputError(" ".join(message.splitlines()))


def show(text: object) -> str:
    """A value as found, as its file spells it, on one line, and no longer than a message can bear."""
    if isinstance(text, date | time):  # as TOML reads 2024-01-01 and 08:30:00
        return f"the {'date' if isinstance(text, date) else 'time'} {text}"
    full = str(text).lower() if isinstance(text, bool) else repr(text)
    return full if len(full) <= 60 else full[:56] + "...'"


PACKED = {
    b"\x1f\x8b": "compressed by gzip; unpack it first",
    b"PK\x03\x04": "a zip archive or a spreadsheet, not text; save the sheet as CSV",
    b"\xff\xfe": "UTF-16 text; save it as UTF-8",
    b"\xfe\xff": "UTF-16 text; save it as UTF-8",
}
"""What files begin with that are no text as it is read here."""


def read_text(path: Path) -> str:
    """The text of a regular UTF-8 file, byte-order mark or not. Raises InputError when there is none."""
    try:
        if leads_nowhere(path):
            raise fail(f"{path}: it is a link that leads nowhere")
        if not path.exists():
            there = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
            raise fail(f"{path}: no such file{did_you_mean(path.name, there)}")
        if not path.is_file():  # a folder, or a device that never ends
            raise fail(f"{path}: not a regular file")
        data = path.read_bytes()
    except (OSError, ValueError) as why:  # ValueError: a null byte in the name
        raise fail(f"{show(str(path))}: can't be read ({getattr(why, 'strerror', None) or why})") from why
    for mark, what in PACKED.items():
        if data.startswith(mark):
            raise fail(f"{path}: {what}")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as why:
        line = data.count(b"\n", 0, why.start) + 1
        raise fail(
            f"{path}, line {line}: byte 0x{data[why.start]:02x} is not UTF-8 text; save it as UTF-8"
        ) from why
    if "\0" in text:
        raise fail(f"{path}, line {text.count(chr(10), 0, text.index(chr(0))) + 1}: binary data, not text")
    return text


@dataclass(frozen=True)
class Column:
    """One column as its header names it. `unit` is None where the header gives none."""

    index: int
    title: str
    name: str
    unit: str | None

    @staticmethod
    def read(index: int, cell: str) -> Column:
        title = " ".join(cell.split())
        found = re.fullmatch(r"(.*?)\s*\[([^\[\]]*)\]", title)
        if found:
            return Column(index, title, found[1], found[2].strip() or None)
        return Column(index, title, re.sub(r"\s*\(.*\)$", "", title) or title, None)


@dataclass(frozen=True)
class Table:
    """A CSV file: its columns, and its rows as text with their line numbers (1-based, shape (n,)).

    `mark` is the decimal mark: a comma where other marks separate columns, and a number has one.
    """

    path: Path
    header_line: int
    columns: tuple[Column, ...]
    lines: NDArray[np.int64]
    rows: Sequence[str]
    delimiter: str = ","
    mark: str = "."

    def at(self, column: Column | None = None, row: int | None = None) -> str:
        """The place of an error, as the start of its message."""
        line = self.header_line if row is None else int(self.lines[row])
        return f"{self.path}, line {line}" + (f", column {show(column.title)}" if column else "")

    def numbers(self, wanted: Sequence[Column]) -> NDArray[np.float64]:
        """The wanted columns as numbers, shape (len(wanted), n). Raises InputError at the first bad cell."""
        rows = self.rows
        if self.mark == ",":
            if any("." in row for row in rows):
                return self._cell_by_cell(wanted)
            rows = [row.replace(",", ".") for row in rows]
        try:
            apart = None if self.delimiter == " " else self.delimiter
            values = np.loadtxt(rows, delimiter=apart, comments=None, ndmin=2, dtype=np.float64)
        except ValueError:
            return self._cell_by_cell(wanted)
        if values.shape[1] == len(self.columns):
            picked = np.ascontiguousarray(values.T[[c.index for c in wanted]])
            if np.isfinite(picked).all():
                return picked
        return self._cell_by_cell(wanted)

    def _cell_by_cell(self, wanted: Sequence[Column]) -> NDArray[np.float64]:
        """The slow way: finds the bad cell; reads what the fast way can't (quotes, text in other columns)."""
        values = np.empty((len(wanted), len(self.rows)))
        for n, row in enumerate(self.rows):
            cells = split(row, self.delimiter)
            if len(cells) != len(self.columns):
                raise fail(
                    f"{self.at(row=n)}: {len(cells)} cells, but {len(self.columns)} columns in the header"
                )
            for k, column in enumerate(wanted):
                values[k, n] = self._number(cells[column.index], column, n)
        return values

    def _number(self, cell: str, column: Column, row: int) -> float:
        if self.mark == "," and "." in cell:  # 1.234 may be 1234 in a file with decimal commas
            raise fail(f"{self.at(column, row)}: {show(cell.strip())} has a point, others a decimal comma")
        try:  # Python would read 1_000
            value = math.nan if "_" in cell else float(cell.replace(self.mark, "."))
        except ValueError:
            value = math.nan
        if math.isfinite(value):
            return value
        found = f"{show(cell.strip())} is not a finite number" if cell.strip() else "the cell is empty"
        raise fail(f"{self.at(column, row)}: {found}")


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _starts(row: str) -> bool:
    """Whether a row is one of numbers, apart by blanks."""
    return all(map(_is_number, row.split()))


def split(row: str, delimiter: str = ",") -> list[str]:
    """The cells of one line; quotes are allowed, but for blanks between them."""
    if delimiter == " ":
        return row.split()
    try:
        return next(csv.reader([row], skipinitialspace=True, delimiter=delimiter), [])
    except csv.Error:
        return row.split(delimiter)


TITLE = re.compile(r"[^\s\[\]][^\[\]]*\[[^\[\]]*\]")
"""'name [unit]', where blanks separate columns."""
ZMA = ("f [Hz]", "|Z| [ohm]", "phase [deg]")
"""What the columns of a .zma file are."""


def _delimiter(header: str) -> str:
    """What separates columns: a comma; a semicolon or a tab in a header that has no comma; or blanks."""
    blank = " " if len(TITLE.findall(header)) > 1 else ","
    return next((d for d in (",", ";", "\t") if d in header), blank)


def _titles(header: str, delimiter: str) -> list[str]:
    return TITLE.findall(header) if delimiter == " " else split(header, delimiter)


def read_table(path: Path) -> Table:
    """Read header and rows of a CSV file.

    Lines that start with # or * are skipped, and those that are blank or have empty cells alone, as
    spreadsheets leave them.

    Semicolons, tabs or blanks may separate columns, and with them decimals may have commas.

    Raises InputError when the file is missing, not text, empty, or holds no more than a header.
    """
    text = read_text(path).replace("\r\n", "\n").replace("\r", "\n")
    rows = text.split("\n")
    kept = [n for n, row in enumerate(rows) if row.strip(" \t,;") and not row.lstrip().startswith(("#", "*"))]
    if not kept:
        raise fail(f"{path}: the file is empty; wanted a header of 'name [unit]' columns, then numbers")
    first = kept[0]
    delimiter = _delimiter(rows[first])
    if path.suffix.lower() == ".zma" and len(rows[first].split()) == len(ZMA) and _starts(rows[first]):
        columns = tuple(Column.read(i, cell) for i, cell in enumerate(ZMA))
        return Table(path, first + 1, columns, np.array(kept) + 1, [rows[n] for n in kept], " ")
    columns = tuple(Column.read(i, cell) for i, cell in enumerate(_titles(rows[first], delimiter)))
    if all(_is_number(c.title) for c in columns) or _starts(rows[first]):
        raise fail(f"{path}, line {first + 1}: {show(rows[first])} is no header of 'name [unit]' columns")
    if len(kept) == 1:
        raise fail(f"{path}, line {first + 1}: a header, but no data below it")
    lines = np.array(kept[1:], dtype=np.int64) + 1
    below = [rows[n] for n in kept[1:]]
    return Table(path, first + 1, columns, lines, below, delimiter, _mark(columns, below, delimiter))


def _mark(columns: Sequence[Column], rows: Sequence[str], delimiter: str) -> str:
    """The decimal mark by the columns that have a unit, as all that are wanted do: in remarks a comma is
    none."""
    places = [c.index for c in columns if c.unit]
    for row in rows if delimiter != "," else ():
        cells = split(row, delimiter) if "," in row else []
        found = [cells[k] for k in places if k < len(cells) and "," in cells[k]]
        if any(_is_number(cell.replace(",", ".")) for cell in found):
            return ","
    return "."
