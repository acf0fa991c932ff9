"""The banded factor of autoregressive noise with coloured motion errors on top, against dense matrices."""

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from modelgen.fit.colour import factor, smeared, through


@pytest.mark.parametrize(("a", "variance"), [((1.0, -0.9, 0.1), 0.3), ((1.0, -0.5), 1.0)])
def test_the_factor_is_that_of_the_dense_covariance(a: tuple[float, ...], variance: float) -> None:
    rng = np.random.default_rng(0)
    n, order = 80, len(a) - 1
    rows = smeared(rng.exponential(1, n), rng.integers(4, 7, n))
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
