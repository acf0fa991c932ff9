"""Friction whose level changes with speed or direction, and which goes over to it along its way."""

import numpy as np
import pytest

import modelgen.models
from modelgen.diagnose import diagnose
from modelgen.recordings import Case, Recording


def _force(z: np.ndarray, v: np.ndarray, level: np.ndarray, stiff: bool = False) -> np.ndarray:
    """dR/ds = ρ(g sgn v − R), or ρ(sgn v − R/g) if `stiff`, along the path, from rest; exact where g is
    constant over a step."""
    R = np.zeros(z.size)
    for k in range(1, z.size):
        dz = z[k] - z[k - 1]
        goal = np.sign(dz) * level[k]
        R[k] = goal + (R[k - 1] - goal) * np.exp(-3.2 * abs(dz) / (level[k] if stiff else 1.0))
    return 0.5 * z + 0.01 * v + 0.25 * R + 1.6


@pytest.mark.parametrize(
    ("id", "stiff", "level"),
    [
        pytest.param(
            "rate_dependent_friction",
            False,
            lambda v: 1 + 0.06 * np.arcsinh(np.abs(v) / 0.4),
            marks=pytest.mark.slow,
        ),
        ("stribeck_friction", False, lambda v: 1 + 0.3 * np.exp(-np.abs(v) / 2.0)),
        ("asymmetric_friction", True, lambda v: 1 + 0.15 * np.sign(v)),
    ],
)
def test_friction_follows_a_level_that_changes_with_speed_or_direction(id, stiff, level) -> None:
    rng, runs = np.random.default_rng(4), []
    for name, seconds, rate, phase in (
        ("slow", 20.0, 100, lambda t: (3.0, 0.1 * t)),
        ("sweep", 12.0, 400, lambda t: (0.5, 0.3 * 12 / np.log(30) * (30 ** (t / 12) - 1))),
    ):
        fine = np.arange(int(seconds * rate) * 8) / (8 * rate)
        size, turns = phase(fine)
        z = size * np.minimum(fine / 0.5, 1) * np.sin(2 * np.pi * turns)
        v = np.gradient(z, fine)
        F = _force(z, v, level(v), stiff)[::8]
        seen = {"t": fine[::8], "z": z[::8] + rng.normal(0, 2.88e-4, F.size)}
        runs.append(Recording(name, None, "fit", seen, {"F": F + rng.normal(0, 1.85e-3, F.size)}))
    found = diagnose(Case(None, "modified_dahl", tuple(runs)), modelgen.models.load("modified_dahl"))
    assert [e.id for e in found.effects] == [id]
    assert found.after.fit_over_noise == pytest.approx(1.0, abs=0.05)
