"""Velocity, acceleration and reversals against analytic motion, in the noise of displacement records."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import isotonic_regression
from scipy.signal import savgol_coeffs

from modelgen.errors import InputError
from modelgen.recordings import Channel, Kinematics, Signature, kinematics, load_case, read_case_file
from modelgen.recordings.savgol import kernels
from modelgen.recordings.turns import rising

SHARED = Path(__file__).parents[2] / "shared" / "data"
NOISE = 2.88e-4  # mm, of the displacement sensor of the MRE paper
RATE = 4000.0  # Hz


def noisy(z: np.ndarray, seed: int, std: float = NOISE) -> np.ndarray:
    return z + std * np.random.default_rng(seed).standard_normal(z.size)


def rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.mean(x**2)))


def slow_sine(seconds: float = 50.0) -> tuple[np.ndarray, ...]:
    """3 mm at 0.1 Hz: t, z, v, a."""
    t, w = np.arange(int(seconds * RATE)) / RATE, 2 * np.pi * 0.1
    return t, 3 * np.sin(w * t), 3 * w * np.cos(w * t), -3 * w * w * np.sin(w * t)


def triangle() -> tuple[np.ndarray, ...]:
    """3 mm at 0.1 Hz with corners off the samples, and its speed of 1.2 mm/s."""
    t = np.arange(200_000) / RATE
    phase = (0.1 * t + 0.13) % 1
    return t, 3 * (1 - 4 * np.abs(phase - 0.5)), np.where(phase < 0.5, 1.2, -1.2)


def sweep() -> tuple[np.ndarray, ...]:
    """0.4 mm, 0.3 to 10 Hz in 30 s at 1 kHz."""
    t = np.arange(30_000) * 1e-3
    k = np.log(10 / 0.3) / 30
    phase, rate = 2 * np.pi * 0.3 * np.expm1(k * t) / k, 2 * np.pi * 0.3 * np.exp(k * t)
    return t, 0.4 * np.sin(phase), 0.4 * rate * np.cos(phase)


def multisine() -> tuple[np.ndarray, ...]:
    """A random multisine, most of its power above 10 samples a period, some down to 3."""
    n, rng = 4096, np.random.default_rng(3)
    t = np.arange(n) / 610.0
    w = 2 * np.pi * np.arange(1, 1300) * 610.0 / n
    size = 0.05 / (1 + (w / w[400]) ** 4)
    phase = np.outer(t, w) + rng.uniform(0, 2 * np.pi, w.size)
    return t, np.sin(phase) @ size, np.cos(phase) @ (size * w)


def test_without_noise_it_is_as_exact_as_differences_of_eighth_order() -> None:
    t, z, v, a = slow_sine()
    k = kinematics(t, z)
    assert k.sigma_z == 0 and np.array_equal(k.z, z)
    assert rms(k.v - v) < 1e-10 * rms(v)
    assert rms(k.a - a) < 1e-6 * rms(a)


@pytest.mark.parametrize("given_sigma", [None, 0.0])
def test_order_of_convergence_without_noise(given_sigma: float | None) -> None:
    errors = []
    for n in (401, 801):
        t = np.linspace(0, 10, n)
        errors.append(rms((kinematics(t, np.sin(8 * t), given_sigma).v - 8 * np.cos(8 * t))[8:-8]))
    assert np.log2(errors[0] / errors[1]) > 7.5


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_slow_sine_in_noise(seed: int) -> None:
    t, z, v, a = slow_sine()
    k = kinematics(t, noisy(z, seed))
    assert k.sigma_z == pytest.approx(NOISE, rel=0.03)
    assert k.reversals.size == 10 and np.count_nonzero(k.z_turn[1:] != k.z[:-1]) == 10
    raw = rms(np.diff(noisy(z, seed)) * RATE - v[1:])
    assert rms(k.v - v) < 5e-4 * rms(v) and raw / rms(k.v - v) > 2000
    assert rms(k.a - a) < 1e-2 * rms(a)
    assert rms(k.z - z) < 0.06 * NOISE
    np.testing.assert_allclose(np.abs(k.z_turn[k.reversals]), 3, atol=NOISE)


def test_triangle_in_noise_keeps_its_corners() -> None:
    t, z, v = triangle()
    k = kinematics(t, noisy(z, 1))
    assert k.reversals.size == 10
    assert rms(k.v - v) < 0.03 * 1.2
    corner = np.flatnonzero(np.diff(v))
    far = np.ones(t.size, dtype=bool)
    for n in corner:
        far[max(0, n - 100) : n + 100] = False
    assert rms((k.v - v)[far]) < 0.02 * 1.2
    assert np.abs(k.reversals - corner - 1).max() <= 10


def test_sweep_in_noise() -> None:
    t, z, v = sweep()
    k = kinematics(t, noisy(z, 2))
    assert rms(k.v - v) < 2e-3 * rms(v)
    assert k.window[1000:3000].mean() > 3 * k.window[-3000:-1000].mean()
    assert k.reversals.size == np.count_nonzero(np.diff(np.sign(v)))


@pytest.mark.parametrize("std", [0.0, 1e-3, 1e-2])
def test_a_signal_of_few_samples_a_period_is_not_smoothed_away(std: float) -> None:
    t, z, v = multisine()
    k = kinematics(t, noisy(z, 4, std))
    assert rms(k.z - z) <= 1.1 * std
    inner = slice(20, -20)
    assert rms((k.v - v)[inner]) < (0.02 + 1.5 * std * 610 / rms(v)) * rms(v)


@pytest.mark.slow
def test_stated_noise_of_velocity_is_the_noise_that_is_left() -> None:
    t, z, v, a = slow_sine(20.0)
    runs = [kinematics(t, noisy(z, seed), NOISE) for seed in range(12)]
    for found, true, stated in (
        ([k.v for k in runs], v, runs[0].sigma_v),
        ([k.a for k in runs], a, runs[0].sigma_a),
    ):
        inner = slice(4000, -4000)
        ratio = rms((np.array(found) - true)[:, inner]) / rms(stated[inner])
        assert 0.6 < ratio < 1.6


@pytest.mark.parametrize("std", [1e-4, 1e-3, 5e-3])
def test_what_smoothing_misses_of_a_fast_motion_counts_as_its_error(std: float) -> None:
    """Eight lines, the fastest of 30 samples a period: where noise hides that a quintic bends them."""
    n, rng = np.arange(4000), np.random.default_rng(1)
    w, phase = 2 * np.pi / 30 * np.arange(1, 9) / 8, rng.uniform(0, 2 * np.pi, 8)
    waves = np.outer(n, w) + phase
    exact = np.sin(waves).sum(1), np.cos(waves) @ w, -np.sin(waves) @ w**2
    k = kinematics(n, noisy(exact[0], 5, std), std)
    inner = slice(60, -60)
    for found, true, stated in ((k.v, exact[1], k.sigma_v), (k.a, exact[2], k.sigma_a)):
        assert 0.5 < rms((found - true)[inner] / stated[inner]) < 1.5


@pytest.mark.parametrize(("step", "limit"), [(1e-3, 1e-3), (1e-2, 5e-3), (1e-6, 1e-3)])
def test_an_encoder_and_rounded_numbers(step: float, limit: float) -> None:
    t, z, v, _ = slow_sine()
    k = kinematics(t, np.round(z / step) * step)
    assert rms(k.v - v) < limit * rms(v)
    assert k.reversals.size == 10


@pytest.mark.parametrize("std", [0.0, NOISE])
def test_rest_has_no_reversals(std: float) -> None:
    t = np.arange(40_000) / RATE
    for z in (np.zeros(t.size), np.minimum(t, 5.0)):  # at rest; a ramp and a hold
        assert kinematics(t, noisy(z, 5, std)).reversals.size == 0


def test_noise_at_rest_is_no_way_that_a_hysteresis_would_remember() -> None:
    t = np.arange(2000) / RATE
    z = np.round(np.interp(t, [0.0, 0.2, 0.3, 0.4, t[-1]], [0.0, 0.0, 1.0, 1.0, 0.5]), 2)
    z = np.convolve(np.pad(z, 20, mode="edge"), np.hanning(41) / np.hanning(41).sum(), "valid")
    k = kinematics(t, noisy(z, 6, 1e-3), 1e-3)
    assert np.abs(np.diff(k.z)).sum() < 1.02 * np.abs(np.diff(z)).sum()
    assert rms(k.z - z) < 1e-3


@pytest.mark.parametrize("late", [0.0, 0.25, 0.5, 0.9])
def test_ringing_at_the_corners_of_a_fast_ramp_is_no_reversal(late: float) -> None:
    """Rest, a ramp of some five samples, rest, half the way back, rest: it turns once, at the upper rest."""
    t = np.arange(120.0)
    z = np.interp(t, np.array([20.0, 25.0, 60.0, 63.0]) + late, [0.0, 1.0, 1.0, 0.5])
    k = kinematics(t, z, 0.0)
    assert k.reversals.size == 1
    assert k.z_turn[k.reversals] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("late", [0.0, 0.25, 0.5, 0.9])
def test_the_tip_of_a_corner_between_samples_is_where_its_sides_meet(late: float) -> None:
    t = np.arange(120.0)
    z = np.interp(t, np.array([0.0, 60.0, 120.0]) + late, [0.0, 1.0, -1.0])
    k = kinematics(t, z, 0.0)
    assert k.reversals.size == 1
    assert k.z_turn[k.reversals] == pytest.approx(1.0, abs=1e-2)


@pytest.mark.parametrize("seed", range(4))
def test_a_small_step_back_between_two_long_rests_turns_twice(seed: int) -> None:
    """A dozen times the noise, and no velocity is sure there."""
    t = np.arange(700) / RATE
    z = np.interp(t * RATE, [0.0, 200.0, 400.0, 401.0, 600.0, 700.0], [0.0, 1.0, 1.0, 0.988, 0.988, 2.0])
    assert kinematics(t, noisy(z, seed, 1e-3), 1e-3).reversals.size == 2


def test_where_a_step_goes_back_the_tip_is_no_farther_than_that() -> None:
    """A fast ramp that goes a little too far: the slope of what leads there says more than the samples do."""
    z = np.concatenate([np.arange(20.0), np.full(40, 19.4)])
    z[20] = 19.5
    k = kinematics(np.arange(60.0), z, 0.0)
    assert k.reversals.size == 1
    assert 19.5 <= k.z_turn[k.reversals[0]] <= 19.6 + 1e-9


@pytest.mark.parametrize("ramp", [15, 30, 45])
def test_corners_of_a_coarse_encoder_are_not_smoothed_away(ramp: int) -> None:
    """Rests and ramps of several steps a sample: rounding is an error of half a step, beside no other."""
    t, step = np.arange(900.0), 1 / 203.7
    at = np.ravel([[x, x + ramp] for x in (100.4, 250.7, 400.2, 550.9, 700.5)])
    z = np.interp(t, at, np.repeat([0.0, 0.62, 0.1, 1.0, 0.45, 0.8], 2)[1:-1])
    k = kinematics(t, np.round(z / step) * step)
    assert np.abs(k.z - z).max() < 2 * step
    assert k.reversals.size == 4


@pytest.mark.parametrize("slope", [0.3, 1.0, 3.0])
def test_corners_that_noise_hides_count_in_the_error_of_the_velocity(slope: float) -> None:
    """From rest to a slope of so many standard deviations of the noise a sample."""
    t, near, ratios = np.arange(600.0), slice(240, 360), []
    for seed in range(20):
        k = kinematics(t, noisy(slope * 1e-3 * np.maximum(t - 300.3, 0.0), seed, 1e-3), 1e-3)
        error = k.v - np.where(t > 300.3, slope * 1e-3, 0.0)
        ratios.append(rms(k.sigma_v[near]) / rms(error[near]))
    assert 0.45 < np.mean(ratios) < 1.3


@pytest.mark.parametrize(("period", "most"), [(24, 3.0), (40, 1.7), (80, 1.5)])
def test_noise_of_a_triangle_is_not_that_of_its_corners(period: int, most: float) -> None:
    t = np.arange(600.0)
    z = np.abs((t + 0.3) / period % 1 * 2 - 1)
    assert 1e-3 / 1.3 < kinematics(t, noisy(z, 1, 1e-3)).sigma_z < most * 1e-3


def test_turns_are_extremes_within_the_step() -> None:
    t = np.linspace(0, 20, 301)
    k = kinematics(t, np.sin(t + 0.3))
    assert k.reversals.size == 6
    np.testing.assert_allclose(np.abs(k.z_turn[k.reversals]), 1, atol=1e-7)
    np.testing.assert_allclose(np.delete(k.z_turn[1:], k.reversals - 1), np.delete(k.z[:-1], k.reversals - 1))


def test_log_spaced_and_jittered_times() -> None:
    t = np.logspace(-2, 1, 600)
    k = kinematics(t, np.sin(3 * t))
    assert rms(k.v - 3 * np.cos(3 * t)) < 1e-5 and rms(k.a + 9 * np.sin(3 * t)) < 1e-3
    rng = np.random.default_rng(6)
    t = np.arange(5000) * 1e-3 + rng.uniform(-3e-4, 3e-4, 5000)
    k = kinematics(t, np.sin(6 * t))
    assert np.array_equal(k.z, np.sin(6 * t)) and rms(k.v - 6 * np.cos(6 * t)) < 1e-6
    k = kinematics(t, noisy(np.sin(6 * t), 7, 1e-3))
    assert k.sigma_z == pytest.approx(1e-3, rel=0.15)
    assert rms(k.v - 6 * np.cos(6 * t)) < 5e-3 * 6 and k.reversals.size == 10


@pytest.mark.parametrize("n", [2, 3, 4, 5, 7, 8, 9, 10, 15, 23, 24, 40])
@pytest.mark.parametrize("sigma", [None, 0.0, 1e-3])
def test_a_straight_line_of_few_samples(n: int, sigma: float | None) -> None:
    t = np.linspace(0, 1, n)
    k = kinematics(t, 2 * t - 1, sigma)
    np.testing.assert_allclose(k.v, 2, atol=1e-9)
    np.testing.assert_allclose(k.a, 0, atol=1e-6)
    assert k.reversals.size == 0


def test_one_sample_is_at_rest() -> None:
    k = kinematics([0.0], [3.0])
    assert (k.z[0], k.v[0], k.a[0], k.z_turn[0]) == (3, 0, 0, 3)


@pytest.mark.parametrize(
    ("t", "z", "sigma"),
    [
        ([], [], None),
        ([0, 1], [1], None),
        ([0, 0], [1, 2], None),
        ([1, 0], [1, 2], None),
        ([0, 1], [1, np.nan], None),
        ([0, 1], [1, 2], -1.0),
        ([0, 1], [1, 2], np.inf),
    ],
)
def test_wrong_input(t: list[float], z: list[float], sigma: float | None) -> None:
    with pytest.raises(InputError) as why:
        kinematics(t, z, sigma)
    assert "\n" not in str(why.value)


def compare(k: Kinematics, other: Kinematics, gain: float, shift: float, pace: float) -> None:
    """`other` is k with z → gain z + shift, t → pace t."""
    size = float(np.ptp(k.z))
    np.testing.assert_allclose(other.z, gain * k.z + shift, atol=1e-6 * abs(gain) * size)
    for name, power in (("v", 1), ("a", 2)):
        wanted = gain * getattr(k, name) / pace**power
        np.testing.assert_allclose(getattr(other, name), wanted, atol=1e-5 * np.abs(wanted).max())
    np.testing.assert_array_equal(other.reversals, k.reversals)


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 1000),
    std=st.sampled_from([0.0, 1e-3, 1e-2]),
    gain=st.sampled_from([-100.0, -1.0, 0.01, 7.0]),
    shift=st.floats(-3, 3),
    start=st.floats(-50, 50),
    pace=st.sampled_from([0.01, 1.0, 30.0]),
)
def test_units_and_origins_do_not_matter(
    seed: int, std: float, gain: float, shift: float, start: float, pace: float
) -> None:
    t = np.arange(1200) * 0.01
    z = noisy(np.sin(2 * t) + 0.3 * np.sin(5 * t + seed), seed, std)
    compare(kinematics(t, z), kinematics(pace * t + start, gain * z + shift), gain, shift, pace)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10_000), n=st.integers(2, 400), std=st.sampled_from([0.0, 0.01, 1.0]))
def test_paths_are_monotonic_in_pieces(seed: int, n: int, std: float) -> None:
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.5, 1.5, n)) if seed % 2 else np.arange(n) * 1.0
    k = kinematics(t, np.sin(0.2 * t) + std * rng.standard_normal(n))
    for array in (k.z, k.v, k.a, k.z_turn, k.sigma_v, k.sigma_a):
        assert array.shape == (n,) and np.isfinite(array).all()
    low, high = np.minimum(k.z[1:], k.z[:-1]), np.maximum(k.z[1:], k.z[:-1])
    outside = (k.z_turn[1:] < low) | (k.z_turn[1:] > high)
    assert set(np.flatnonzero(outside) + 1) <= set(k.reversals)
    turns = np.concatenate((k.z[:1], k.z_turn[k.reversals], k.z[-1:]))
    if k.reversals.size > 1:
        assert (np.sign(np.diff(turns[1:-1]))[1:] != np.sign(np.diff(turns[1:-1]))[:-1]).all()


def test_an_encoder_that_errs_more_while_a_motor_runs() -> None:
    """A stroke between two rests, twice the noise in its middle: its acceleration is no noise there."""
    t = np.arange(1200) * 5e-4
    x = np.clip((t - 0.1) / 0.4, 0, 1)
    z = 150 * x**3 * (10 - 15 * x + 6 * x**2)
    a = 150 / 0.4**2 * (60 * x - 180 * x**2 + 120 * x**3)
    loud = (t > 0.15) & (t < 0.35)
    k = kinematics(t, z + np.where(loud, 0.05, 0.02) * np.random.default_rng(2).standard_normal(t.size))
    middle = (t > 0.17) & (t < 0.33)
    assert rms((k.a - a)[middle]) < 0.1 * np.abs(a).max()
    assert rms((k.a - a)[middle]) == pytest.approx(rms(k.sigma_a[middle]), rel=0.8)
    assert 0.02 < k.sigma_z < 0.05


@pytest.mark.parametrize("cycles", [2.0, 5.0])
def test_a_fast_end_of_a_record_is_no_noise(cycles: float) -> None:
    """A sweep that ends at a few samples a period: what is fast there goes on."""
    t = np.arange(3000) * 1e-3
    phase = 2 * np.pi * cycles * np.expm1(1.5 * t) / 1.5
    z = np.sin(phase)
    k = kinematics(t, noisy(z, 7, 1e-3))
    assert rms((k.z - z)[-300:]) < 3e-3


@pytest.mark.skipif(not SHARED.is_dir(), reason="no ../shared/data beside this repository")
@pytest.mark.parametrize(
    ("name", "turns", "speed"),
    [
        ("friction_damper_36lb", (14, 14), 84.0),
        ("mr_damper_0V", (25, 40), 76.0),
        ("silverbox", (1000, 1600), 870.0),
    ],
)
def test_measured_displacements(name: str, turns: tuple[int, int], speed: float) -> None:
    channels = (Channel("t", "s"), Channel("z", "mm")), (Channel("F", "N", measured_as=("F_m",)),)
    signature = Signature("modified_dahl", *channels, parameters={}, axis="t")
    r = load_case(read_case_file(SHARED / name / "case.toml"), signature).fit[0]
    k = kinematics(r.inputs["t"], r.inputs["z"])
    assert turns[0] <= k.reversals.size <= turns[1]
    assert np.abs(k.v).max() == pytest.approx(speed, rel=0.05)
    assert rms(k.z - r.inputs["z"]) <= 1.2 * k.sigma_z
    path = np.concatenate(([0], np.cumsum((k.v[1:] + k.v[:-1]) / 2 * np.diff(r.inputs["t"]))))
    assert rms(path - path.mean() - (k.z - k.z.mean())) < 0.01 * np.ptp(k.z)


@pytest.mark.parametrize("std", [1e-6, 1e-3])
@pytest.mark.parametrize("later", [np.geomspace(0.61, 8000, 475), np.arange(0.61, 100, 0.3)])
def test_a_step_that_is_sampled_densely_and_held_for_long(std: float, later: np.ndarray) -> None:
    """As in tests of relaxation and creep: the ramp takes a thousandth of the record, or less."""
    t = np.concatenate((np.arange(0, 0.6, 0.008), later))
    exact = np.clip(t / 0.4, 0, 1)
    k = kinematics(t, noisy(exact, 3, std if std > 1e-5 else 0.0), std)
    assert np.abs(k.z - exact).max() < 8 * std
    assert np.abs(k.v - 2.5)[(t > 0.1) & (t < 0.3)].max() < 250 * std
    assert np.abs(k.v[t > 1]).max() < 60 * std


@pytest.mark.parametrize("jitter", [0.02, 0.3])
def test_time_stamps_that_jitter_cost_no_velocity(jitter: float) -> None:
    rng, n = np.random.default_rng(1), 4000
    even = np.arange(n) / RATE * 4
    t = even + jitter / RATE * 4 * rng.uniform(-1, 1, n)
    k, clean = (kinematics(x, noisy(np.sin(12.6 * x), 2, 1e-3), 1e-3) for x in (t, even))
    worse = rms(k.v - 12.6 * np.cos(12.6 * t)) / rms(clean.v - 12.6 * np.cos(12.6 * even))
    assert worse < 1.3


@pytest.mark.parametrize(("length", "degree"), [(9, 8), (11, 5), (49, 5)])
def test_weights_of_a_window_are_savitzkys_and_golays(length: int, degree: int) -> None:
    for order, weights in enumerate(kernels(length, degree)):
        wanted = savgol_coeffs(length, degree, deriv=order, use="dot")
        assert np.allclose(weights, wanted, rtol=0, atol=1e-9 * np.abs(wanted).max())


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=60))
def test_the_nearest_path_that_never_falls(x: list[float]) -> None:
    assert np.allclose(rising(np.array(x)), isotonic_regression(x).x, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("seed", range(40))
def test_steps_and_rests_at_uneven_times_have_a_motion(seed: int) -> None:
    """Whatever noise is said of them: ways that no speed shows turn somewhere, too."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(20, 120))
    t = np.cumsum(np.exp(rng.normal(0, 1.0, n)) if seed % 2 else np.ones(n))
    levels = rng.normal(0, 1, 12)
    size = float(10 ** rng.uniform(-4, -0.5))
    z = levels[np.minimum(np.arange(n) // int(rng.integers(2, 9)), 11)] + size * rng.normal(size=n)
    found = kinematics(t, z, size * float(10 ** rng.uniform(-1, 1)))
    assert np.isfinite([found.z, found.v, found.a, found.z_turn]).all()
    assert np.all(np.diff(found.reversals) >= 0) and np.all((found.reversals > 0) & (found.reversals < n))


def test_a_fast_record_of_a_coarse_encoder_keeps_its_turns() -> None:
    """Sweeping over twenty steps from sample to sample, rounding is white noise."""
    step, dt = 0.004, 0.02
    t = np.arange(2000) * dt
    rng = np.random.default_rng(4)
    parts = [(rng.normal() / f**0.75, f, rng.uniform(0, 6)) for f in np.linspace(0.04, 1.6, 60)]

    def at(x: np.ndarray) -> np.ndarray:
        return 0.12 * np.sum([a * np.sin(2 * np.pi * f * x + p) for a, f, p in parts], axis=0)

    found = kinematics(t, np.round(at(t) / step) * step, step / 12**0.5)
    error = found.z - at(t)
    assert error.std() < 0.6 * step / 12**0.5
    assert found.sigma.mean() == pytest.approx(error.std(), rel=0.3)
    outward = []
    for n in found.reversals.tolist():
        true = at(np.linspace(t[n - 1], t[n], 50))
        up = at(t[n - 1 : n])[0] > at(t[n - 3 : n - 2])[0]
        outward.append((found.z_turn[n] - true.max()) if up else (true.min() - found.z_turn[n]))
    assert abs(np.median(outward)) < 0.1 * step
