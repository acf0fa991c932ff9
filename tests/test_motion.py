"""Noise of the displacement: its share of the residual is known, so that standard deviations are honest."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import modelgen as mg
from modelgen.api import read_case
from modelgen.diagnose import diagnose
from modelgen.fit.experiment import experiment
from modelgen.fit.motion import motion_error, with_motion
from modelgen.fit.series import make_series
from modelgen.language import Equation, Input, Model, Parameter, previous, rate_of
from modelgen.models import load
from modelgen.recordings import Case, Noise, Recording
from modelgen.recordings.kinematics import kinematics
from modelgen.truths import draw, write_case
from modelgen.truths.further import further

TRUE = {"k_D": 0.6797, "c_D": 0.1374, "h_D": 0.2309, "rho": 1.44, "F_0": 1.3, "r_0": -0.8}
DAHL = mg.models.modified_dahl


def drawn(folder: Path, seed: int, z_noise: float, F_noise: float) -> Case:
    """A record of the model with independent noise of displacement [mm] and force [N], both stated."""
    t, rng = np.arange(1500) / 300.0, np.random.default_rng(seed)
    z = -3 * np.cos(5.65 * t) * (0.7 + 0.3 * np.cos(0.82 * t))
    F = mg.build(DAHL)(t=t, z=z, **TRUE) + F_noise * rng.standard_normal(t.size)
    table = np.column_stack([t, z + z_noise * rng.standard_normal(t.size), F])
    np.savetxt(folder / "a.csv", table, delimiter=",", header="t [s],z [mm],F [N]", comments="")
    noise = f"[noise]\nF = {F_noise}\nz = {z_noise}\n"
    (folder / "case.toml").write_text(f'model = "{DAHL.id}"\n{noise}[[recording]]\nfile = "a.csv"\n')
    return mg.read_case(folder / "case.toml")


def test_the_residual_of_the_truth_is_white(tmp_path: Path) -> None:
    """Under the noise of force alone it is far from it: ten times too large and smooth."""
    squares, neighbours, alone = [], [], []
    for seed in range(12):
        case = drawn(tmp_path, seed, 0.005, 0.0005)
        ex = experiment(DAHL, case, [make_series(DAHL, case, case.fit[0])])
        theta = np.array([TRUE[n] for n in ex.layout.names])
        alone.append(np.mean(ex.whitened(theta)[0] ** 2))
        white = with_motion(ex, case, case.fit, theta).whitened(theta)[0][0]
        squares.append(np.mean(white**2))
        neighbours.append(np.mean(white[1:] * white[:-1]) / squares[-1])
    assert np.mean(alone) > 10
    assert 0.7 < np.mean(squares) < 1.1
    assert abs(np.mean(neighbours)) < 0.12


DAMPER = """
from modelgen.language import Equation, Input, Model, Output, Parameter, Port
from modelgen.language import acceleration_of, previous, rate_of

t = Input("t", "s")
z = Input("z", "mm")
v, a, t_prev = rate_of(z, "v", "mm/s"), acceleration_of(z, "a", "mm/s**2"), previous(t)
k = Parameter("k", "N/mm", 1.0, (0.0, 1e3), "spring")
c = Parameter("c", "N*s/mm", 0.1, (0.0, 1e3), "dashpot")
m = Parameter("m", "N*s**2/mm", 1e-2, (0.0, 10.0), "mass")
F_s = Equation("F_s", k * z + c * v + m * a, "N")
at = tuple((n, i.symbol) for n, i in dict(t=t, t_prev=t_prev, z=z, v=v, a=a).items())
damper = Model("damper", (t, z, v, a, t_prev), (k, c, m), (F_s,), (Output("F_s", measured_as=("F",)),),
               (Port("force", "force", "F_s", at), Port("sensor", "sensor", "F_s", at[:2])))
"""


def moved_mass(folder: Path, seed: int, m: float, z_noise: float) -> Case:
    """Two records of spring, dashpot and mass in a motion of ten lines, with noise of the displacement."""
    n, rng = np.arange(1200), np.random.default_rng(seed)
    text = 'model = "damper.py:damper"\n'
    for file in ("a.csv", "b.csv"):
        w = 2 * np.pi * np.arange(1, 11) / 10 * 0.5
        waves = np.outer(n / 25, w) + rng.uniform(0, 2 * np.pi, 10)
        z, v, a = np.sin(waves).sum(1), np.cos(waves) @ w, -np.sin(waves) @ w**2
        F = 1.0 * z + 0.15 * v + m * a + 1e-3 * rng.standard_normal(n.size)
        table = np.column_stack([n / 25, z + z_noise * rng.standard_normal(n.size), F])
        np.savetxt(folder / file, table, delimiter=",", header="t [s],z [mm],F [N]", comments="")
        text += f'[[recording]]\nfile = "{file}"\n'
    (folder / "damper.py").write_text(DAMPER)
    (folder / "case.toml").write_text(text)
    return mg.read_case(folder / "case.toml")


@pytest.mark.parametrize(("m", "z_noise"), [(0.05, 5e-3), pytest.param(0.1, 2e-2, marks=pytest.mark.slow)])
def test_errors_of_the_acceleration_are_no_physics(m: float, z_noise: float, tmp_path: Path) -> None:
    case = moved_mass(tmp_path, 1, m, z_noise)
    verdict = diagnose(case, load(str(tmp_path / "damper.py") + ":damper"))
    assert verdict.adequate, verdict.summary


def test_slight_noise_changes_nothing(tmp_path: Path) -> None:
    case = drawn(tmp_path, 0, 1e-6, 0.005)
    ex = experiment(DAHL, case, [make_series(DAHL, case, case.fit[0])])
    assert with_motion(ex, case, case.fit, ex.problem().start) is ex


@pytest.mark.slow
@pytest.mark.parametrize(("z_noise", "F_noise"), [(2.9e-4, 5e-4), (5e-3, 5e-3)])
def test_coverage_with_noise_of_the_displacement(z_noise: float, F_noise: float, tmp_path: Path) -> None:
    """100 draws of six parameters: one standard deviation holds 68 %, three hold all but a few."""
    pulls = []
    for seed in range(100):
        found = mg.fit(DAHL, drawn(tmp_path, seed, z_noise, F_noise), method=mg.GaussNewton())
        pulls.append([(found[n].value - x) / found[n].std for n, x in TRUE.items()])
    size = np.abs(pulls)
    assert 0.6 < np.mean(size < 1) < 0.82
    assert np.mean(size < 3) > 0.985


@pytest.mark.slow
def test_errors_of_the_motion_choose_no_rival(tmp_path: Path) -> None:
    """A low-pass of the force and a joint before a dashpot are nearly one response: what errors of a fast
    motion lend to the one is no evidence against the other."""
    secret = draw(203000352, "single", "force", "force_sensor_lag", noise="outliers", ratio=1.5)
    faster = further(secret, "the same motion 25 times as fast would separate them")
    assert faster is not None
    case = read_case(write_case(faster, tmp_path))
    first = diagnose(case, load(case.model)).effects[0]
    assert "force_sensor_lag" in {first.id, *first.equivalents}


def test_errors_of_the_motion_move_no_time() -> None:
    """Whatever a model does with its clock, an error of z moves the force by k δz."""
    t, z = Input("t", "s"), Input("z", "mm")
    v, back, before = rate_of(z, "v", "mm/s"), previous(z), previous(t)
    k, q = Parameter("k", "N/mm", 2.0, (0.0, 1e3)), Parameter("q", "N/s", 0.0, (-1e6, 1e6))
    F = Equation("F", k * (z + 0 * (z - back)) + q * (t - before), "N")
    model = Model("clocked", (t, z, v, back, before), (k, q), (F,), ("F",))
    at, rng = np.arange(800) / 200.0, np.random.default_rng(2)
    seen = {"t": at, "z": np.sin(4 * at) + 1e-3 * rng.standard_normal(at.size)}
    record = Recording("r", None, "fit", seen, {"F": 2 * seen["z"]})
    case = Case(None, model.id, (record,), noise=Noise({"F": 1e-3, "z": 1e-3}))
    ex = experiment(model, case, [make_series(model, case, record)])
    still, fast = (motion_error(ex, case, record, np.array([2.0, q]), 0) for q in (0.0, 1e4))
    assert still is not None and fast is not None
    assert np.allclose(still.by_value, fast.by_value, atol=1e-9) and still.by_value.max() > 1e-4


def triangle(t: np.ndarray, A: float, f: float) -> np.ndarray:
    """A triangle with amplitude A [mm] whose corners are rounded within a hundredth of its period."""
    sharp = 0.9985
    return A / np.arcsin(sharp) * np.arcsin(sharp * np.sin(2 * np.pi * f * t))


def test_corners_are_smoothed_no_more_than_their_noise_allows() -> None:
    """The error that is the same at all turns is a small part of what noise leaves at each."""
    t = np.arange(4000) / 100.0
    z = triangle(t, 0.7, 0.25)
    near = np.abs(np.cos(0.5 * np.pi * t)) < 0.15
    errors = []
    for seed in range(20):
        noise = 8e-4 * np.random.default_rng(seed).standard_normal(t.size)
        found = kinematics(t, z + noise, 8e-4)
        errors.append((found.z - z)[near])
    assert np.sqrt(np.mean(np.mean(errors, axis=0) ** 2)) < 0.25 * 8e-4
    assert np.std(errors) < 0.65 * 8e-4
    stated = np.broadcast_to(found.sigma, t.size)[near]
    assert np.sqrt(np.mean(stated**2)) == pytest.approx(np.std(errors), rel=0.2)


def test_fast_turns_of_a_sweep_narrow_no_windows_of_slow_ones() -> None:
    t = np.arange(6000) / 500.0
    z = 0.4 * np.sin(2 * np.pi * (0.3 * t + (10 - 0.3) / 24 * t**2))
    v = np.gradient(z, t)
    slow = t < 4.0
    noise = 2.88e-4 * np.random.default_rng(3).standard_normal(t.size)
    found = kinematics(t, z + noise, 2.88e-4)
    assert np.std((found.v - v)[slow][50:]) < 0.012
    assert np.median(found.window[slow]) > 20


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_corners_of_a_slow_triangle_are_no_physics(seed: int, tmp_path: Path) -> None:
    """The displacement's noise, times the stiffness, is twice the force's own; its corners are smoothed."""
    rng, text = np.random.default_rng(seed), 'model = "modified_dahl"\nper_recording = ["F_0", "r_0"]\n'
    text += "[noise]\nF_m = 0.05\nz = 0.0008\n"
    rubber = {"k_D": 58.0, "c_D": 0.9, "h_D": 24.0, "rho": 3.6, "F_0": 11.0, "r_0": 0.0}
    for name, role, A, f in (("a", "fit", 1.6, 0.1), ("b", "fit", 0.7, 0.25), ("c", "holdout", 1.2, 0.15)):
        t = np.arange(4000 * 12) / 1200.0
        z = triangle(t, A, f)
        F = mg.build(mg.models.modified_dahl)(t=t, z=z, **rubber)
        rows = np.stack([t, z, F], axis=1)[::12] + [0, 8e-4, 0.05] * rng.standard_normal((4000, 3))
        np.savetxt(tmp_path / f"{name}.csv", rows, "%.7g", ",", header="t [s],z [mm],F_m [N]", comments="")
        text += f'[[recording]]\nfile = "{name}.csv"\nrole = "{role}"\n'
    (tmp_path / "case.toml").write_text(text)
    v = diagnose(read_case(tmp_path / "case.toml"), load("modified_dahl"))
    assert v.adequate, v.summary
