"""Sweeps of a moving coil from closed forms, diagnosed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import modelgen as mg
from modelgen.diagnose import Verdict, diagnose

HEAD = """
model = "electrodynamic_transducer"
[noise]
Z_relative = 1e-3
[[recording]]
file = "sweep.csv"
"""


def coil(f: Any, eddy: Any = 0.0) -> Any:
    """A moving coil [ohm]."""
    s = 2j * np.pi * f
    return 6 + 3e-4 * s + eddy + 36 / (1 + 0.013 * s + 2e3 / s)


def write_sweep(file: Path, f: Any, Z: Any) -> None:
    """Z (n,) [ohm] at f (n,) [Hz] as a table."""
    rows = np.column_stack([f, Z.real, Z.imag])
    np.savetxt(file, rows, delimiter=",", header="f [Hz],Re Z [ohm],Im Z [ohm]", comments="")


def verdict(folder: Path, f: Any, Z: Any, head: str = HEAD) -> Verdict:
    """Of one sweep of Z (n,) [ohm] at f (n,) [Hz], with 0.1 % of noise."""
    rng = np.random.default_rng(5)
    Z = Z * (1 + 1e-3 * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size)))
    write_sweep(folder / "sweep.csv", f, Z)
    (folder / "case.toml").write_text(head)
    model, case = mg.open_case(folder / "case.toml")
    return diagnose(case, model)
