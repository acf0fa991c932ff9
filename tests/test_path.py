"""Errors in variables: corners between the samples and a noisy speed are no physics."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy import signal

import modelgen as mg
from modelgen.diagnose import diagnose
from modelgen.diagnose.gate import likeliest_path
from modelgen.diagnose.verdict import Verdict
from modelgen.fit.experiment import experiment
from modelgen.fit.motion import turn_error
from modelgen.fit.series import make_series
from modelgen.recordings.kinematics import kinematics

FINE = 100
"""Steps of the simulations in a sample."""


def triangle(period: float, count: int, corner: float, phase: float) -> np.ndarray:
    """A triangle of amplitude 1, corners rounded by a filter of the time constant `corner` in samples; on the
    fine grid."""
    t = np.arange(count * FINE) / FINE
    z = signal.sawtooth(2 * np.pi * (t / period + phase), 0.5)
    b = signal.butter(2, 1 / (np.pi * corner * FINE), output="sos")
    return np.asarray(signal.sosfilt(b, z, zi=signal.sosfilt_zi(b) * z[0])[0])


def friction(z: np.ndarray, rho: float) -> np.ndarray:
    """Dahl's friction state along a path, dr/dz = ρ (1 − r sgn dz), from 0."""
    r = np.zeros(len(z))
    for i, d in enumerate(np.diff(z)):
        s = 1.0 if d >= 0 else -1.0
        r[i + 1] = s - (s - r[i]) * np.exp(-rho * abs(d))
    return r


def judged(folder: Path, z: np.ndarray, F: np.ndarray, z_noise: float, F_noise: float) -> Verdict:
    """The verdict on a record of a path and its force, both on the fine grid, with white noise on both."""
    rng = np.random.default_rng(1)
    z, F = z[::FINE], F[::FINE]
    n = np.arange(len(z))
    table = np.column_stack(
        [n / 50, z + z_noise * rng.standard_normal(len(n)), F + F_noise * rng.standard_normal(len(n))]
    )
    np.savetxt(folder / "a.csv", table, delimiter=",", header="t [s],z [mm],F_m [N]", comments="")
    (folder / "case.toml").write_text('model = "modified_dahl"\n[[recording]]\nfile = "a.csv"\n')
    return diagnose(mg.read_case(folder / "case.toml"), mg.models.modified_dahl)


@pytest.mark.parametrize("corner", [0.15, 0.3, 0.6, 2.0])
def test_turns_at_corners_are_as_sure_as_they_say(corner: float) -> None:
    pulls = []
    for phase in np.linspace(0, 0.3, 7):
        z = triangle(33.3, 400, corner, phase)
        k = kinematics(np.arange(400.0), z[::FINE], 0.0)
        for n in k.reversals[(k.reversals > 9) & (k.reversals < 390)]:
            step = z[(n - 1) * FINE : n * FINE + 1]
            turn = step.max() if z[(n - 3) * FINE] < z[(n - 1) * FINE] else step.min()
            pulls.append((k.z_turn[n] - turn) / max(k.sigma_turn[n], 1e-5))
    assert np.max(np.abs(pulls)) < 4


def test_turns_of_a_sine_are_sure() -> None:
    t = np.arange(400.0)
    assert kinematics(t, np.sin(2 * np.pi * t / 25), 0.0).sigma_turn.max() < 1e-9


@pytest.mark.slow
def test_corners_between_the_samples_are_no_physics(tmp_path: Path) -> None:
    """Friction remembers where the path turned, and no record of samples says that of a sharp corner."""
    z = triangle(33.3, 700, 0.4, 0.1)
    v = np.gradient(z, 1 / FINE)
    verdict = judged(tmp_path, z, z + friction(z, 8.0) + 0.2 * v, 0.0, 3e-3)
    assert verdict.adequate, verdict.summary


def test_a_motion_that_comes_to_rest_may_have_gone_farther_and_back(tmp_path: Path) -> None:
    """Ramps up with rests between: no turn is seen, and friction remembers one that noise hides."""
    t = np.arange(400.0)
    z = np.interp(t, [0, 50, 70, 180, 200, 400], [0, 0, 1, 1, 2, 2])
    noise = np.random.default_rng(2).standard_normal((2, 400))
    table = np.column_stack([t, z + 1e-3 * noise[0], z + 1e-3 * noise[1]])
    np.savetxt(tmp_path / "a.csv", table, delimiter=",", header="t [s],z [mm],F_m [N]", comments="")
    (tmp_path / "case.toml").write_text(
        'model = "modified_dahl"\n[noise]\nF_m = 1e-3\nz = 1e-3\n[[recording]]\nfile = "a.csv"\n'
    )
    case, dahl = mg.read_case(tmp_path / "case.toml"), mg.models.modified_dahl
    ex = experiment(dahl, case, [make_series(dahl, case, case.fit[0])])
    theta = np.array([{"h_D": 1.0, "rho": 8.0, "b": 1.0}.get(n, 0.0) for n in ex.layout.names])
    found = turn_error(ex, case, case.fit[0], theta, 0)
    assert {int(n) // 10 for n in found.at} >= {7, 20}
    assert np.abs(found.effect[:, found.at > 60]).max() > 5  # of the noise of the force


def test_a_speed_that_is_in_error_is_no_other_law(tmp_path: Path) -> None:
    """Where samples of one speed show many, any law that levels them off fits better than the right one."""
    z = triangle(25.3, 700, 0.4, 0.1)
    v = np.gradient(z, 1 / FINE)
    verdict = judged(tmp_path, z, 0.1 * z + 0.2 * friction(z, 5.0) + 20 * v, 1.5e-4, 1e-3)
    assert verdict.adequate, verdict.summary


@pytest.mark.slow
def test_what_is_left_out_is_seen_beside_such_errors(tmp_path: Path) -> None:
    z = triangle(33.3, 700, 0.4, 0.1)
    v = np.gradient(z, 1 / FINE)
    verdict = judged(tmp_path, z, z + friction(z, 8.0) + 0.2 * v + 0.1 * z**3, 3e-4, 3e-3)
    assert verdict.effects[0].id == "cubic_stiffness", verdict.summary


@pytest.mark.parametrize(("stated", "beyond"), [(True, True), (False, False)])
def test_a_colour_that_nobody_stated_is_no_reason_to_trust_a_path(
    monkeypatch: pytest.MonkeyPatch, stated: bool, beyond: bool
) -> None:
    """Residuals of eight times the scatter between neighbours, and under their colour of once."""
    white = np.random.default_rng(4).standard_normal((1, 500))
    setting: Any = SimpleNamespace(series=[SimpleNamespace(stated=stated)])
    base: Any = SimpleNamespace(white=[white])
    monkeypatch.setattr(likeliest_path, "plain_white", lambda _: [8 * white])
    assert likeliest_path._doubtless(setting, base) is beyond
