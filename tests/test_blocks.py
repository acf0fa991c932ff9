"""Records that are longer than a diagnosis works on are averaged over blocks."""

from pathlib import Path

import numpy as np
import pytest

from modelgen.api import read_case
from modelgen.diagnose import Verdict, diagnose
from modelgen.models import load

K, C, H, RHO, NOISE = 27.0, 0.05, 18.0, 2.1, 0.02  # N/mm, N s/mm, N, 1/mm, N


def judged(folder: Path, hardening: float, walk: float = 0.0) -> Verdict:
    """Dahl friction, its exact solution from sample to sample, in a chirp from 0.3 to 12 Hz at 5 kHz:
    within a block of averages it turns by up to a third of a millimetre. hardening: N/mm³; walk: the share of
    the noise that is a random walk."""
    rng, n = np.random.default_rng(8), 200_000
    t = np.arange(n) / 5000.0
    phase = 2 * np.pi * (0.3 * t + 0.5 * (12.0 - 0.3) / t[-1] * t**2)
    z = 1.9 * np.sin(phase)
    v = 1.9 * np.cos(phase) * np.gradient(phase, t)
    r, last = np.empty(n), 0.0
    for k, dz in enumerate(np.diff(z, prepend=z[0])):
        last = r[k] = np.sign(dz) + (last - np.sign(dz)) * np.exp(-RHO * abs(dz))
    F = K * z + C * v + H * r + hardening * z**3
    slow = np.cumsum(rng.standard_normal(n))
    F += (
        NOISE * np.sqrt(1 - walk**2) * rng.standard_normal(n)
        + NOISE * walk * (slow - slow.mean()) / slow.std()
    )
    text = f'model = "modified_dahl"\nper_recording = ["r_0"]\n[noise]\nF_m = {NOISE}\n'
    np.savetxt(
        folder / "a.csv", np.column_stack([t, z, F]), "%.8g", ",", header="t [s],z [mm],F_m [N]", comments=""
    )
    (folder / "case.toml").write_text(text + '[[recording]]\nfile = "a.csv"\n')
    return diagnose(read_case(folder / "case.toml"), load("modified_dahl"))


@pytest.mark.parametrize(
    ("hardening", "named"), [(0.0, []), pytest.param(0.2, ["cubic_stiffness"], marks=pytest.mark.slow)]
)
def test_what_averaging_makes_of_friction_is_no_physics(
    tmp_path: Path, hardening: float, named: list[str]
) -> None:
    v = judged(tmp_path, hardening)
    assert [e.id for e in v.effects] == named, v.summary
    assert v.after.fit_over_noise == pytest.approx(1.0, abs=0.03)
    assert any("averaged in blocks of 9" in n for n in v.notes)


@pytest.mark.slow
def test_noise_that_neighbours_share_does_not_average_out(tmp_path: Path) -> None:
    v = judged(tmp_path, 0.0, walk=0.775)  # 60 % of the variance
    assert v.adequate, v.summary
    assert "that is stated" not in v.summary
