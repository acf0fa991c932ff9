"""Samples that had not rested before they were recorded: what a memory begins with is no physics left out."""

import numpy as np
import pytest
from scipy.special import gamma

from modelgen.diagnose import diagnose
from modelgen.models import load
from modelgen.recordings import Case, Recording

STEP, ALPHA = 0.02, 0.3


def springpot(z: np.ndarray) -> np.ndarray:
    """D^α of z, at rest at 0 before: the L1 scheme (K. B. Oldham, J. Spanier, The Fractional Calculus (1974),
    sec. 8.2)."""
    k = np.arange(len(z), dtype=float)
    weights = (k + 1) ** (1 - ALPHA) - k ** (1 - ALPHA)
    return np.convolve(np.diff(z, prepend=0.0), weights)[: len(z)] / (STEP**ALPHA * gamma(2 - ALPHA))


def record(name: str, role: str, seed: int, before: int, noise: float = 0.01) -> Recording:
    """A slow random motion of a spring and a springpot, of which the first `before` samples are not kept."""
    rng = np.random.default_rng(seed)
    t = STEP * np.arange(before + 1000)
    waves = zip(rng.uniform(0.1, 3.0, 8), rng.uniform(0, 6.3, 8), rng.uniform(0.2, 1.0, 8), strict=True)
    z = 1.5 + sum(size * np.sin(w * t + at) for w, at, size in waves)
    z = z * (1 - np.exp(-((t / 0.5) ** 2)))
    force = 0.5 * z + 0.8 * springpot(z) + noise * rng.standard_normal(len(t))
    return Recording(name, None, role, {"t": t[:1000], "z": z[before:]}, {"F": force[before:]})


@pytest.mark.slow
@pytest.mark.parametrize("before", [pytest.param(40, marks=pytest.mark.slow), 1500])
def test_what_a_sample_had_been_through_is_no_physics(before: int) -> None:
    records = (record("a", "fit", 1, before), record("b", "fit", 2, before))
    found = diagnose(Case(None, "fractional_kelvin_voigt", records), load("fractional_kelvin_voigt"))
    assert found.adequate
    assert any("had not rested" in n for n in found.notes)
    assert found.after.fit_over_noise < 1.1


@pytest.mark.slow
def test_a_sample_that_had_rested_has_no_past() -> None:
    whole = record("a", "fit", 3, 0)
    found = diagnose(Case(None, "fractional_kelvin_voigt", (whole,)), load("fractional_kelvin_voigt"))
    assert found.adequate and not any("had not rested" in n for n in found.notes)


def chirped(name: str, role: str, last: float, seed: int, late: float = 3e-4) -> Recording:
    """The same from 1 Hz to `last`, with noise of a thousandth, and a force that is recorded `late` [s]."""
    rng, step, n = np.random.default_rng(seed), 1 / 1500, 3000
    t = step * np.arange(n)
    growth = np.log(last) / t[-1]
    z = 0.8 * np.sin(2 * np.pi * np.expm1(growth * t) / growth)
    k = np.arange(n, dtype=float)
    weights = (k + 1) ** (1 - ALPHA) - k ** (1 - ALPHA)
    slow = np.convolve(np.diff(z, prepend=0.0), weights)[:n] / (step**ALPHA * gamma(2 - ALPHA))
    force = 30 * z + 9 * slow
    shown = np.interp(t - late, t, force) + 0.02 * rng.standard_normal(n)
    return Recording(name, None, role, {"t": t, "z": z}, {"F": shown})


@pytest.mark.slow  # two searches, 30 s
def test_a_lag_of_the_channel_is_no_past() -> None:
    """A base without the lag takes a past to make up for it; what is found beside it does without."""
    records = (chirped("a", "fit", 40.0, 1), chirped("b", "fit", 60.0, 2))
    found = diagnose(Case(None, "fractional_kelvin_voigt", records), load("fractional_kelvin_voigt"))
    assert {found.effects[0].id, *found.effects[0].equivalents} & {"force_sensor_lag", "sensor_delay"}
    assert len(found.effects) == 1 and not any("had not rested" in n for n in found.notes)
