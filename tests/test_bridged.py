"""Glitches of a recorded displacement are bridged; fast motion is none."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import modelgen as mg
from modelgen.diagnose import diagnose
from modelgen.diagnose.noise.bridged import bridged, without_glitches
from modelgen.models import load
from modelgen.recordings import Case, Recording

T = np.arange(2000) * 2e-3


def swing(cycles: float = 1.0) -> np.ndarray:
    """(2000,) displacements [mm], growing."""
    return (1 + T) * np.sin(2 * np.pi * cycles * T)


@given(
    at=st.lists(st.integers(1, 248), min_size=1, max_size=6, unique=True).map(
        lambda x: 8 * np.array(sorted(x))
    ),
    size=st.floats(1.0, 50.0),
    seed=st.integers(0, 9),
)
@settings(max_examples=40, deadline=None)
def test_single_samples_far_off_the_path_are_bridged(at: np.ndarray, size: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    clean = swing() + 3e-3 * rng.standard_normal(T.size)
    z = clean.copy()
    z[at] += size * rng.choice([-1, 1], at.size)
    path, found = without_glitches(T, z)
    np.testing.assert_array_equal(found, at)
    assert np.abs(path - clean).max() < 0.03
    assert np.array_equal(np.delete(path, at), np.delete(clean, at))


@given(
    at=st.lists(st.integers(2, 240), min_size=8, max_size=14, unique=True).map(
        lambda x: 8 * np.array(sorted(x))
    ),
    size=st.floats(24.0, 60.0),
    cycles=st.floats(0.5, 8.0),
    seed=st.integers(0, 99),
)
@settings(max_examples=40, deadline=None)
def test_glitches_no_larger_than_a_step_are_seen_by_the_noise(
    at: np.ndarray, size: float, cycles: float, seed: int
) -> None:
    """24 standard deviations and more, where the path itself moves by up to 25 from sample to sample; but
    one that noise makes a part of a turn."""
    rng = np.random.default_rng(seed)
    clean = swing(cycles) / 25
    noise = 6e-3 * cycles / 8
    z = clean + noise * rng.standard_normal(T.size)
    z[at] += size * noise * rng.choice([-1, 1], at.size)
    path, found = without_glitches(T, z)
    assert set(found) <= set(at) and found.size >= 0.6 * at.size
    assert np.abs(path - clean)[found].max(initial=0.0) < 8 * noise


def corners() -> np.ndarray:
    return 4 * np.abs((3.1 * T) % 1 - 0.5)


@pytest.mark.parametrize("noise", [0.0, 1e-4, 3e-3])
@pytest.mark.parametrize(
    "z",
    [
        swing(),
        swing(60.0),  # eight samples a period
        corners(),
        np.clip(swing(8.0), -0.9, 0.9),  # a sensor that stays where the path turns
        np.sign(swing(0.7)),  # a step
        np.round(corners(), 1),  # a coarse encoder
        np.where(np.abs(T - 2) < 3.1e-3, 1.0, 0.0) * np.cos((T - 2) / 6.2e-3 * np.pi),  # a blow
    ],
)
def test_fast_motion_is_no_glitch(z: np.ndarray, noise: float) -> None:
    z = z + noise * np.random.default_rng(3).standard_normal(T.size)
    assert without_glitches(T, z)[1].size == 0


def test_what_a_hysteresis_would_remember_is_said_and_explained_by_nothing() -> None:
    """The modified Dahl model with its own force: a laser that lost its spot three times."""
    model = load("modified_dahl")
    rng = np.random.default_rng(8)
    true = {"F_0": 0.0, "c_D": 0.05, "h_D": 3.0, "k_D": 0.8, "rho": 1.2, "r_0": 0.0}
    records = []
    for name, cycles in (("slow", 0.5), ("fast", 1.5)):
        z = swing(cycles)
        F = np.asarray(mg.build(model)(t=T, z=z, **true)) + 0.05 * rng.standard_normal(T.size)
        z = z + 2e-3 * rng.standard_normal(T.size)
        z[[300, 901, 1500]] += (2.0, -3.0, 2.5)
        records.append(Recording(name, None, "fit", {"t": T, "z": z}, {"F": F}))
    case = Case(None, "lost", tuple(records))
    _, notes = bridged(model, case)
    assert notes == tuple(f"3 glitches of z in '{n}', single samples, are bridged" for n in ("slow", "fast"))
    verdict = diagnose(case, model)
    assert verdict.adequate and set(notes) <= set(verdict.notes)
    assert verdict.before.fit_over_noise == pytest.approx(1.0, abs=0.1)
