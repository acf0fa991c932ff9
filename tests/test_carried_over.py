"""What is named in the fitted recordings must explain the held-out ones, too."""

from pathlib import Path

import numpy as np
import pytest

from modelgen.api import read_case
from modelgen.diagnose import Verdict, diagnose
from modelgen.models import load

K, C, K_3, F_C, NOISE = 2.0, 0.01, 0.4, 0.5, 0.01  # N/mm, N s/mm, N/mm³, N, N


def judged(folder: Path, held: str) -> Verdict:
    """A hardening spring at two amplitudes; the third, held out, hardens, too, or it rubs or does nothing
    where it has no cubic part."""
    rng, text = np.random.default_rng(4), f'model = "kelvin_voigt"\n[noise]\nF = {NOISE}\n'
    folder.mkdir()
    for k, (reach, role) in enumerate([(0.6, "fit"), (1.0, "fit"), (0.9, "holdout")]):
        t = np.arange(1500) / 500.0
        w = 2 * np.pi * (1.0 + 0.3 * k)
        z, v = reach * np.sin(w * t), reach * w * np.cos(w * t)
        more = {"rubs": F_C * np.sign(v), "linear": 0.0 * z}.get(
            held if role == "holdout" else "", K_3 * z**3
        )
        F = K * z + C * v + more + NOISE * rng.standard_normal(t.size)
        np.savetxt(
            folder / f"r{k}.csv", np.column_stack([t, z, F]), delimiter=",", header="t [s],z [mm],F [N]",
            comments="",
        )  # fmt: skip
        text += f'[[recording]]\nfile = "r{k}.csv"\nrole = "{role}"\n'
    (folder / "case.toml").write_text(text)
    return diagnose(read_case(folder / "case.toml"), load("kelvin_voigt"))


@pytest.mark.parametrize("held", [pytest.param("rubs", marks=pytest.mark.slow), "linear"])
def test_a_claim_that_explains_only_what_was_fitted_is_half_as_sure(tmp_path: Path, held: str) -> None:
    same, other = judged(tmp_path / "same", "hardens"), judged(tmp_path / "other", held)
    assert [e.id for e in same.effects] == [e.id for e in other.effects] == ["cubic_stiffness"]
    assert other.effects[0].probability == pytest.approx(same.effects[0].probability / 2, rel=1e-6)
    assert not [n for n in same.notes if "half as sure" in n]
    assert [n for n in other.notes if "half as sure" in n]
