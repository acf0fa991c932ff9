"""Three effects that a search puts together for one law which no catalogue holds."""

from pathlib import Path

import numpy as np
import pytest

from modelgen.api import read_case
from modelgen.diagnose import diagnose
from modelgen.models import load

NOISE = 0.02


def recorded(folder: Path, snap: float) -> Path:
    """A spring and a dashpot, and a disc spring that snaps through at z = 1.7 mm."""
    rng, text = np.random.default_rng(11), f'model = "kelvin_voigt"\n[noise]\nF_m = {NOISE}\n'
    for name, role, amplitude, f0, f1, seconds in (
        ("slow", "fit", 5.0, 0.2, 0.2, 20.0),
        ("sweep_4mm", "fit", 4.0, 0.4, 3.0, 10.0),
        ("sweep_2mm", "fit", 2.0, 0.3, 6.0, 8.0),
        ("sweep_3mm", "holdout", 3.0, 0.3, 4.0, 8.0),
    ):
        t = np.linspace(0, seconds, 2400)
        phase = 2 * np.pi * (f0 * t + (f1 - f0) * t**2 / (2 * seconds))
        z, v = amplitude * np.sin(phase), amplitude * np.cos(phase) * np.gradient(phase, t)
        u = (z - 1.7) / 0.7
        F = 2.3 * z + 0.06 * v + 4.2 - snap * u * np.exp(-(u**2) / 2) + NOISE * rng.standard_normal(t.size)
        rows = np.column_stack([t, z, F])
        header = "t [s],z [mm],F_m [N]"
        np.savetxt(folder / f"{name}.csv", rows, delimiter=",", header=header, comments="", fmt="%.9g")
        text += f'[[recording]]\nfile = "{name}.csv"\nrole = "{role}"\n'
    (folder / "case.toml").write_text(text)
    return folder / "case.toml"


@pytest.mark.slow
def test_a_spring_that_snaps_through_is_no_three_other_springs(tmp_path: Path) -> None:
    case = read_case(recorded(tmp_path, 0.05))
    found = diagnose(case, load("kelvin_voigt"))
    assert [e.id for e in found.effects] == ["unknown_force"]
    assert found.after.fit_over_noise < 1.1 < found.before.fit_over_noise


def test_without_it_nothing_is_missing(tmp_path: Path) -> None:
    assert diagnose(read_case(recorded(tmp_path, 0.0)), load("kelvin_voigt")).adequate
