"""`modelgen fit`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from modelgen.api import open_case
from modelgen.cli.console import check_outputs, console, progress_bar, spare
from modelgen.cli.methods import read_method
from modelgen.errors import InputError
from modelgen.fit.farm import dask_executor
from modelgen.fit.fitting import fit
from modelgen.fit.multistart import MultiStart
from modelgen.fit.recipe import Recipe
from modelgen.fit.result import FitResult
from modelgen.report.fits import plot_format
from modelgen.report.table import table

if TYPE_CHECKING:
    from rich.console import Console


def fit_case(
    path: Path,
    json: Path | None,
    plot: Path | None,
    method: str | None,
    start: Sequence[str],
    seed: int,
    constrained: bool = False,
    dask: str = "",
) -> None:
    """Fit, print, and write the JSON and the plot. dask: the scheduler of a cluster where starts run."""
    check_outputs(json, plot)
    if plot is not None:
        plot_format(plot)
    chosen, begin = read_method(method), read_start(start)
    if plot is not None and isinstance(chosen, Recipe):
        raise InputError(f"--plot {plot}: a fit in stages ({method}) has no plot")
    if dask and not (chosen is None or isinstance(chosen, MultiStart)):
        raise InputError(f"--dask {dask}: it runs the starts of a multi-start, and '{method}' is none")
    model, case = open_case(path)
    spare(case.files, json, plot)
    elsewhere = dask_executor(dask) if dask else nullcontext()
    with elsewhere as executor, progress_bar(f"fitting {model.id}") as show:

        def tell(done: float, best: float) -> None:
            show(done, f"r·r {best:.6g}")

        result = fit(model, case, chosen, seed, tell, begin, constrained, executor)
    if json is not None:
        result.write_json(json)
    if plot is not None:
        result.plot(plot)
    print_fit(result, console())


def read_start(entries: Sequence[str]) -> dict[str, float]:
    """NAME=VALUE entries as a table. Raises InputError."""
    found = {}
    for entry in entries:
        name, _, value = entry.partition("=")
        if name.strip() in found:
            raise InputError(f"--start {entry}: '{name.strip()}' is given twice")
        try:
            found[name.strip()] = float(value)
        except ValueError:
            raise InputError(f"--start {entry}: NAME=VALUE is wanted, VALUE a number") from None
        if not math.isfinite(found[name.strip()]):
            raise InputError(f"--start {entry}: a finite number is wanted")
    return found


def print_fit(result: FitResult, to: Console) -> None:
    """Parameters, how well each recording is met, and what the data leave open."""
    from rich.text import Text

    from modelgen.report.words import measured, number, unit_cell, unit_text

    shown = table(result.model, "value", "unit", "")
    for e in (*result.parameters, *result.refitted):
        mark = "not determined" if not e.determined else "on its bound" if e.at_bound else ""
        marks = ("refitted on the hold-out" if e in result.refitted else "", mark)
        row = (e.name, measured(e.value, e.std), unit_cell(e.unit), ", ".join(filter(None, marks)))
        shown.add_row(*(Text(cell) for cell in row))
    to.print(shown)
    met = table("recording", "role", "points", "rms", "over noise")
    for r in result.recordings:
        sizes = [f"{number(o.rms)} {unit_text(o.unit)}".rstrip() for o in r.outputs]
        ratios = [number(o.rms_over_noise) for o in r.outputs]
        over = number(r.rms_over_noise) + (f" ({', '.join(ratios)})" if len(ratios) > 1 else "")
        cells = (r.file, r.role, str(r.points), ", ".join(sizes), over)
        met.add_row(*(Text(cell) for cell in cells))
    to.print()
    to.print(met)
    to.print()
    for line in (*result.undetermined, *result.notes, f"{result.method}: {result.reason}"):
        to.print(Text(line))
    to.print(Text(f"{result.seconds:.2f} s"))
