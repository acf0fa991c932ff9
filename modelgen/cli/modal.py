"""`modelgen modal`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

from modelgen.cli.console import check_output, console, spare
from modelgen.errors import InputError
from modelgen.fit.modal import ModalFit, fit_modes
from modelgen.recordings.frf import read_frf
from modelgen.report.table import table

if TYPE_CHECKING:
    from rich.console import Console

SCHEMA = "modelgen.modal/1"


def modal_case(
    path: Path, json: Path | None, low: float, high: float, modes: int | None, mass: float | None
) -> None:
    """Read, fit, print, and write the JSON."""
    check_output(json)
    spare((path,), json)
    if mass is not None and not (mass > 0 and math.isfinite(mass)):
        raise InputError(f"--mass {mass:g}: a mass above zero is wanted [kg]")
    if math.isnan(low) or math.isnan(high):
        raise InputError("--from, --to: frequencies are wanted [Hz], found nan")
    recorded = read_frf(path)
    try:
        found = fit_modes(recorded.between(low, high), modes)
    except InputError as why:
        raise InputError(f"{path}: {why}") from why
    if json is not None:
        _write(found, json, mass)
    _print(found, mass, console())


def _print(found: ModalFit, mass: float | None, to: Console) -> None:
    from rich.text import Text

    from modelgen.report.words import measured, number

    columns = ["mode", "f [Hz]", "damping ratio [%]", "share"]
    shown = table(*columns, *([f"2ξMω [N·s/m], M = {number(mass)} kg"] if mass else []))
    for k, m in enumerate(found.modes, 1):
        cells = [str(k), measured(m.f, m.f_std), measured(100 * m.xi, 100 * m.xi_std), number(m.share)]
        if mass:
            cells.append(measured(*m.damping(mass)))
        shown.add_row(*(Text(c) for c in cells))
    to.print(shown)
    f = found.frf.f
    to.print(
        Text(
            f"{len(found.frf.names)} responses, {f.size} frequencies from {number(f[0], 4)} Hz to "
            f"{number(f[-1], 4)} Hz; rms misfit {100 * found.misfit:.2g} % of the responses' rms"
        )
    )


def _write(found: ModalFit, path: Path, mass: float | None) -> None:
    import json

    from modelgen.files import write_atomically

    modes = []
    for m in found.modes:
        R, R_std = m.damping(mass) if mass else (None, None)
        modes.append(
            {
                "f": {"value": m.f, "std": m.f_std, "unit": "Hz"},
                "xi": {"value": m.xi, "std": m.xi_std, "unit": "1"},
                "share": m.share,
                "damping": None if R is None else {"value": R, "std": R_std, "unit": "N*s/m", "mass": mass},
            }
        )
    whole = {"schema": SCHEMA, "modes": modes, "misfit": found.misfit, "responses": list(found.frf.names)}
    write_atomically(path, json.dumps(whole, indent=1, allow_nan=False) + "\n")
