"""A noise that is all there as it was stated leaves no room for a coloured one beside it; others do."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from modelgen.diagnose import diagnose
from modelgen.diagnose.verdict import Verdict
from modelgen.models import load
from modelgen.recordings import Case, Noise, Recording

T = np.arange(3000) * 4e-3


def verdict(beside: np.ndarray, noise: np.ndarray, stated: float | None = 0.1) -> Verdict:
    """Of a spring and a dashpot whose force is recorded with `noise` and what is `beside` it."""
    z = 2 * np.sin(2 * np.pi * 0.8 * T) + np.sin(2 * np.pi * 2.3 * T + 1)
    v = np.gradient(z, T)
    F = 4 * z + 0.1 * v + beside + noise
    record = Recording("run", None, "fit", {"t": T, "z": z}, {"F": F})
    told = Noise() if stated is None else Noise({"F": stated})
    return diagnose(Case(None, "kelvin_voigt", (record,), noise=told), load("kelvin_voigt"))


def white(seed: int = 3) -> np.ndarray:
    return 0.1 * np.random.default_rng(seed).standard_normal(T.size)


def valve() -> np.ndarray:
    """(3000,) a force of a valve that opens and closes when it likes."""
    rng = np.random.default_rng(6)
    levels = np.repeat(rng.choice([-0.07, 0.0, 0.07], 30), 100)
    return np.asarray(lfilter([0.2], [1, -0.8], levels))


def test_what_is_slower_than_a_stated_noise_that_is_all_there_is_unknown() -> None:
    found = verdict(valve(), white())
    assert [e.id for e in found.effects] == ["unknown_force"] and found.effects[0].probability < 0.6
    assert "something slower is left" in found.summary


@pytest.mark.parametrize(
    ("beside", "noise", "stated"),
    [
        (0 * T, white(), 0.1),
        (0 * T, lfilter([np.sqrt(1 - 0.9**2)], [1, -0.9], white()), 0.1),  # all of it is coloured
        (0 * T, white(), 0.05),  # a statement that is wrong by two
        (valve(), white(), None),  # nobody stated what is noise
    ],
)
def test_other_noise_is_noise(beside: np.ndarray, noise: np.ndarray, stated: float | None) -> None:
    assert verdict(beside, noise, stated).adequate
