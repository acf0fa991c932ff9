"""Sweeps of a moving coil whose mass is known: a part of that mass which swings, and a meter that clips."""

from pathlib import Path

import numpy as np
import pytest
from coils import write_sweep

import modelgen as mg
from modelgen.diagnose import Verdict, diagnose

F = np.geomspace(15, 15000, 300)
S = 2j * np.pi * F


def _told(folder: Path, sweeps: dict[float, np.ndarray]) -> Verdict:
    """The verdict on sweeps Z (n,) [ohm] by the mass [kg] that is known of each, with noise of 3e-4."""
    rng = np.random.default_rng(8)
    text = 'model = "electrodynamic_transducer"\n[noise]\nZ_relative = 3e-4\n'
    for M_m, Z in sweeps.items():
        Z = Z + 3e-4 * np.abs(Z) * (rng.standard_normal(F.size) + 1j * rng.standard_normal(F.size))
        write_sweep(folder / f"m{M_m}.csv", F, Z)
        text += f'[[recording]]\nfile = "m{M_m}.csv"\nconstants = {{ M_m = {M_m} }}\n'
    (folder / "case.toml").write_text(text)
    model, case = mg.open_case(folder / "case.toml")
    return diagnose(case, model)


def _coil(M_m: float, loose: float = 0.0) -> np.ndarray:
    """Z of a coil with a mass of which the part `loose` [kg] hangs on a spring, 1.7 kHz and Q 15."""
    u = F / 1700
    swings = loose * (1 + 1j * u / 15) / (1 - u**2 + 1j * u / 15)
    return 7 + 6e-4 * S + 7.5**2 / (1.4 + (M_m - loose + swings) * S + 2600 / S)


def test_a_part_of_the_known_mass_swings(tmp_path: Path) -> None:
    (found,) = _told(tmp_path, {M: _coil(M, 1e-3) for M in (0.018, 0.03)}).effects
    assert found.id == "second_mode"
    own = {e.name: e.value for e in found.parameters}
    assert 2 * np.pi * 1700 / own["omega_5"] - 1 < 0.02 and abs(own["M_5"] / 1e-3 - 1) < 0.1


@pytest.mark.slow
def test_a_meter_that_clips_softly_is_no_drag(tmp_path: Path) -> None:
    Z = _coil(0.018)
    clipped = Z / (1 + (np.abs(Z) / 60) ** 6) ** (1 / 6)
    (found,) = _told(tmp_path, {0.018: clipped}).effects
    assert found.id.startswith("unknown_") and "meter" in found.says
