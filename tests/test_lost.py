"""Samples of a displacement that were lost are told from blows and steps by the force recorded with them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import modelgen as mg
from modelgen.diagnose import diagnose
from modelgen.diagnose.noise.bridged import bridged
from modelgen.diagnose.noise.lost import without_lost
from modelgen.models import load
from modelgen.recordings import Case, Recording

T = np.arange(2000) * 2e-3


def swing() -> np.ndarray:
    """(2000,) displacements [mm] of 1 Hz, growing."""
    return (1 + T) * np.sin(2 * np.pi * T)


def force(z: np.ndarray, noise: float = 0.02, seed: int = 5) -> np.ndarray:
    """(2000,) forces [N] of a spring that creeps."""
    rng = np.random.default_rng(seed)
    slow = np.convolve(z, np.exp(-T[:300] / 0.1) * 0.02)[: T.size]
    return 3 * z - slow + noise * rng.standard_normal(T.size)


@given(
    begin=st.integers(20, 1950),
    length=st.integers(2, 20),
    size=st.floats(3.0, 50.0),
    stays=st.booleans(),
    seed=st.integers(0, 9),
)
@settings(max_examples=60, deadline=None)
def test_a_run_that_the_force_knows_nothing_of_is_bridged(
    begin: int, length: int, size: float, stays: bool, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    clean = swing() + 3e-3 * rng.standard_normal(T.size)
    z, lost = clean.copy(), np.arange(begin, begin + length)
    z[lost] = 12 + size if stays else z[lost] - 5 - size
    path, found = without_lost(T, z, [force(clean)])
    np.testing.assert_array_equal(found, lost)
    assert np.abs(path - clean).max() < 0.05


@pytest.mark.parametrize("lost", [[0], [0, 1, 2], [1999], [1998, 1999], [0, 1999]])
def test_lost_samples_at_an_end_follow_their_neighbours(lost: list[int]) -> None:
    clean = swing()
    z = clean.copy()
    z[lost] += 60
    path, found = without_lost(T, z, [force(clean)])
    np.testing.assert_array_equal(found, lost)
    assert np.abs(path - clean).max() < 0.05


def step() -> np.ndarray:
    return np.where(np.arange(T.size) < 1, 0.0, 1.0)


@pytest.mark.parametrize(
    "z",
    [
        swing(),
        step(),  # a relaxation whose first sample was taken before it
        np.where(np.abs(T - 2) < 0.021, 5.0, 0.0) + 0.01 * swing(),  # a blow
        np.sign(swing()),
        np.round(swing(), 1),
    ],
)
def test_what_the_force_feels_is_motion(z: np.ndarray) -> None:
    path, found = without_lost(T, z, [force(z)])
    assert found.size == 0 and path is z


def test_where_no_force_would_show_it_nothing_is_lost() -> None:
    z = swing()
    z[700:706] += 3.0
    assert without_lost(T, z, [force(z, noise=4.0)])[1].size == 0
    assert without_lost(T, z, [])[1].size == 0


def test_what_was_lost_is_said_and_explained_by_nothing() -> None:
    model = load("kelvin_voigt")
    records = []
    for k, name in enumerate(("a", "b")):
        z = swing() * (1 + 0.3 * k)
        F = np.asarray(mg.build(model)(t=T, z=z, k_D=3.0, c_D=0.02, F_0=0.0))
        F = F + 0.02 * np.random.default_rng(k).standard_normal(T.size)
        z[[0, 1999]] = 90.0
        z[800:812] = 0.0
        records.append(Recording(name, None, "fit", {"t": T, "z": z}, {"F": F}))
    case = Case(None, "lost", tuple(records))
    _, notes = bridged(model, case)
    assert [n.split(" lie ")[0] for n in notes] == [f"14 samples of z in '{n}'" for n in "ab"]
    verdict = diagnose(case, model)
    assert verdict.adequate and set(notes) <= set(verdict.notes)
