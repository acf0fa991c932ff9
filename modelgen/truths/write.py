"""Write a case as a stranger would: recordings and what is known, nothing of what is concealed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .drawing import scene_of
from .drive import Motion
from .further import entries
from .impedance import frequencies
from .noise import calibration, disturb_impedance, disturb_real, stated
from .secret import Secret

MODELS = {
    "impedance": "electrodynamic_transducer",
    "gmm": "magnetostrictive_transducer",
    "force": "modified_dahl",
    "stiffness": "complex_stiffness",
}
Table = tuple[list[str], list[npt.NDArray[np.float64]]]


def write_case(secret: Secret, folder: str | Path) -> Path:
    """Simulate a secret, disturb the recordings, and write case.toml with rec_1.csv … into a folder.

    Returns the path of case.toml. The same secret gives the same bytes.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    clean = scene_of(secret).simulate(secret.strength)
    rng = np.random.default_rng([secret.seed, 7])
    tables = {"force": _force, "stiffness": _stiffness}.get(secret.domain, _impedance)(secret, clean, rng)
    for i, (header, columns) in enumerate(tables, 1):
        rows = "\n".join(",".join(f"{x:.9g}" for x in row) for row in zip(*columns, strict=True))
        (folder / f"rec_{i}.csv").write_text(f"{','.join(header)}\n{rows}\n", encoding="utf-8")
    path = folder / "case.toml"
    path.write_text(case_text(secret), encoding="utf-8")
    return path


def case_text(secret: Secret) -> str:
    """The text of case.toml."""
    setup = secret.setup
    lines = [f'model = "{MODELS[secret.domain]}"']
    if setup.get("per_recording"):
        lines.append(f"per_recording = {_value(setup['per_recording'])}")
    for name, table in (
        ("constants", setup["constants"]),
        ("noise", stated(secret.domain, secret.noise, secret.levels)),
    ):
        if table:
            lines += ["", f"[{name}]", *(f"{k} = {_value(v)}" for k, v in sorted(table.items()))]
    for i, record in enumerate(entries(setup), 1):
        lines += ["", "[[recording]]", f'file = "rec_{i}.csv"', f'role = "{record["role"]}"']
        if record.get("known"):
            lines.append(f"constants = {_inline(record['known'])}")
        if own := _quieter(secret, record):
            lines.append(f"noise = {_inline(own)}")
    return "\n".join(lines) + "\n"


def _quieter(secret: Secret, record: Mapping[str, Any]) -> dict[str, Any]:
    """What is said of the noise of a recording that is the mean of several; a calibration error stays."""
    times = record.get("averaged", 1)
    told = stated(secret.domain, secret.noise, secret.levels) if times > 1 else {}
    return {n: float(f"{x / times**0.5:.4g}") for n, x in told.items() if isinstance(x, float)}


GROSS = 6.0
"""Deviations from the median of repeated readings, in their standard deviations, that nobody averages."""


def _averaged(
    record: Mapping[str, Any], levels: Mapping[str, float], once: Callable[[], npt.NDArray[Any]]
) -> npt.NDArray[Any]:
    """A disturbed channel; or the mean of as many as were averaged, without gross errors where there are
    some."""
    readings = np.stack([once() for _ in range(record.get("averaged", 1))])
    good = np.ones(readings.shape, bool)
    if len(readings) > 1 and levels.get("share"):
        middle = np.median(readings.real, axis=0)
        if np.iscomplexobj(readings):
            middle = middle + 1j * np.median(readings.imag, axis=0)
        off = np.abs(readings - middle)
        good = off <= GROSS * np.median(off, axis=0) / 0.6745
    return np.asarray(np.where(good, readings, 0).sum(axis=0) / good.sum(axis=0))


def _inline(table: Mapping[str, Any]) -> str:
    return "{ " + ", ".join(f"{k} = {_value(v)}" for k, v in sorted(table.items())) + " }"


def _value(v: Any) -> str:
    if isinstance(v, str):
        return f'"{v}"'
    if isinstance(v, list | tuple):
        return "[" + ", ".join(_value(x) for x in v) + "]"
    return repr(float(v))


def _impedance(secret: Secret, clean: Sequence[npt.NDArray[Any]], rng: np.random.Generator) -> list[Table]:
    f = [frequencies(s) for s in entries(secret.setup)]
    own = np.random.default_rng([secret.seed, 9])  # so that a further sweep changes none of the first
    smooth = calibration(own, f, len(secret.setup["sweeps"]), secret.levels)
    noisy = [
        _averaged(e, secret.levels, partial(disturb_impedance, rng, eps, z, secret.levels))
        for e, eps, z in zip(entries(secret.setup), smooth, clean, strict=True)
    ]
    header = ["f [Hz]", "Re Z [ohm]", "Im Z [ohm]"]
    return [(header, [x, z.real, z.imag]) for x, z in zip(f, noisy, strict=True)]


def _force(secret: Secret, clean: Sequence[npt.NDArray[Any]], rng: np.random.Generator) -> list[Table]:
    header, levels, tables = ["t [s]", "z [mm]", "F_m [N]"], secret.levels, []
    only_step = {"step": levels["step"]} if "step" in levels else {}
    for record, F in zip(entries(secret.setup), clean, strict=True):
        m = Motion(record["motion"], record["rate"], record["seconds"], record["pre"])
        z = _averaged(record, {}, partial(disturb_real, rng, m.recorded(m.zva[0]), levels["z"], only_step))
        t = np.arange(len(F)) / record["rate"]
        noisy = _averaged(record, levels, partial(disturb_real, rng, F, levels["F_m"], levels))
        tables.append((header, [t, z, noisy]))
    return tables


def _stiffness(secret: Secret, clean: Sequence[npt.NDArray[Any]], rng: np.random.Generator) -> list[Table]:
    header, tables = ["f [Hz]", "k_s [N/mm]", "loss_angle [deg]"], []
    for sweep, y in zip(entries(secret.setup), clean, strict=True):
        f = frequencies(sweep)
        channels = [
            _averaged(sweep, secret.levels, partial(disturb_real, rng, row, secret.levels[n], secret.levels))
            for row, n in zip(y, ("k_s", "loss_angle"), strict=True)
        ]
        tables.append((header, [f, *channels]))
    return tables
