"""Hum in the channel of a displacement is no motion."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen.diagnose.noise.humming import without_hum
from modelgen.models import load
from modelgen.recordings import Case, Recording

T = np.arange(4000) / 1000
MOTION, HUM, LINE = 8 * np.sin(2 * np.pi * 1.3 * T), 0.02 * np.sin(2 * np.pi * 51.3 * T + 0.4), 51.3
SPEED = np.gradient(MOTION, T)


def case(shown: np.ndarray, force: np.ndarray, t: np.ndarray = T) -> Case:
    rng = np.random.default_rng(4)
    z, F = shown + 3e-4 * rng.standard_normal(len(t)), force + 0.05 * rng.standard_normal(len(t))
    return Case(None, "kelvin_voigt", (Recording("a", None, "fit", {"t": t, "z": z}, {"F": F}),))


def damped(z: np.ndarray) -> np.ndarray:
    return 2 * z + 0.1 * np.gradient(z, T) + 5 * np.tanh(np.gradient(z, T))


def test_a_hum_that_the_force_does_not_follow_is_taken_out() -> None:
    before = case(MOTION + HUM, damped(MOTION))
    after, (note,) = without_hum(load("kelvin_voigt"), before)
    assert note == "z hums in 'a', 0.02 mm at 51.3 Hz, which F does not follow: taken out of z"
    clean = case(MOTION, damped(MOTION)).recordings[0].inputs["z"]
    assert np.abs(after.recordings[0].inputs["z"] - clean)[100:-100].max() < 1e-3
    assert without_hum(load("kelvin_voigt"), after) == (after, ())


@pytest.mark.parametrize("moves", [True, False])
def test_what_moves_in_truth_or_only_scatters_stays(moves: bool) -> None:
    z = MOTION + HUM if moves else MOTION
    before = case(z, damped(z))
    assert without_hum(load("kelvin_voigt"), before) == (before, ())


def test_the_lines_of_a_motion_and_times_that_are_uneven_are_left_alone() -> None:
    lines = MOTION + sum(0.5 * np.sin(2 * np.pi * f * T + f) for f in (3.0, 7.1, 11.7))
    uneven = T + 2e-4 * np.sin(40 * T)
    for before in (case(lines, damped(lines)), case(MOTION + HUM, damped(MOTION), uneven)):
        assert without_hum(load("kelvin_voigt"), before) == (before, ())
