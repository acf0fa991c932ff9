"""What follows the motion is no noise, and what ignores it is no physics of the sample."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import butter, lfilter, sosfilt

from modelgen.api import read_case
from modelgen.diagnose import Verdict, diagnose
from modelgen.diagnose.noise.follows import following, ignores_motion
from modelgen.fit.series import Series
from modelgen.fit.whitener import Whitener
from modelgen.models import load

MOTIONS = ((0.4, 2.0), (1.3, 1.2), (3.1, 0.6))
RATE = 200.0


def rounded_off(rng: np.random.Generator, n: int, order: int = 4, part: float = 30.0) -> np.ndarray:
    """Noise behind a low-pass of so high an order at a part of the rate, standard deviation 1."""
    x = sosfilt(butter(order, 2 / part, output="sos"), rng.standard_normal(n + 1000))[1000:]
    return np.asarray(x / x.std())


def joined(rng: np.random.Generator, n: int, every: int = 5) -> np.ndarray:
    """Noise of which a slower logger took every fifth sample, and straight lines between them."""
    x = rng.standard_normal(n // every + 2)
    return np.asarray(np.interp(np.arange(n) / every, np.arange(len(x)), x))


def motion(f: float, A: float, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    t = np.arange(n) / RATE
    return t, A * np.sin(2 * np.pi * f * t), 2 * np.pi * f * A * np.cos(2 * np.pi * f * t)


def judged(folder: Path, make_noise, k: float, level: float) -> Verdict:  # type: ignore[no-untyped-def]
    """Three motions of a spring, a dashpot and a Maxwell branch of stiffness `k`, relaxing in 0.2 s, in noise
    whose level nobody states, and a little that is independent."""
    rng, n, tau, text = np.random.default_rng(4), 2500, 0.2, 'model = "kelvin_voigt"\n'
    for i, (f, A) in enumerate(MOTIONS):
        t, z, v = motion(f, A, n)
        decay = np.exp(-1 / (RATE * tau))
        branch = lfilter([k, -k], [1, -decay], z)  # a step of z relaxes exponentially
        F = 0.5 * z + 0.02 * v + branch + level * make_noise(rng, n) + 0.02 * level * rng.standard_normal(n)
        rows = np.column_stack([t, z, F])
        np.savetxt(folder / f"r{i}.csv", rows, "%.9g", ",", header="t [s],z [mm],F_m [N]", comments="")
        text += f'[[recording]]\nfile = "r{i}.csv"\n'
    (folder / "case.toml").write_text(text)
    return diagnose(read_case(folder / "case.toml"), load("kelvin_voigt"))


def test_noise_that_a_filter_has_rounded_off_is_no_physics(tmp_path: Path) -> None:
    """Neighbours differ by a tenth of it, and no first order describes it."""
    assert judged(tmp_path, rounded_off, 0.0, 0.02).adequate


@pytest.mark.slow
def test_a_law_that_holds_in_all_motions_is_no_colour(tmp_path: Path) -> None:
    """Less than the noise, and slower: a filter of the residual foretells it as well as the law does."""
    v = judged(tmp_path, joined, 0.008, 0.01)
    assert len(v.effects) == 1
    assert "maxwell_branch" in {v.effects[0].id, *v.effects[0].equivalents}


def records(rng: np.random.Generator) -> list[Series]:
    found = []
    for f, A in MOTIONS:
        t, z, v = motion(f * rng.uniform(0.8, 1.25), A, 2000)
        inputs = {"t": t, "z": z, "v": v}
        whitener = Whitener(np.ones((1, 2000)))
        found.append(Series("r", "fit", inputs, np.zeros((1, 2000)), "real", (0,), "N", whitener))
    return found


@settings(deadline=None, max_examples=12, derandomize=True)
@given(st.integers(0, 10_000), st.sampled_from([12.0, 30.0, 80.0]))
def test_noise_of_any_colour_ignores_the_motion_and_a_function_of_it_does_not(seed: int, part: float) -> None:
    rng, model = np.random.default_rng(seed), load("kelvin_voigt")
    series = records(rng)
    white = [rounded_off(rng, 2000, part=part)[None] for _ in series]
    assert ignores_motion(model, series, white)
    missed = [e + 2.0 * np.abs(s.inputs["z"]) ** 1.5 for s, e in zip(series, white, strict=True)]
    assert not ignores_motion(model, series, missed)


def test_functions_of_the_motion_hold_memories_and_hysteresis() -> None:
    model, series = load("kelvin_voigt"), records(np.random.default_rng(1))
    for make in (lambda z: lfilter([0.02], [1, -0.98], z), lambda z: np.sign(np.gradient(z)) * np.abs(z)):
        white = [make(s.inputs["z"])[None] for s in series]
        parts = following(model, series, white)
        assert parts is not None
        for e, part in zip(white, parts, strict=True):
            assert np.sum((e - e.mean() - part) ** 2) < 0.01 * np.sum((e - e.mean()) ** 2)


def test_a_record_too_short_for_them_tells_nothing() -> None:
    model, (s, *_) = load("kelvin_voigt"), records(np.random.default_rng(2))
    short = replace(s, inputs={k: x[:300] for k, x in s.inputs.items()}, data=s.data[:, :300])
    e = np.random.default_rng(3).standard_normal((1, 300))
    assert following(model, [short], [e]) is None
    assert not ignores_motion(model, [short], [e])


def test_a_record_at_rest_follows_nothing() -> None:
    model, (s, other, *_) = load("kelvin_voigt"), records(np.random.default_rng(5))
    still = replace(s, inputs={"t": s.inputs["t"], "z": np.full(2000, 0.3), "v": np.zeros(2000)})
    e = np.random.default_rng(6).standard_normal((1, 2000))
    for series in ([still], [still, other]):
        parts = following(model, series, [e] * len(series))
        assert parts is not None and not parts[0].any()
        assert ignores_motion(model, series, [e] * len(series))
