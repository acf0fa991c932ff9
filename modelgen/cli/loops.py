"""`modelgen loops`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from modelgen.cli.console import check_outputs, console, note, spare
from modelgen.errors import InputError
from modelgen.fit.loops import TEXT, UNIT, Loops, Shift, measure_loops, shift, strain, stress
from modelgen.recordings.columns import read_channels
from modelgen.recordings.signature import Channel, Signature
from modelgen.recordings.table import read_table
from modelgen.report.fits import plot_format
from modelgen.report.loops import write_loops
from modelgen.report.table import table

if TYPE_CHECKING:
    from rich.console import Console

SCHEMA = "modelgen.loops/1"
VARIES = 0.1
"""Part of the amplitude by which cycles may differ without a note."""
SWEPT = ("k_s", "c_loss", "h_s", "loss_angle")
COLUMNS = Signature(
    "a loop",
    (Channel("t", "s"), Channel("z", "mm")),
    (Channel("F", "N", measured_as=("F_m",)),),
    {},
    axis="t",
)


def loops_case(
    path: Path,
    against: Path | None,
    json: Path | None,
    plot: Path | None,
    skip: int,
    length: float | None,
    area: float | None,
) -> None:
    """Read, measure, print, and write the JSON and the plot."""
    check_outputs(json, plot)
    spare((path, against), json, plot)
    if plot is not None:
        plot_format(plot)
    for name, size, unit in (("--length", length, "mm"), ("--area", area, "mm²")):
        if size is not None and not (size > 0 and math.isfinite(size)):
            raise InputError(f"{name} {size:g}: a size above zero is wanted [{unit}]")
    if skip < 0:
        raise InputError(f"--skip {skip}: a number of cycles from 0 on is wanted")
    found = _measured(path, skip)
    moved = shift(_measured(against, skip), found) if against is not None else None
    ranges = _ranges(found, length, area)
    if json is not None:
        _write(found, ranges, moved, json)
    if plot is not None:
        write_loops(found, plot)
    _print(found, ranges, moved, console())


def _measured(path: Path, skip: int) -> Loops:
    channels = read_channels(read_table(path), COLUMNS)
    try:
        return measure_loops(channels.inputs["t"], channels.inputs["z"], channels.outputs["F"].real, skip)
    except InputError as why:
        raise InputError(f"{path}: {why}") from why


def _ranges(found: Loops, length: float | None, area: float | None) -> dict[str, tuple[float, float, str]]:
    """Range of strain (2) and stress (3), where the sample's size is given."""
    ranges = {}
    if length is not None:
        e = strain(found.z.mean(axis=0), length)
        ranges["strain"] = (float(e.min()), float(e.max()), "%")
    if area is not None:
        s = stress(found.F.mean(axis=0), area)
        ranges["stress"] = (float(s.min()), float(s.max()), "kPa")
    return ranges


def _print(
    found: Loops, ranges: dict[str, tuple[float, float, str]], moved: Shift | None, to: Console
) -> None:
    from rich.text import Text

    from modelgen.report.words import measured, number, unit_text

    if found.swept():
        shown = table("f [Hz]", *(f"{n} [{unit_text(UNIT[n])}]" for n in SWEPT), "cycles")
        for group in found.groups():
            mean = found.mean(group)
            cells = [number(mean["f"][0], 4), *(measured(*mean[n]) for n in SWEPT), str(group.size)]
            shown.add_row(*(Text(c) for c in cells))
        to.print(shown)
    else:
        shown = table("", "value", "unit", "of a cycle")
        shown.columns[3].justify = "left"
        for name, (value, std) in found.mean().items():
            shown.add_row(name, Text(measured(value, std)), Text(unit_text(UNIT[name])), Text(TEXT[name]))
        for name, (low, high, unit) in ranges.items():
            shown.add_row(name, Text(f"{number(low, 4)} to {number(high, 4)}"), unit, "range")
        to.print(shown)
        count, A = found.t.size, found.values["A_z"]
        to.print(Text(f"{count} cycle{'' if count == 1 else 's'}"))
        if A.max() - A.min() > VARIES * A.mean():
            note([f"amplitudes from {A.min():.3g} to {A.max():.3g} mm: figures are means of unlike cycles"])
    if moved is not None:
        to.print(Text(shift_text(moved)))


def shift_text(moved: Shift) -> str:
    """What stands between two recordings of one motion."""
    from modelgen.report.words import measured

    return (
        f"force against the other recording: {measured(moved.value, moved.std)} N on the mean; what is not "
        f"constant along the loop has an rms of {100 * moved.uneven:.2g} % of the force amplitude"
    )


def _write(
    found: Loops, ranges: dict[str, tuple[float, float, str]], moved: Shift | None, path: Path
) -> None:
    import json

    from modelgen.files import write_atomically
    from modelgen.fit.result import jsonable

    def figures(mean: dict[str, tuple[float, float]]) -> dict[str, Any]:
        return {n: {"value": v, "std": s, "unit": UNIT[n]} for n, (v, s) in mean.items()}

    groups = found.groups() if found.swept() else [slice(None)]
    whole = {
        "schema": SCHEMA,
        "cycles": found.t.size,
        "loops": [figures(found.mean(g)) for g in groups],
        "ranges": {n: {"from": a, "to": b, "unit": u} for n, (a, b, u) in ranges.items()},
        "shift": None
        if moved is None
        else {"value": moved.value, "std": moved.std, "unit": "N", "uneven": moved.uneven},
    }
    write_atomically(path, json.dumps(jsonable(whole), indent=1, allow_nan=False) + "\n")
