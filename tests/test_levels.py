"""Sweeps of nonlinear devices at levels that nobody wrote down, driven by a voltage or by a current."""

from pathlib import Path

import numpy as np
import pytest
from coils import write_sweep

import modelgen as mg
from modelgen.diagnose import Verdict, diagnose

F = np.geomspace(8, 2000, 150)
S = 2j * np.pi * F


def swept(hard: float, drag: float, level: float, current: bool) -> np.ndarray:
    """A moving coil's impedance [ohm] with a spring that hardens by `hard` (x/mm)² and drag that grows
    by `drag` v/(0.4 m/s), x its displacement at `level` [A or V]: first harmonic, by iteration."""
    found = np.empty(F.size, complex)
    for k, s in enumerate(S):
        Z_e, x = 6 + 3e-4 * s, 0.0
        for _ in range(400):
            Z_m = 1.0 * (1 + drag * x * abs(s) / 400) + 0.013 * s + 2e3 * (1 + hard * x**2) / s
            Z = Z_e + 36 / Z_m
            x = 0.5 * x + 0.5 * 1e3 * abs(6 * level / (1 if current else Z) / (s * Z_m))
        found[k] = Z
    return found


def told(folder: Path, sweeps: list[np.ndarray]) -> Verdict:
    rng = np.random.default_rng(3)
    text = 'model = "electrodynamic_transducer"\n[constants]\nM_m = 0.013\n'
    for k, Z in enumerate(sweeps):
        Z = Z * (1 + 1e-3 * (rng.standard_normal(F.size) + 1j * rng.standard_normal(F.size)))
        write_sweep(folder / f"r{k}.csv", F, Z)
        text += f'[[recording]]\nfile = "r{k}.csv"\n'
    (folder / "case.toml").write_text(text)
    model, case = mg.open_case(folder / "case.toml")
    return diagnose(case, model)


@pytest.mark.parametrize(
    ("id", "hard", "drag", "level", "current"),
    [
        pytest.param("cubic_stiffness", 0.1, 0.0, 0.2, False, id="spring, voltage"),
        pytest.param("quadratic_damping", 0.0, 0.1, 0.2, False, id="drag, voltage", marks=pytest.mark.slow),
        pytest.param("cubic_stiffness", 0.1, 0.0, 0.03, True, id="spring, current"),
    ],
)
def test_levels_that_nobody_wrote_down(
    tmp_path: Path, id: str, hard: float, drag: float, level: float, current: bool
) -> None:
    """The device is the same in each sweep; no warmth has changed it."""
    (found,) = told(tmp_path, [swept(hard, drag, level * x, current) for x in (1, 1, 3)]).effects
    assert found.id == id
    own = {e.name.partition("[")[2]: abs(e.value) for e in found.parameters if "[" in e.name}
    assert own["r2]"] > 1.5 * max(own["r0]"], own["r1]"])  # the loud one


def test_a_voltage_brakes_what_it_drives(tmp_path: Path) -> None:
    """In one sweep at constant voltage, where the amplitude has no peak at resonance."""
    (found,) = told(tmp_path, [swept(0.0, 0.3, 1.5, current=False)]).effects
    assert found.id == "quadratic_damping"
    assert "R_v" in {e.name[:3] for e in found.parameters}
