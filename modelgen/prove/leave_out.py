"""The MRE paper's Tab. 3, a frequency left out at a time: what the model without relaxation predicts of it.

|K*| at 0.4 mm and 1 to 9 Hz, four samples and fields. The modified Dahl model's spring and dashpot, two
parameters, against one springpot C (jω)^α, two parameters as well.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from modelgen.language import Model

TABLES = "s[12]_m[01]_0p4mm.csv"
NO_FRICTION = {"A_z": 0.4, "h_D": 0.0, "rho": 1.0}
EFFECT = "power_law_viscoelasticity"


@dataclass(frozen=True)
class LeftOut:
    """Rms relative errors of one table: of the fit to all its rows, and of each row predicted from the
    others."""

    name: str
    fit_before: float
    fit_after: float
    before: float
    after: float
    exponent: float


def leave_one_out(folder: Path) -> list[LeftOut]:
    """The errors of each table in the folder of the example; an empty list where the example isn't there."""
    from modelgen.effects import CATALOGUE
    from modelgen.models import load

    model = load("complex_stiffness")
    effect = next(e for e in CATALOGUE if e.id == EFFECT)
    extended = effect.extend(model, effect.fits(model)[0])
    found = []
    for path in sorted(folder.glob(TABLES)):
        rows = path.read_text(encoding="utf-8").splitlines()
        base = _errors(model, rows, NO_FRICTION)
        better = _errors(extended, rows, NO_FRICTION | {"k_D": 0.0, "c_D": 0.0})
        alpha = next(v for n, v in better.parameters.items() if "alpha" in n)
        name = path.stem.removesuffix("_0p4mm").replace("_", " ").upper()
        found.append(LeftOut(name, base.fit, better.fit, base.left_out, better.left_out, alpha))
    return found


@dataclass(frozen=True)
class Errors:
    """Rms relative errors, and the parameters fitted to all rows."""

    fit: float
    left_out: float
    parameters: Mapping[str, float]


def _errors(model: Model, table: Sequence[str], constants: Mapping[str, float]) -> Errors:
    header, *rows = table
    values = [float(row.split(",")[1]) for row in rows]
    whole, parameters = _fitted(model, header, rows, rows, constants)
    alone = [
        _fitted(model, header, [r for r in rows if r != row], [row], constants)[0] / value
        for row, value in zip(rows, values, strict=True)
    ]
    return Errors(whole / float(np.mean(values)), float(np.sqrt(np.mean(np.square(alone)))), parameters)


def _fitted(
    model: Model, header: str, rows: Sequence[str], held: Sequence[str], constants: Mapping[str, float]
) -> tuple[float, dict[str, float]]:
    """Rms error on `held` of the model fitted to `rows`, and its parameters."""
    from modelgen.fit.fitting import fit
    from modelgen.fit.series import signature_of
    from modelgen.recordings import load_case, read_case_file

    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        for name, part in (("fit", rows), ("holdout", held)):
            (folder / f"{name}.csv").write_text("\n".join([header, *part]) + "\n", encoding="utf-8")
        known = "\n".join(f"{n} = {v!r}" for n, v in constants.items())
        records = "".join(f'\n[[recording]]\nfile = "{n}.csv"\nrole = "{n}"\n' for n in ("fit", "holdout"))
        (folder / "case.toml").write_text(f'model = "{model.id}"\n[constants]\n{known}\n{records}')
        result = fit(model, load_case(read_case_file(folder / "case.toml"), signature_of(model)))
    rms = next(r.rms for r in result.recordings if r.role == "holdout")
    return rms, {e.name: e.value for e in result.parameters}
