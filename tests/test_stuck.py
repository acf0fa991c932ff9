"""Readings that a recorder lost: runs of one value are no physics, what stops or rests is none of them."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import modelgen as mg
from modelgen.diagnose.noise.stuck import stuck

RNG = np.random.default_rng(7)
N = 2000
t = np.arange(N) / 200
NOISE = 0.02
CLEAN = 3 * np.sin(2 * np.pi * 1.3 * t) + 0.5
NOISY = CLEAN + NOISE * RNG.normal(size=N)


def lost(y: NDArray[np.float64], model: NDArray[np.float64] = CLEAN) -> NDArray[np.bool_]:
    return stuck(y[None], (model - y)[None] / NOISE)


@pytest.mark.parametrize(("begin", "length"), [(310, 2), (500, 4), (901, 15), (1500, 40)])
def test_a_run_of_zeros_is_lost(begin: int, length: int) -> None:
    y = NOISY.copy()
    y[begin : begin + length] = 0.0
    run = np.zeros(N, dtype=bool)
    run[begin : begin + length] = True
    assert np.array_equal(lost(y), run)


def test_a_value_that_is_held_is_lost_until_it_comes_back() -> None:
    y = NOISY.copy()
    y[700:725] = y[699]
    assert lost(y)[701:725].all() and lost(y).sum() <= 26


def test_what_clips_rests_or_is_rounded_is_not_lost() -> None:
    clipped = np.clip(NOISY, -1.5, 1.5)
    assert not lost(clipped).any()
    resting = np.where((t > 3) & (t < 5), 0.7, CLEAN)
    assert not lost(resting + 0.0, resting + NOISE * RNG.normal(size=N)).any()
    assert not lost(np.round(NOISY / 0.1) * 0.1).any()
    stop = CLEAN + 4.0 * np.maximum(CLEAN - 3.2, 0)  # of which the model knows nothing
    assert not lost(stop + NOISE * RNG.normal(size=N)).any()


def test_lost_readings_are_no_physics(tmp_path: Path) -> None:
    z = np.sin(2 * np.pi * 0.8 * t) * (1 - np.exp(-3 * t**2))
    v = np.gradient(z, t)
    F = 12 * z + 0.15 * v + 3 + 0.04 * RNG.normal(size=N)
    for begin, length in ((240, 4), (960, 1), (1204, 5), (1650, 6)):
        F[begin : begin + length] = 0.0
    np.savetxt(tmp_path / "x.csv", np.c_[t, z, F], delimiter=",", header="t [s],z [mm],F_m [N]", comments="")
    (tmp_path / "case.toml").write_text(
        'model = "kelvin_voigt"\n[noise]\nF_m = 0.04\n[[recording]]\nfile = "x.csv"\nrole = "fit"\n'
    )
    model, case = mg.open_case(tmp_path / "case.toml")
    verdict = mg.diagnose(case, model)
    assert verdict.adequate
    assert "16 outliers in 'x' are marked and weigh nothing" in verdict.notes
