"""Smooth errors of an instrument: those of a factor turn with the phase of Z, those of its readings don't."""

from pathlib import Path

import numpy as np
import pytest
from coils import write_sweep

import modelgen.models
from modelgen.diagnose import diagnose
from modelgen.diagnose.ground import prepare
from modelgen.fit.series import signature_of
from modelgen.recordings import load_case, read_case_file

F = np.geomspace(10, 400, 300)
S = 2j * np.pi * F


def _write(folder: Path, turning: bool, seed: int) -> None:
    """Two sweeps of a moving coil of high Q, known masses, and errors of 3e-3, smooth over 0.7 in ln f."""
    rng = np.random.default_rng(seed)
    x = np.log(F)
    root = np.linalg.cholesky(np.exp(-0.5 * ((x[:, None] - x) / 0.7) ** 2) + 1e-9 * np.eye(F.size))
    text = 'model = "electrodynamic_transducer"\n[noise]\nZ_relative = 3e-4\nZ_calibration = [3e-3, 0.7]\n'
    for name, M_m in (("a", 0.015), ("b", 0.025)):
        Z = 6.0 + 5e-4 * S + 36.0 / (0.3 + M_m * S + 2e3 / S)
        smooth, white = (
            r @ (rng.standard_normal(F.size) + 1j * rng.standard_normal(F.size))
            for r in (root, np.eye(F.size))
        )
        Z = Z + 3e-4 * np.abs(Z) * white + 3e-3 * (Z if turning else np.abs(Z)) * smooth
        write_sweep(folder / f"{name}.csv", F, Z)
        text += f'[[recording]]\nfile = "{name}.csv"\nrole = "fit"\nconstants = {{ M_m = {M_m} }}\n'
    (folder / "case.toml").write_text(text)


@pytest.mark.parametrize("turning", [True, False])
@pytest.mark.parametrize("seed", [1, 2])
def test_the_frame_of_a_smooth_error_is_found_and_it_raises_no_alarm(
    tmp_path: Path, turning: bool, seed: int
) -> None:
    _write(tmp_path, turning, seed)
    file = read_case_file(tmp_path / "case.toml")
    model = modelgen.models.load(file.model)
    case = load_case(file, signature_of(model))
    assert [s.turning for s in prepare(model, case, 0).series] == [turning, turning]
    assert diagnose(case, model).adequate
