"""The banded factor of autoregressive noise with coloured motion errors on top, against dense matrices."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from modelgen.fit.banded import factor, smears, smoothing, through
from modelgen.fit.colour import _banded, autoregression, coloured, filtered, noise_like, recursive
from modelgen.fit.whitener import Smear, Whitener


@pytest.mark.parametrize(("a", "variance"), [((1.0, -0.9, 0.1), 0.3), ((1.0, -0.5), 1.0)])
def test_the_factor_is_that_of_the_dense_covariance(a: tuple[float, ...], variance: float) -> None:
    rng = np.random.default_rng(0)
    n, order = 80, len(a) - 1
    rows = smears(Smear(rng.integers(4, 7, n), rng.standard_normal((3, n))), rng.exponential(1, n))
    reach = rows.shape[1] // 2
    smear = np.zeros((n, n + 2 * reach))
    for i in range(n):
        smear[i, i : i + 2 * reach + 1] = rows[i]
    response = lfilter([1], a, np.eye(1, 5000)[0])
    lags = np.array([response[: 5000 - k] @ response[k:] for k in range(n)])
    covariance = variance * toeplitz(lags) + smear @ smear.T
    filtered = toeplitz(np.r_[a, np.zeros(n - order - 1)], np.r_[1.0, np.zeros(n - 1)])
    wanted = filtered @ covariance @ filtered.T
    band = factor(np.array(a), variance, np.zeros(n), through(np.array(a), rows))
    lower = np.zeros((n, n))
    for k in range(len(band)):
        lower += np.diag(band[k, : n - k], -k)
    assert np.allclose(lower @ lower.T, wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())


def test_what_smoothing_makes_of_errors_is_what_its_rows_say() -> None:
    rng = np.random.default_rng(2)
    n = 120
    window, e = rng.integers(4, 15, n), rng.standard_normal(n)
    found, reach = smoothing(window, e), 14
    around = np.pad(e, reach)
    for order in range(3):
        rows = smears(Smear(window, np.eye(3)[order][:, None] * np.ones(n)), np.ones(n))
        assert np.allclose(np.linalg.norm(rows, axis=1), 1)
        assert np.allclose(found[order], [rows[i] @ around[i : i + 2 * reach + 1] for i in range(n)])


@pytest.mark.parametrize("power", [0.25, 0.5, 0.75])
def test_noise_that_falls_with_a_power_of_the_frequency_is_one_number(power: float) -> None:
    rng = np.random.default_rng(1)
    n = 2000
    spectrum = np.fft.rfft(rng.standard_normal(8 * n))
    spectrum[1:] /= np.arange(1.0, len(spectrum)) ** power
    spectrum[0] = 0
    x = np.fft.irfft(spectrum)[:n]
    x = (x - x.mean()) / x.std()
    plain = Whitener(np.ones((1, n)))
    (found,) = coloured([plain], [x[None]], 12, slow=True)
    assert found.slow and found.order == 1
    assert found.ar is not None and -found.ar[1] == pytest.approx(power)
    white = found.colour(x[None])[0]
    spectrum = np.abs(np.fft.rfft(white)) ** 2
    low, high = spectrum[2:40].mean(), spectrum[-300:].mean()
    assert 0.5 < low / high < 2.0


def test_white_noise_and_a_short_memory_are_not_slow() -> None:
    rng = np.random.default_rng(2)
    e = rng.standard_normal(2000)
    for x, order in ((e, 0), (lfilter([1], [1, -0.6], e), 1)):
        (found,) = coloured([Whitener(np.ones((1, 2000)))], [x[None]], 12, slow=True)
        assert not found.slow and found.order == order


def test_short_sweeps_tell_their_colour_together() -> None:
    rng = np.random.default_rng(5)
    for rho, alike in ((0.95, True), (0.0, False)):
        rough = lfilter([1], [1, -rho], rng.standard_normal((3, 2, 430)))[..., 400:]
        plain = [Whitener(np.ones((2, 30)))] * 3
        found = coloured(plain, list(rough), 3)
        filters = [None if w.ar is None else tuple(w.ar) for w in found]
        assert len(set(filters)) == 1
        assert (filters[0] is not None) == alike
        if alike:
            assert 0.85 < -filters[0][1] < 1.0


def test_fresh_noise_is_as_large_and_as_coloured_as_what_it_is_made_after() -> None:
    """… beside next to no other noise: the second half of the record, of half the weight, tells nothing."""
    rng = np.random.default_rng(2)
    n, a = 4000, np.array([1.0, -0.9])
    share = np.where(np.arange(n) < n // 2, 1.0, 0.5)
    noise = lfilter([1], a, 2.0 * rng.standard_normal(n))[None, :]
    other = 8 * rng.standard_normal(n) * (share < 1)
    w = Whitener(share[None, :], ar=a, share=share)
    fresh = noise_like(w, share * (noise + other), rng)
    assert fresh.shape == (1, n)
    assert np.std(fresh) == pytest.approx(2 / np.sqrt(1 - 0.81), rel=0.15)
    assert np.allclose(autoregression(fresh, 1), a, atol=0.03)


@pytest.mark.parametrize("a", [(1.0,), (1.0, -0.999), (1.0, -1.2, 0.5)])
def test_what_a_filter_takes_off_its_inverse_brings_back(a: tuple[float, ...]) -> None:
    x = np.random.default_rng(3).standard_normal((2, 500))
    y = recursive(np.array(a), x)
    assert np.allclose(y, lfilter([1.0], a, x, axis=1), rtol=0, atol=1e-12)
    assert np.allclose(filtered(np.array(a), y), x, rtol=0, atol=1e-11)


def test_errors_of_a_smoothed_path_are_whitened_over_their_whole_length() -> None:
    """Smoothing reaches over hundreds of samples: what it leaves is slow, and must not pass for physics."""
    rng = np.random.default_rng(7)
    n, half = 6000, 120
    smear = Smear(np.full(n, half), np.outer([0.5, 1.0, 0.3], np.ones(n)))
    rows, errors = smears(smear, np.ones(n)), np.pad(rng.standard_normal(n), half)
    e = rng.standard_normal(n) + np.sum(
        rows * np.lib.stride_tricks.sliding_window_view(errors, 2 * half + 1), axis=1
    )
    level = np.sqrt(1 + np.sum(smear.by**2, axis=0))
    allowed = Whitener(np.ones((1, n)) / level, share=1 / level, smear=smear)
    (found,) = coloured([allowed], [e[None] / level], 0)
    power = np.abs(np.fft.rfft(found.colour(e[None] / level)[0])) ** 2
    slow = n // half
    assert found.band is not None and np.all(found.reach[: n - 2 * half] == 2 * half)
    assert 0.5 < power[1:slow].mean() / power[slow:].mean() < 2.0


@pytest.mark.parametrize("order", [3, 6, 9, 12])
def test_what_repeats_itself_to_the_last_digit_has_no_colour(order: int) -> None:
    """Roots of its filter are so near to 1, and to each other, that no process is stationary with them."""
    t = np.arange(400) / 100
    x = np.where((t >= 1) & (t < 3), 0.0, 30 * np.sin(2 * np.pi * t) + t**2)
    (found,) = coloured([Whitener(np.ones((1, 400)))], [x[None]], order)
    assert np.isfinite(found.colour(x[None])).all()
    a = np.poly(np.full(order, 0.99875))
    w = replace(Whitener(np.ones((1, 400))), share=np.ones(400))
    assert np.isfinite(
        _banded(w, x[None], a, np.ones(400), np.ones(400, dtype=bool), None).colour(x[None])
    ).all()
