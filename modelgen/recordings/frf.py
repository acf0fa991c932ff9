"""Frequency response functions from a CSV: `f [Hz]`, then pairs `Re H [unit]`, `Im H [unit]` or `|H| [unit]`,
`phase H [deg]`, one pair for each response."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from modelgen.errors import InputError, did_you_mean
from modelgen.recordings.convert import affine
from modelgen.recordings.table import Column, Table, fail, read_table

Array = np.ndarray[Any, np.dtype[Any]]
PAIR = {"Re": "Im", "||": "phase"}


@dataclass(frozen=True, eq=False)
class Frf:
    """Responses H (responses, n) to one excitation at the frequencies f (n,) [Hz], ascending.

    Time convention e^{+jωt}. units: of each response.
    """

    f: Array
    H: Array
    names: tuple[str, ...]
    units: tuple[str, ...]

    def between(self, low: float, high: float) -> Frf:
        """The part from `low` to `high` [Hz]. Raises InputError when nothing is there."""
        inside = (self.f >= low) & (self.f <= high)
        if not inside.any():
            raise InputError(
                f"no sample from {low:g} Hz to {high:g} Hz: the record runs from "
                f"{self.f[0]:g} Hz to {self.f[-1]:g} Hz"
            )
        return Frf(self.f[inside], self.H[:, inside], self.names, self.units)


def read_frf(path: str | Path) -> Frf:
    """Read all responses of a file. Raises InputError, one line with file and column, for what is wrong."""
    table = read_table(Path(path))
    parts = {_part(c): c for c in table.columns}
    axis = parts.pop(("value", "f"), None)
    if axis is None:
        hint = did_you_mean("f", [c.name for c in table.columns])
        raise fail(f"{table.at()}: no column 'f [Hz]'{hint}")
    pairs = [(n, c, _twin(table, parts, kind, n), kind) for (kind, n), c in parts.items() if kind in PAIR]
    if not pairs:
        raise fail(
            f"{table.at()}: no response, wanted columns 'Re H [unit]' and 'Im H [unit]', or |H| and phase"
        )
    scale = [(axis, "Hz")] + [(b, "deg") for _, _, b, kind in pairs if kind == "||"]
    factors = {c.index: _affine(table, c, unit) for c, unit in scale}
    wanted = [axis, *(c for _, a, b, _ in pairs for c in (a, b))]
    numbers = table.numbers(wanted)
    raw = [x * factors[c.index] if c.index in factors else x for x, c in zip(numbers, wanted, strict=True)]
    f = raw[0]
    order = np.argsort(f, kind="stable")
    if np.any(f <= 0) or np.any(np.diff(f[order]) == 0):
        raise fail(f"{table.at(axis)}: frequencies above zero, each once, are wanted")
    H = [
        x + 1j * y if kind == "Re" else x * np.exp(1j * np.radians(y))
        for x, y, (_, _, _, kind) in zip(raw[1::2], raw[2::2], pairs, strict=True)
    ]
    return Frf(
        f[order], np.array(H)[:, order], tuple(p[0] for p in pairs), tuple(p[1].unit or "1" for p in pairs)
    )


def _part(column: Column) -> tuple[str, str]:
    """("Re", "H") of a column "Re H", ("||", "H") of "|H|", ("phase", "") of "phase"."""
    found = re.fullmatch(r"(Re|Im|phase)(?:[ _](.+))?|\|(.+)\||(.+)", column.name)
    kind, name, modulus, plain = found.groups() if found else (None, None, None, column.name)
    if modulus:
        return "||", modulus
    return (kind, name or "") if kind else ("value", plain)


def _twin(table: Table, parts: dict[tuple[str, str], Column], kind: str, name: str) -> Column:
    other = PAIR[kind]
    column = parts.get((other, name)) or (parts.get((other, "")) if other == "phase" else None)
    if column is None:
        raise fail(f"{table.at(parts[kind, name])}: '{other} {name}' is missing beside it")
    if kind == "Re" and column.unit != parts[kind, name].unit:
        raise fail(f"{table.at(column)}: its unit is not that of '{parts[kind, name].title}'")
    return column


def _affine(table: Table, column: Column, wanted: str) -> float:
    if column.unit is None:
        raise fail(f"{table.at(column)}: no unit, wanted '{column.name} [{wanted}]'")
    try:
        return affine(column.unit, wanted)[0]
    except InputError as why:
        raise fail(f"{table.at(column)}: {why}") from why
