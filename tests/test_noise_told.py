"""What is told of the noise is not what the model misses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import modelgen as mg
from modelgen.diagnose.ground import prepare
from modelgen.diagnose.noise.floor import Scatter
from modelgen.diagnose.whole_ports import whole


def opened(folder: Path, model: str, header: str, rows: Any, more: str) -> tuple[Any, Any]:
    np.savetxt(folder / "r.csv", rows, delimiter=",", header=header, comments="")
    (folder / "case.toml").write_text(f'model = "{model}"\n{more}\n[[recording]]\nfile = "r.csv"\n')
    return mg.open_case(folder / "case.toml")


@pytest.mark.parametrize("modulus", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_resonance_that_is_missed_is_no_noise(tmp_path: Path, modulus: bool) -> None:
    """The base misses it by a hundred times the noise, which weights must not turn into scatter."""
    f, rng = np.geomspace(10, 3000, 500), np.random.default_rng(3)
    s = 2j * np.pi * f
    hung = 0.02 * s / (1 + s / 60 / 700 + (s / 700) ** 2)
    Z = 6 + 3e-4 * s + 36 / (1 + 0.013 * s + 2e3 / s + hung)
    Z *= 1 + 0.01 * (rng.standard_normal(500) + 1j * rng.standard_normal(500))
    columns = [f, np.abs(Z)] if modulus else [f, Z.real, Z.imag]
    head = "f [Hz],|Z| [ohm]" if modulus else "f [Hz],Re Z [ohm],Im Z [ohm]"
    noise = "[noise]\nZ_relative = 0.01"
    model, case = opened(tmp_path, "electrodynamic_transducer", head, np.column_stack(columns), noise)
    (series,) = prepare(whole(model), case, 0).series
    over = np.abs(series.whitener.weight).ravel() * series.size * 0.01
    assert np.median(over) == pytest.approx(1.0, abs=0.15)
    assert mg.diagnose(case, model).effects[0].id in ("second_mode", "contact_compliance")


def test_independent_noise_alternates_and_a_resonance_does_not() -> None:
    f, rng = np.geomspace(10, 3000, 500), np.random.default_rng(3)
    shape = np.where(f > 200, 1.0, 9.0)
    noise = np.sqrt(shape) * rng.standard_normal((1, 500))
    missed = 50 * np.exp(-((np.log(f / 60) / 0.05) ** 2))[None] * np.cos(40 * np.log(f))
    used = np.ones(496, dtype=bool)
    assert Scatter(noise, np.ones(500), used).alternates(shape)
    assert not Scatter(rng.standard_normal((1, 500)) + 20 * missed, np.ones(500), used).alternates(shape)


SWING = np.linspace(0, 8, 1500)


def rubbed(seed: int = 5) -> Any:
    rng = np.random.default_rng(seed)
    z, v = (
        2 * np.sin(2 * SWING) + 0.7 * np.sin(5.3 * SWING),
        4 * np.cos(2 * SWING) + 3.71 * np.cos(5.3 * SWING),
    )
    force = 3 * z + 0.4 * v + 4 * np.tanh(v / 0.5) + rng.normal(0, 0.1, SWING.size)
    return np.column_stack([SWING, z, force])


@pytest.mark.slow
def test_samples_that_the_laws_explain_are_no_outliers(tmp_path: Path) -> None:
    """At reversals the base's misfit stands alone."""
    t, rng = np.linspace(0, 4, 1000), np.random.default_rng(0)
    z = 3 * np.sin(2 * np.pi * t) + 1.2 * np.sin(5.4 * np.pi * t + 1)
    v = 6 * np.pi * np.cos(2 * np.pi * t) + 6.48 * np.pi * np.cos(5.4 * np.pi * t + 1)
    force = 12 * z + 0.3 * z**3 + 0.5 * v + 4 * np.tanh(v / 0.5) + rng.normal(0, 0.1, t.size)
    rows = np.column_stack([t, z, force])
    model, case = opened(tmp_path, "kelvin_voigt", "t [s],z [mm],F_m [N]", rows, "[noise]\nF_m = 0.1")
    verdict = mg.diagnose(case, model)
    assert {e.id for e in verdict.effects} == {"cubic_stiffness", "coulomb_friction"}
    assert not any("outlier" in note for note in verdict.notes)


@pytest.mark.parametrize(
    ("stated", "says"),
    [(0.05, "2 times the noise that is stated"), pytest.param(0.1, "", marks=pytest.mark.slow)],
)
def test_a_noise_that_is_another_than_stated_is_said(tmp_path: Path, stated: float, says: str) -> None:
    noise = f"[noise]\nF_m = {stated}"
    model, case = opened(tmp_path, "kelvin_voigt", "t [s],z [mm],F_m [N]", rubbed(), noise)
    told = [note for note in mg.diagnose(case, model).notes if "that is stated" in note]
    assert len(told) == bool(says) and all(says in note for note in told)
