"""Noise of a sweep of one channel is no louder than that of two."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen.diagnose.gate.oddities import LOUD, _over_quiet, mains


@pytest.mark.parametrize("channels", [1, 2])
def test_noise_alone_is_not_loud(channels: int) -> None:
    e = np.random.default_rng(0).standard_normal((channels, 240_000))
    assert np.count_nonzero(_over_quiet(e) > LOUD) < 5
    np.testing.assert_allclose(_over_quiet(e), np.sum(e**2, axis=0), rtol=0.02)


def test_mains_below_five_standard_deviations_are_none_in_one_channel() -> None:
    f, rng = np.geomspace(20.0, 2000.0, 300), np.random.default_rng(1)
    for size, heard in ((4.0, False), (9.0, True)):
        white = [rng.standard_normal((1, f.size)) for _ in range(2)]
        for e in white:
            for n in (1, 3, 5):
                e[0, np.argmin(np.abs(f - 50.0 * n))] = size
        assert (mains([f, f], white, "spring")[0] is not None) is heard
