"""What changes while it is recorded: unknown, and told as what it is."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from modelgen.api import read_case
from modelgen.diagnose import Verdict, diagnose
from modelgen.models import load

MOTIONS = {"slow": (0.7, 1.9), "fast": (1.3, 3.1), "last": (0.9, 2.3)}
Change = Callable[[str, np.ndarray], np.ndarray | float]


def judged(folder: Path, stiffness: Change, damping: Change = lambda name, t: 1.0) -> Verdict:
    """Three records of a spring and a dashpot, times what changes, in stated noise."""
    rng, text = np.random.default_rng(9), 'model = "kelvin_voigt"\n[noise]\nF_m = 2e-3\nz = 1e-4\n'
    for name, (f, g) in MOTIONS.items():
        t = np.arange(3000) / 200.0
        z = 0.6 * np.sin(2 * np.pi * f * t) + 0.2 * np.sin(2 * np.pi * g * t)
        v = 2 * np.pi * (0.6 * f * np.cos(2 * np.pi * f * t) + 0.2 * g * np.cos(2 * np.pi * g * t))
        F = 2.0 * z * stiffness(name, t) + 0.05 * v * damping(name, t) + 2e-3 * rng.standard_normal(t.size)
        rows = np.column_stack([t, z + 1e-4 * rng.standard_normal(t.size), F])
        np.savetxt(folder / f"{name}.csv", rows, delimiter=",", header="t [s],z [mm],F_m [N]", comments="")
        text += f'[[recording]]\nfile = "{name}.csv"\n'
    (folder / "case.toml").write_text(text)
    return diagnose(read_case(folder / "case.toml"), load("kelvin_voigt"))


def test_a_stiffness_that_is_pumped_is_told_with_its_frequency_and_modelled(tmp_path: Path) -> None:
    """As much as the noise itself, and under no frequency of the motion."""
    pumped = judged(tmp_path, lambda name, t: 1 + 2e-3 * np.sin(2 * np.pi * 5.37 * t + len(name)))
    (found,) = pumped.effects
    assert found.id == "unknown_force"
    f = next(q for q in found.parameters if q.name == "f")
    assert f.value == pytest.approx(5.37, abs=max(4 * f.std, 1e-3))
    assert pumped.after.fit_over_noise < 1.02 < pumped.before.fit_over_noise


@pytest.mark.slow
def test_a_damping_that_is_pumped_is_no_stiffness(tmp_path: Path) -> None:
    pumped = judged(tmp_path, lambda name, t: 1.0, lambda name, t: 1 + 0.02 * np.sin(2 * np.pi * 8.2 * t))
    (found,) = pumped.effects
    assert found.id == "unknown_force" and "a damping that changes at 8.2" in found.says


@pytest.mark.slow
def test_a_crack_is_told_with_its_moment_and_lasts(tmp_path: Path) -> None:
    """In the second record the stiffness falls by a part in 500, and stays so in the third."""
    cracked = {"slow": np.inf, "fast": 7.3, "last": -1.0}
    (found,) = judged(tmp_path, lambda name, t: 1 - 2e-3 * (t > cracked[name])).effects
    assert found.id == "unknown_force"
    told = re.search(r"a jump of the stiffness at ([0-9.]+) s in fast, which stays", found.says)
    assert told and abs(float(told[1]) - 7.3) < 0.3
