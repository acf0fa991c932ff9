"""What is smooth in sweeps and tables, and yet no error of the instrument nor a colour of the noise."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from coils import coil, verdict

import modelgen as mg
from modelgen.diagnose import Verdict, diagnose
from modelgen.diagnose.gate.resonant import PEAK, STEP
from modelgen.diagnose.gate.tables import JOINT
from modelgen.models import load

F = np.geomspace(10.0, 2e4, 120)


def test_a_range_that_is_switched_is_no_smooth_error(tmp_path: Path) -> None:
    v = verdict(tmp_path, F, coil(F) * np.where(F > 700.0, 1 + 6e-3 * np.exp(0.8j), 1))
    assert [e.id for e in v.effects] == ["unknown_electrical"]
    assert STEP in v.effects[0].says
    assert v.after.fit_over_noise == pytest.approx(1.0, abs=0.15)
    at = next(p.value for p in v.effects[0].parameters if p.name == "omega_1")
    assert at / (2 * np.pi) == pytest.approx(700.0, rel=0.05)


@pytest.mark.slow
def test_a_loss_in_a_band_is_no_smooth_error(tmp_path: Path) -> None:
    v = verdict(tmp_path, F, coil(F) + 0.06 * np.exp(-((np.log(F / 400.0) / 0.5) ** 2)))
    assert [e.id for e in v.effects] == ["unknown_electrical"]
    assert PEAK in v.effects[0].says
    assert v.after.fit_over_noise == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_smooth_error_stays_one(tmp_path: Path, seed: int) -> None:
    rng, x = np.random.default_rng(seed), np.log(F)
    root = np.linalg.cholesky(np.exp(-0.5 * ((x[:, None] - x) / 0.7) ** 2) + 1e-8 * np.eye(x.size))
    e = 2e-3 * root @ (rng.standard_normal(x.size) + 1j * rng.standard_normal(x.size))
    v = verdict(tmp_path, F, coil(F) * (1 + e))
    assert v.adequate
    assert "a smooth error of the instrument that nobody stated" in v.summary  # and not: like noise


def _tables(folder: Path, more: Any, rho: float = 0.0) -> Verdict:
    """Of a rubber's stiffness at three amplitudes, with `more`(f, A) [N/mm] and noise of 0.2 %, neighbours
    correlated by `rho`."""
    f, rng = np.geomspace(0.1, 10.0, 25), np.random.default_rng(4)
    text = 'model = "complex_stiffness"\n[noise]\nk_s = 2e-3\nloss_angle = 0.1\n'
    model = mg.build(load("complex_stiffness"))
    for k, A in enumerate((0.2, 0.5, 1.0)):
        noise = rng.standard_normal((2, f.size))
        for n in range(1, f.size):
            noise[:, n] = rho * noise[:, n - 1] + np.sqrt(1 - rho**2) * noise[:, n]
        K, angle = np.asarray(model(f=f, k_D=1.0, c_D=2e-3, h_D=0.1, rho=4.0, A_z=A))
        rows = np.column_stack([f, K + more(f, A) + 2e-3 * noise[0], angle + 0.1 * noise[1]])
        head = ["f [Hz]", "k_s [N/mm]", "loss_angle [deg]"][: 3 if k else 2]  # the first lacks its angle
        text_of = {"delimiter": ",", "header": ",".join(head), "comments": ""}
        np.savetxt(folder / f"r{k}.csv", rows[:, : len(head)], **text_of)
        text += f'[[recording]]\nfile = "r{k}.csv"\nconstants = {{ A_z = {A} }}\n'
    (folder / "case.toml").write_text(text)
    found, case = mg.open_case(folder / "case.toml")
    return diagnose(case, found)


@pytest.mark.slow
def test_frequency_and_amplitude_that_act_together_are_no_colour_of_the_noise(tmp_path: Path) -> None:
    v = _tables(tmp_path, lambda f, A: 6e-3 * np.log(f) * np.log(A / 0.46))
    assert [e.id for e in v.effects] == ["unknown_mechanical"]
    assert f"{JOINT} A_z" in v.effects[0].says
    assert v.before.fit_over_noise > 1.5


@pytest.mark.parametrize("rho", [0.0, 0.8, 0.95])
def test_noise_of_tables_is_no_physics(tmp_path: Path, rho: float) -> None:
    assert _tables(tmp_path, lambda f, A: 0.0, rho).adequate
