"""What a search of recordings over time passes by when it goes from one effect to the next."""

from pathlib import Path

import numpy as np
import pytest

from modelgen.api import open_case, read_case
from modelgen.diagnose import diagnose
from modelgen.diagnose.noise.noise import fitful
from modelgen.models import load
from modelgen.truths import draw, write_case
from modelgen.truths.further import further


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "effects", "noise", "ratio"),
    [
        pytest.param(
            203100021, ("inertia", "sensor_delay"), "quantised", 20.0,
            id="spring and dashpot take up either, but not both",
        ),
        pytest.param(
            720100199, ("power_law_viscoelasticity", "second_mode"), "white", 6.0,
            id="beside the bent creep a mass does more than a resonator elsewhere",
        ),
        pytest.param(
            203300215, ("maxwell_branch", "second_mode"), "clean", 20.0,
            id="where the base is bent far, it seems to resonate elsewhere",
        ),
        pytest.param(
            204900095, ("stribeck_friction", "power_law_viscoelasticity"), "misstated", 20.0,
            id="beside the bent creep friction falls with speed, alone it would rise",
        ),
        pytest.param(
            260100054, ("asymmetric_stiffness", "end_stop"), "coloured", 6.0,
            id="a descent that leaves no friction finds no way back",
        ),
        pytest.param(
            260200059, ("payne_softening", "second_dahl_element"), "quantised", 6.0,
            id="both have another law than either has beside what the other was first",
        ),
        pytest.param(
            320100181, ("force_sensor_lag", "backlash"), "white", 20.0,
            id="beside play a first order leads astray, and other laws of play hide the lag",
        ),
        pytest.param(
            320100215, ("contact_compliance", "cubic_stiffness"), "coloured", 20.0,
            id="the joint takes in the spring, though the spring was found after it",
        ),
        pytest.param(
            350100051, ("backlash", "offset_drift"), "misstated", 3.0,
            id="a colour of the noise takes all of the drift",
        ),
        pytest.param(
            350100125, ("magnetic_pull", "cubic_stiffness"), "quantised", 3.0,
            id="one other effect does nearly as well as both",
        ),
    ],
)  # fmt: skip
def test_both_of_a_pair_are_named(
    tmp_path: Path, seed: int, effects: tuple[str, str], noise: str, ratio: float
) -> None:
    write_case(draw(seed, "pair", "force", effects, (30.0, 1e4), noise, ratio), tmp_path)
    found = diagnose(read_case(tmp_path / "case.toml"), load("modified_dahl"))
    assert {e.id for e in found.effects} == set(effects)


@pytest.mark.slow
def test_a_fast_recording_that_bends_the_base_beyond_return(tmp_path: Path) -> None:
    """Beside slow ones it bends the base until friction is gone, and no descent from there finds it again."""
    secret = draw(320100134, "single", "force", ("inertia",), (30.0, 1e4), "clean", 1.5)
    more = further(
        secret, "the same motion 25 times as fast, averaged 16 times would separate a from b by 63"
    )
    assert more is not None
    write_case(more, tmp_path)
    found = diagnose(read_case(tmp_path / "case.toml"), load("modified_dahl"))
    assert [e.id for e in found.effects] == ["inertia"]
    assert found.before.fit_over_noise > 100 and found.after.fit_over_noise < 1.1


def held_with_play(t: np.ndarray, z: np.ndarray, g: float, contact: float) -> np.ndarray:
    """The force [N] at z(t) [mm] on spring, dashpot and Dahl friction held between two stiff springs, g apart
    [mm] and of `contact` [N/mm]: an overdamped node, by small steps."""
    K, c, h, rho = 0.38, 0.022, 0.09, 4.0
    dt, x, r, F = t[1] - t[0], z[0], 0.0, np.empty_like(z)
    for i in range(len(z)):
        over = max(abs(z[i] - x) - g / 2, 0.0)
        F[i] = np.sign(z[i] - x) * contact * over
        dx = (F[i] - K * x - h * r) / (c + (contact * dt if over else 0.0)) * dt
        side = np.sign(dx)
        r = side + (r - side) * np.exp(-rho * abs(dx))
        x += dx
    return F


@pytest.mark.slow
def test_a_sample_that_springs_back_in_its_play(tmp_path: Path) -> None:
    """Were its residual noise of which nobody stated the level, nothing would be missing."""
    t = np.arange(240000) / 20000.0
    z = 1.5 * np.sin(0.8 * np.pi * t + 3.0) + 0.25 * np.sin(4.2 * np.pi * t + 1.0)
    F = held_with_play(t, z, g=0.03, contact=60.0)
    rows = np.stack([t, z, F], axis=1)[::40]
    rows[:, 2] += 6e-4 * np.random.default_rng(202).standard_normal(len(rows))
    header = "t [s],z [mm],F_m [N]"
    np.savetxt(tmp_path / "r.csv", rows, "%.6f", ",", header=header, comments="")
    case = 'model = "modified_dahl"\n[[recording]]\nfile = "r.csv"\nrole = "fit"\n'
    (tmp_path / "case.toml").write_text(case)
    found = diagnose(read_case(tmp_path / "case.toml"), load("modified_dahl"))
    first = found.effects[0]
    assert first.id == "backlash" and not found.adequate
    d = next(p for p in first.parameters if p.name == "d")
    assert d.value == pytest.approx(0.38 * 0.015, rel=0.15)


def test_bursts_are_no_noise() -> None:
    rng = np.random.default_rng(5)
    e = rng.standard_normal(4000)
    slow = np.convolve(rng.standard_normal(4100), 0.98 ** np.arange(101), "valid")[:4000]
    lone = e + 30.0 * (rng.random(4000) < 0.01)
    for noise in (e, slow, lone, e * (1 + 0.8 * np.sin(np.arange(4000) / 300))):
        assert not fitful(noise[None])
    again = e + 20.0 * (np.arange(4000) % 500 < 12)
    once = e + 20.0 * (np.abs(np.arange(4000) - 900) < 12)
    assert fitful(again[None]) and not fitful(once[None])


@pytest.mark.slow
def test_a_flat_spectrum_of_relaxation_is_creep_or_structural_damping(tmp_path: Path) -> None:
    """Relaxation times of all lengths alike: a loss of the same share in each cycle, and creep by the
    logarithm of time. It is one law, and no recording tells its two names apart."""
    rng, text = np.random.default_rng(3), 'model = "modified_dahl"\n[noise]\nF_m = 1.85e-3\n'
    dt, rates = 4e-3, 2 * np.pi * np.geomspace(2e-3, 400, 54)
    for k, (lo, hi) in enumerate(((0.1, 1.0), (0.5, 8.0))):
        t = np.arange(0, 16, dt)
        z = 0.6 * np.sin(2 * np.pi * (lo * t + (hi - lo) * t**2 / 2 / t[-1]))
        arms, r, F, v = np.zeros(len(rates)), 0.0, np.empty_like(t), np.gradient(z, t)
        for i, dz in enumerate(np.diff(z, prepend=z[0])):
            decay = np.exp(-rates * dt)
            arms = arms * decay + dz * (1 - decay) / (rates * dt)
            r = np.sign(dz) + (r - np.sign(dz)) * np.exp(-2.0 * abs(dz))
            F[i] = 0.4 * z[i] + 0.02 * v[i] + 0.09 * r + 0.005 * np.sum(arms)
        F += 1.85e-3 * rng.standard_normal(t.size)
        rows = np.column_stack([t, z, F])
        np.savetxt(tmp_path / f"r{k}.csv", rows, delimiter=",", header="t [s],z [mm],F_m [N]", comments="")
        text += f'[[recording]]\nfile = "r{k}.csv"\nrole = "fit"\n'
    (tmp_path / "case.toml").write_text(text)
    found = diagnose(read_case(tmp_path / "case.toml"), load("modified_dahl"))
    first = found.effects[0]
    assert {first.id, *first.equivalents} >= {"structural_damping", "power_law_viscoelasticity"}, (
        found.summary
    )


@pytest.mark.slow
def test_a_lag_that_takes_more_than_the_damping_gives(tmp_path: Path) -> None:
    """A force that is recorded late through k τ > c looks as if it were driven: the damping is at its end, 0,
    and says nothing of what the lag may do."""
    (tmp_path / "leaf.py").write_text(LEAF)
    rng, text = np.random.default_rng(4), 'model = "leaf.py:leaf"\n[noise]\nF = 0.02\n'
    for name, role, f in (("a", "fit", 3.0), ("b", "fit", 7.0), ("c", "holdout", 5.0)):
        t, w = np.arange(2400) / 500.0, 2 * np.pi * f
        turn = (6.0 + 0.01j * w) * np.exp(1j * (w * t + 0.3))
        F = (turn / (1 + 0.002j * w)).imag + 0.02 * rng.standard_normal(len(t))
        rows = np.stack([t, np.sin(w * t + 0.3), F], axis=1)
        np.savetxt(tmp_path / f"{name}.csv", rows, "%.7g", ",", header="t [s],z [mm],F [N]", comments="")
        text += f'[[recording]]\nfile = "{name}.csv"\nrole = "{role}"\n'
    (tmp_path / "case.toml").write_text(text)
    model, case = open_case(tmp_path / "case.toml")
    v = diagnose(case, model)
    assert [e.id for e in v.effects] in (["force_sensor_lag"], ["sensor_delay"]), v.summary
    assert v.after.holdout_over_noise == pytest.approx(1.0, abs=0.1)


LEAF = """from modelgen.language import Equation, Input, Model, Parameter, Port, rate_of

t, z = Input("t", "s"), Input("z", "mm")
v = rate_of(z, "v", "mm/s")
k, c = Parameter("k", "N/mm", 4.0, (0.1, 1e3)), Parameter("c", "N*s/mm", 0.01, (0.0, 1.0))
F = Equation("F", k * z + c * v, "N")
leaf = Model("leaf", (t, z, v), (k, c), (F,), ("F",), (Port("leaf", "force", "F", (("z", z),)),))
"""
