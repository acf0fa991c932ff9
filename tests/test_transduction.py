"""Force factors that are no real constants, from closed forms of other shape than the catalogue's laws."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from coils import write_sweep

import modelgen as mg
from modelgen.diagnose import Verdict, diagnose

LOADS = {"none": 0.0, "some": 0.2, "more": 0.5}


def told(
    folder: Path, model: str, mass: float, f: np.ndarray, Z: Callable[[np.ndarray, float], np.ndarray]
) -> Verdict:
    """Of sweeps of Z(s, moving mass) at three known masses, the last one held out, with 0.1 % of noise."""
    rng = np.random.default_rng(11)
    text = f'model = "{model}"\n[noise]\nZ_relative = 1e-3\n'
    for name, load in LOADS.items():
        M = mass * (1 + load)
        noise = 1e-3 * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size))
        write_sweep(folder / f"{name}.csv", f, Z(2j * np.pi * f, M) * (1 + noise))
        role = "holdout" if name == "more" else "fit"
        text += f'[[recording]]\nfile = "{name}.csv"\nrole = "{role}"\nconstants = {{ M_m = {M} }}\n'
    (folder / "case.toml").write_text(text)
    base, case = mg.open_case(folder / "case.toml")
    return diagnose(case, base)


@pytest.mark.parametrize("angle", [0.0, pytest.param(0.02, marks=pytest.mark.slow)])
def test_a_crystal_whose_coupling_is_late_by_an_angle(tmp_path: Path, angle: float) -> None:
    """One strain constant d = |d| e^(−jθ) makes charge of force and force of voltage."""
    d = 1.2e-9 * np.exp(-1j * angle)

    def Z(s: np.ndarray, M: float) -> np.ndarray:
        stiffness = 4e7
        force_per_volt = d * stiffness
        speed_per_volt = force_per_volt / (M * s + 8.0 + stiffness / s)
        return 1 / (1.1e-9 * s + force_per_volt * speed_per_volt)

    found = told(tmp_path, "piezoelectric_transducer", 1.6e-3, np.geomspace(8e3, 6e4, 301), Z)
    if angle:
        (effect,) = found.effects
        assert effect.id == "transduction_loss"
        (value,) = (p for p in effect.parameters if p.name.endswith("tan_theta"))
        assert abs(value.value - np.tan(angle)) < 4 * value.std
        assert found.before.fit_over_noise > 1.3 and found.after.holdout_over_noise < 1.1
    else:
        assert found.adequate and not found.effects


@pytest.mark.slow
def test_a_tube_in_the_gap_screens_the_flux(tmp_path: Path) -> None:
    """The flux of a coil within a conducting tube, thin beside its skin and leaky: half of it links the tube,
    whose current is induced by it."""

    def Z(s: np.ndarray, M: float) -> np.ndarray:
        R, L, linked = 2e-4, 6e-8, 0.5
        I = -s * linked / (R + s * L)  # of the tube, per unit of flux
        Bl = 7.0 * (1 + linked * L * I * 0.4)
        return 4.2 + 8e-4 * s + Bl**2 / (M * s + 1.2 + 3e3 / s)

    found = told(tmp_path, "electrodynamic_transducer", 0.03, np.geomspace(8, 2000, 301), Z)
    (effect,) = found.effects
    assert effect.id == "flux_shielding", effect.id
    assert found.after.holdout_over_noise < 1.1 < 1.3 < found.before.fit_over_noise
