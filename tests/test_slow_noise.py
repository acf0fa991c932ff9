"""Noise of 1/f over time: its slowest waves look like a zero point that drifts."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelgen.api import read_case
from modelgen.diagnose import Verdict, diagnose
from modelgen.diagnose.noise.slow import gain_in_slow_noise
from modelgen.fit.colour import coloured
from modelgen.fit.whitener import Whitener
from modelgen.models import load


def noise(rng: np.random.Generator, n: int, power: float) -> np.ndarray:
    """Of a power 1/f^power, standard deviation 1."""
    spectrum = np.fft.rfft(rng.standard_normal(2 * n))
    spectrum[1:] /= np.arange(1.0, len(spectrum)) ** (power / 2)
    spectrum[0] = 0
    x = np.fft.irfft(spectrum)[:n]
    return np.asarray(x / x.std())


def gained(y: np.ndarray, slow: np.ndarray) -> tuple[float, float]:
    """What free amounts of `slow` (n, k) gain in −2 ln of the likelihood under the colour of what is left,
    and what they gain in slow noise."""
    left = y - slow @ np.linalg.lstsq(slow, y, rcond=None)[0]
    plain = [Whitener(np.ones((1, len(y))))]
    old, new = (coloured(plain, [x[None]], 12, slow=True) for x in (y, left))
    was, then = (new[0].colour(x[None]) for x in (y, left))
    gain = len(y) * float(np.log(np.sum(was**2) / np.sum(then**2)))
    return gain, gain_in_slow_noise(old, [y[None]], new, [left[None]])


def drift(n: int) -> np.ndarray:
    """A constant and the slowest waves (n, 5)."""
    t = np.arange(n) / n
    return np.stack([np.ones(n), t, np.cos(np.pi * t), np.cos(2 * np.pi * t), np.sin(2 * np.pi * t)], axis=1)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10_000), st.sampled_from([0.7, 1.0, 1.3]))
def test_what_takes_the_slowest_waves_of_slow_noise_gains_next_to_nothing(seed: int, power: float) -> None:
    gain = min(gained(noise(np.random.default_rng(seed), 4000, power), drift(4000)))
    assert gain < 10 + 5 * np.log(4000)  # what it would have to gain to be claimed


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10_000))
def test_a_drift_beside_independent_noise_is_no_slow_noise(seed: int) -> None:
    rng = np.random.default_rng(seed)
    y = rng.standard_normal(4000) + 0.3 * np.linspace(-1, 1, 4000)
    assert min(gained(y, drift(4000)[:, :2])) > 10 + np.log(4000)


def judged(folder: Path, seed: int, power: float, wanders: float) -> Verdict:
    """Two motions of a spring and a dashpot in slow noise, and the zero point that runs away by so much."""
    rng, n, text = np.random.default_rng(seed), 5000, 'model = "kelvin_voigt"\n'
    for k, (f, A) in enumerate([(0.4, 2.0), (1.1, 1.0)]):
        t = np.arange(n) / 200.0
        z, v = A * np.sin(2 * np.pi * f * t), 2 * np.pi * f * A * np.cos(2 * np.pi * f * t)
        F = 0.5 * z + 0.02 * v + 0.01 * noise(rng, n, power) + 0.002 * rng.standard_normal(n)
        F += wanders * np.exp(-t / 6)
        np.savetxt(
            folder / f"r{k}.csv", np.column_stack([t, z, F]), "%.8g", ",", header="t [s],z [mm],F [N]",
            comments="",
        )  # fmt: skip
        text += f'[[recording]]\nfile = "r{k}.csv"\n'
    (folder / "case.toml").write_text(text)
    return diagnose(read_case(folder / "case.toml"), load("kelvin_voigt"))


@pytest.mark.parametrize("seed", [1, *(pytest.param(n, marks=pytest.mark.slow) for n in (2, 3))])
def test_slow_noise_is_no_drift(tmp_path: Path, seed: int) -> None:
    assert judged(tmp_path, seed, 1.0, 0.0).adequate


@pytest.mark.slow
def test_a_drift_far_above_slow_noise_is_one(tmp_path: Path) -> None:
    v = judged(tmp_path, 1, 1.0, 0.2)
    assert [e.id for e in v.effects] == ["offset_drift"]


@pytest.mark.parametrize("wanders", [0.15, pytest.param(0.2, marks=pytest.mark.slow)])
def test_a_stated_noise_is_no_slow_one(tmp_path: Path, wanders: float) -> None:
    """Of independent noise, a softening and a drift together make what looks like noise of 1/f."""
    rng, text = np.random.default_rng(3), 'model = "kelvin_voigt"\n[noise]\nF_m = 0.02\n'
    for k, (f, A, n, rate) in enumerate([(0.4, 2.0, 1500, 60), (1.2, 1.0, 1800, 150)]):
        t = np.arange(n) / rate
        z = A * np.minimum(1, t * f / 4) * np.sin(2 * np.pi * f * t)
        virgin = np.exp(-((np.cumsum(np.abs(np.diff(z, prepend=0))) / 24) ** 0.7))
        F = 0.5 * z * (1 + 0.14 * virgin) + 0.02 * np.gradient(z, t) + wanders * (1 - np.exp(-t / 15))
        F += 0.02 * rng.standard_normal(n)
        rows = np.column_stack([t, z, F])
        np.savetxt(tmp_path / f"r{k}.csv", rows, "%.8g", ",", header="t [s],z [mm],F_m [N]", comments="")
        text += f'[[recording]]\nfile = "r{k}.csv"\n'
    (tmp_path / "case.toml").write_text(text)
    v = diagnose(read_case(tmp_path / "case.toml"), load("kelvin_voigt"))
    assert {e.id for e in v.effects} == {"offset_drift", "stress_softening"}
    assert v.after.fit_over_noise < 1.02
