"""Recordings that the model explains each by itself, but not together."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from modelgen.api import read_case
from modelgen.diagnose import diagnose
from modelgen.models import load

CASE = """\
model = "electrodynamic_transducer"
[noise]
Z_relative = 5e-4
"""
SWEEP = """
[[recording]]
file = "{name}.csv"
role = "fit"
constants = {{ M_m = {mass} }}
"""


def sweeps(folder: Path, stiffness: tuple[float, ...]) -> Path:
    """Sweeps of a loudspeaker, each with its own mass and stiffness of the suspension (N/m)."""
    rng = np.random.default_rng(5)
    f = np.geomspace(10.0, 5000.0, 200)
    s = 2j * np.pi * f
    text = CASE
    for name, mass, K in zip(("cold", "warm", "hot"), (0.02, 0.03, 0.05), stiffness, strict=False):
        Z = 5.7 + 4e-4 * s + 7.3**2 / (s * mass + 1.4 + K / s)
        Z *= 1 + 5e-4 * (rng.standard_normal(200) + 1j * rng.standard_normal(200))
        rows = "\n".join(f"{a:.9g},{z.real:.9g},{z.imag:.9g}" for a, z in zip(f, Z, strict=True))
        (folder / f"{name}.csv").write_text(f"f [Hz],Re Z [ohm],Im Z [ohm]\n{rows}\n")
        text += SWEEP.format(name=name, mass=mass)
    (folder / "case.toml").write_text(text)
    return folder / "case.toml"


@pytest.mark.parametrize("stiffness", [(2500.0, 2600.0), (2500.0, 2900.0, 2650.0)])
def test_a_stiffness_that_depends_on_the_load_is_no_effect_of_the_catalogue(
    tmp_path: Path, stiffness: tuple[float, ...]
) -> None:
    """The suspension stiffens under some weights: each sweep alone is explained, and no law all."""
    case = read_case(sweeps(tmp_path, stiffness))
    verdict = diagnose(case, load(case.model))
    (found,) = verdict.effects
    assert found.id == "unknown_mechanical"
    assert "of its own of K_m" in found.says and "M_m, changes it" in found.says
    assert verdict.after.fit_over_noise == pytest.approx(1.0, abs=0.1)


def test_recordings_that_agree_are_not_said_to_disagree(tmp_path: Path) -> None:
    case = read_case(sweeps(tmp_path, (2500.0, 2500.0)))
    verdict = diagnose(case, load(case.model))
    assert verdict.adequate and not any("disagree" in note for note in verdict.notes)


def test_sweeps_of_one_load_that_disagree_have_a_note(tmp_path: Path) -> None:
    """Nothing is known to differ, and no law is right: the moving mass has changed, and the losses."""
    folder = sweeps(tmp_path, (2500.0, 2500.0))
    case = read_case(folder)
    case = replace(case, recordings=tuple(replace(r, constants={"M_m": 0.02}) for r in case.recordings))
    (note,) = [n for n in diagnose(case, load(case.model)).notes if n.startswith("recordings disagree")]
    assert "K_m, Bl, R_m of their own in each (per_recording)" in note
