"""Running amplitude and quadrature of a motion against what they are for sines."""

import numpy as np
import pytest

from modelgen.recordings.envelope import amplitude, quadrature, turning_points

t = np.linspace(0, 10, 4001)


@pytest.mark.parametrize("phase", [0.0, 0.7, np.pi / 2, 3.0])
def test_a_sine_has_its_amplitude_throughout_and_two_turns_a_period(phase: float) -> None:
    z = 0.4 * np.sin(2 * np.pi * t + phase) + 3.0
    assert np.allclose(amplitude(z), 0.4, rtol=1e-3)
    assert abs(len(turning_points(z)) - 2 - 20) <= 1


def test_jitter_makes_no_turns() -> None:
    z = np.sin(2 * np.pi * 0.5 * t) + 1e-3 * np.sin(2 * np.pi * 97 * t)
    assert abs(len(turning_points(z)) - 2 - 10) <= 1


def test_amplitude_follows_a_step() -> None:
    z = np.where(t < 5, 0.4, 0.8) * np.sin(2 * np.pi * t)
    a = amplitude(z)
    assert a[1000] == pytest.approx(0.4, rel=1e-2)
    assert a[3000] == pytest.approx(0.8, rel=1e-2)


def test_a_ramp_and_a_rest_have_half_their_range() -> None:
    assert np.all(amplitude(t) == 5.0)
    assert np.all(amplitude(np.zeros(50)) == 0.0)


@pytest.mark.parametrize("f", [0.3, 1.0, 7.0])
@pytest.mark.parametrize("phase", [0.0, 0.8, -np.pi / 2])
def test_quadrature_is_a_quarter_of_a_cycle_ahead_from_end_to_end(f: float, phase: float) -> None:
    angle = 2 * np.pi * f * t + phase
    assert np.allclose(quadrature(2.0 * np.cos(angle)), -2.0 * np.sin(angle), atol=0.1)


def test_quadrature_of_a_motion_that_gets_smaller() -> None:
    size = 3 - 2.5 * np.sin(np.pi * t / 20) ** 2
    found = np.hypot(quadrature(size * np.sin(2 * np.pi * t)), size * np.sin(2 * np.pi * t))
    assert np.allclose(found, size, atol=0.15)


def test_a_motion_that_begins_at_rest_was_at_rest_before() -> None:
    size = np.minimum(t / 0.8, 1.0) ** 2
    z = size * np.sin(2 * np.pi * t)
    found = np.hypot(quadrature(z), z)
    assert found[:40].max() < 0.2 and np.allclose(found[800:], 1.0, atol=0.05)


def test_quadrature_of_a_constant_is_zero_and_it_is_linear() -> None:
    z = np.random.default_rng(0).normal(size=500).cumsum()
    assert np.allclose(quadrature(np.full(100, 3.0)), 0)
    assert np.allclose(quadrature(2 * z + 1), 2 * quadrature(z))
