"""Noise of one instrument is the same in all recordings: what is coloured in one alone is no noise."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import modelgen as mg
from modelgen.api import read_case
from modelgen.diagnose import diagnose
from modelgen.diagnose.hypotheses.setting import Setting
from modelgen.diagnose.noise.one_instrument import colours
from modelgen.diagnose.noise.recolour import own_colours
from modelgen.diagnose.search.search import white_judge
from modelgen.fit.series import make_series
from modelgen.models import load
from modelgen.recordings import Case, Recording
from modelgen.truths import draw, write_case

N = 3000


def two_recordings(dt: tuple[float, float]) -> Setting:
    """A model over time and two recordings of white noise, sampled every `dt` seconds."""
    rng = np.random.default_rng(5)
    model = load("modified_dahl")

    def recording(k: int) -> Recording:
        t = dt[k] * np.arange(N)
        inputs = {"t": t, "z": np.sin(2 * np.pi * t / (300 * dt[k]))}
        return Recording(f"rec_{k}", None, "fit", inputs, {"F": rng.standard_normal(N)})

    case = Case(None, model.id, tuple(recording(k) for k in (0, 1)))
    return Setting(model, case, tuple(make_series(model, case, r) for r in case.recordings), ())


def noise(rho: float, seed: int) -> np.ndarray:
    """(1, N) of the first order."""
    rng, x = np.random.default_rng(seed), np.zeros(N)
    for i, e in enumerate(rng.standard_normal(N)):
        x[i] = rho * x[i - 1] + e
    return x[None, :]


@pytest.mark.parametrize(
    ("rho", "dt", "coloured", "missed"),
    [
        pytest.param((0.6, 0.6), (0.01, 0.01), (True, True), (False, False), id="coloured in both"),
        pytest.param((0.6, 0.0), (0.01, 0.01), (False, False), (True, False), id="in the other it is white"),
        pytest.param((0.6, 0.0), (0.01, 0.005), (False, False), (True, False), id="sampled faster"),
        pytest.param(
            (0.6, 0.0), (0.005, 0.01), (True, False), (False, False), id="sampled too slowly to tell"
        ),
        pytest.param((0.0, 0.0), (0.01, 0.01), (False, False), (False, False), id="white in both"),
    ],
)
def test_what_is_coloured_in_one_recording_alone_is_no_noise(
    rho: tuple[float, float],
    dt: tuple[float, float],
    coloured: tuple[bool, bool],
    missed: tuple[bool, bool],
) -> None:
    s = two_recordings(dt)
    plain = [replace(x.whitener, ar=None) for x in s.series]
    found, marked = colours(s, plain, [noise(r, k) for k, r in enumerate(rho)])
    assert tuple(w.order > 0 for w in found) == coloured
    assert marked == missed


@pytest.mark.slow
def test_a_pair_that_one_recording_shows_is_not_taken_for_noise(tmp_path: Path) -> None:
    secret = draw(204900079, "pair", "force", ("magnetic_pull", "end_stop"), (30.0, 1e4), "clean", 3.0)
    write_case(secret, tmp_path)
    found = diagnose(read_case(tmp_path / "case.toml"), load("modified_dahl"))
    named = {name for e in found.effects for name in (e.id, *e.equivalents)}
    assert {"magnetic_pull", "end_stop"} <= named
    assert found.after.fit_over_noise == pytest.approx(1.0, abs=0.02)


@pytest.mark.slow
def test_a_long_memory_of_the_noise_is_no_physics(tmp_path: Path) -> None:
    """ρ = 0.98, no level stated: nine times what the scatter between neighbours tells, which physics would
    leave as well."""
    rng, model = np.random.default_rng(1), load("modified_dahl")
    true = {"k_D": 0.68, "c_D": 0.137, "h_D": 0.231, "rho": 1.44, "F_0": 1.3, "r_0": -0.8}
    text = f'model = "{model.id}"\n'
    for k in (0, 1):
        t = np.arange(N) / 200.0
        z = -np.cos(3.1 * t) * (0.7 + 0.3 * np.cos(0.82 * t + k))
        F = mg.build(model)(t=t, z=z, **true) + 0.002 * noise(0.98, int(rng.integers(1000)))[0]
        table = np.column_stack([t, z, F])
        np.savetxt(
            tmp_path / f"{k}.csv", table, delimiter=",", header="t [s],z [mm],F [N]", comments="", fmt="%.9g"
        )
        text += f'[[recording]]\nfile = "{k}.csv"\n'
    (tmp_path / "case.toml").write_text(text)
    found = diagnose(read_case(tmp_path / "case.toml"), model)
    assert found.adequate, found.summary


def test_what_one_account_shows_to_be_no_noise_is_none_under_the_other() -> None:
    """The better account shows that the instrument's noise is white; the poorer one, coloured in both
    recordings, may not call what it misses noise."""
    s = two_recordings((0.01, 0.01))
    judge = white_judge(s.series)

    def account(*residuals: np.ndarray) -> Any:
        e = [x / w.weight for x, w in zip(residuals, judge.whiteners, strict=True)]
        experiment = SimpleNamespace(raw=lambda theta, k: e[k])
        return SimpleNamespace(hypothesis=SimpleNamespace(experiment=experiment), theta=None, parameters=4)

    poor = account(noise(0.6, 1), noise(0.97, 2) * 1.2)
    better = account(noise(0.0, 3), noise(0.97, 2))
    apart = [own_colours(s, judge, [x])[0] for x in (poor, better)]
    together = own_colours(s, judge, [poor, better])
    assert apart[0] < apart[1]
    assert together[1] == apart[1]
    assert together[0] > together[1] + 10
