"""Rows of a recording that hold the same values in all columns were lost: a recorder had stopped."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import modelgen as mg
from modelgen.recordings.lost_rows import lost_rows

RNG = np.random.default_rng(11)
N = 1500
t = np.arange(N) / 250
z = 2 * np.sin(2 * np.pi * 0.7 * t) + 0.3
F = 1.4 * z + 0.5 + 0.01 * RNG.normal(size=N)


@settings(deadline=None, max_examples=40)
@given(st.integers(20, N - 200), st.integers(3, 100))
def test_a_burst_of_zeros_in_all_columns_is_lost(begin: int, length: int) -> None:
    x, y = z.copy(), F.copy()
    x[begin : begin + length] = y[begin : begin + length] = 0.0
    run = np.zeros(N, dtype=bool)
    run[begin : begin + length] = True
    found = lost_rows([x, y])
    jumps = np.abs(np.diff(y))[[begin - 1, begin + length - 1]].min() > 0.5
    assert np.array_equal(found, run) or not jumps


def test_rows_that_hold_the_last_good_one_are_lost() -> None:
    x, y = z.copy(), F.copy()
    x[401:430], y[401:430] = x[400], y[400]
    found = lost_rows([x, y])
    assert found[401:430].all() and found.sum() == 29


def test_what_rests_or_is_rounded_was_recorded() -> None:
    still = np.clip(z, -1.0, 1.2)
    assert not lost_rows([still, 1.4 * still]).any()
    assert not lost_rows([np.round(z, 1), np.round(F, 0)]).any()
    y = F.copy()
    y[300:320] = 0.0  # while the other column goes on
    assert not lost_rows([z, y]).any()
    assert not lost_rows([np.full(N, 3.0), y]).any()


def test_lost_rows_are_left_out_of_fits_and_diagnoses(tmp_path: Path) -> None:
    x, y = z.copy(), 1.2 * z + 0.06 * np.gradient(z, t) + 0.4 + 0.02 * RNG.normal(size=N)
    for begin, length in ((310, 25), (905, 31)):
        x[begin : begin + length] = y[begin : begin + length] = 0.0
    np.savetxt(tmp_path / "x.csv", np.c_[t, x, y], delimiter=",", header="t [s],z [mm],F_m [N]", comments="")
    (tmp_path / "case.toml").write_text(
        'model = "kelvin_voigt"\n[noise]\nF_m = 0.02\n[[recording]]\nfile = "x.csv"\nrole = "fit"\n'
    )
    model, case = mg.open_case(tmp_path / "case.toml")
    fit = mg.fit(model, case)
    assert fit.values["k_D"] == pytest.approx(1.2, abs=0.005)
    assert "56 rows hold the same values in all columns and then jump: left out as lost" in fit.warnings[0]
    assert mg.diagnose(case, model).adequate
