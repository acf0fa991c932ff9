"""Frequency response functions from a CSV: `f [Hz]`, then pairs `Re H [unit]`, `Im H [unit]` or `|H| [unit]`,
`phase H [deg]`, one pair for each response."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from modelgen.errors import InputError
from modelgen.recordings.columns import read_channels
from modelgen.recordings.convert import linear
from modelgen.recordings.signature import Channel, Signature
from modelgen.recordings.table import Column, Table, fail, read_table

Array = np.ndarray[Any, np.dtype[Any]]
FREQUENCY = Channel("f", "Hz")
RESPONSE = re.compile(r"Re (?P<re>.+)|\|(?P<modulus>.+)\||abs[ _](?P<abs>.+)")


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
            empty = "" if low <= high else ", whose end is below its beginning"
            raise fail(
                f"no sample from {low:g} Hz to {high:g} Hz{empty}: the record runs from "
                f"{self.f[0]:g} Hz to {self.f[-1]:g} Hz"
            )
        return replace(self, f=self.f[inside], H=self.H[:, inside])


def read_frf(path: str | Path) -> Frf:
    """Read all responses of a file. Raises InputError, one line with file and column, for what is wrong."""
    table = read_table(Path(path))
    responses: dict[str, Channel] = {}
    for column in table.columns:
        found = RESPONSE.fullmatch(column.name)
        if found is not None and found.lastgroup is not None:
            name = found[found.lastgroup]
            responses.setdefault(name, Channel(name, _unit(table, column), complex=True))
    if not responses and any(c.name == FREQUENCY.name for c in table.columns):
        raise fail(
            f"{table.at()}: no response, wanted columns 'Re H [unit]' and 'Im H [unit]', or |H| and phase"
        )
    read = read_channels(
        table, Signature("a frequency response", (FREQUENCY,), tuple(responses.values()), {}, FREQUENCY.name)
    )
    for name, kind in read.kinds.items():
        if kind != "complex":
            raise fail(f"{table.at()}: 'phase {name}' is missing beside '|{name}|'")
    order = np.argsort(read.inputs[FREQUENCY.name])
    H = np.array([read.outputs[name] for name in responses])
    units = tuple(c.unit for c in responses.values())
    return Frf(read.inputs[FREQUENCY.name][order], H[:, order], tuple(responses), units)


def _unit(table: Table, column: Column) -> str:
    """The column's unit. Raises InputError when it has none, or one that is logarithmic."""
    if column.unit is None:
        raise fail(f"{table.at(column)}: no unit, wanted such as '{column.name} [m/s]', or [1] for none")
    try:
        return linear(column.unit)
    except InputError as why:
        raise fail(f"{table.at(column)}: {why}") from why
