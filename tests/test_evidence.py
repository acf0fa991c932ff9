"""Evidence under a level of the noise that nobody knows, beside errors of a motion whose size is known."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen.diagnose.hypotheses.evidence import Level, deviance
from modelgen.fit.scatter import local_scatter

RNG = np.random.default_rng(5)


def test_a_level_is_profiled() -> None:
    e = 3 * RNG.standard_normal((1, 400))
    assert deviance([e], [Level(0.0)]) == pytest.approx(400 * np.log(np.mean(e**2)))
    assert deviance([e], [Level(0.0, np.ones(400))]) == pytest.approx(400 * np.log(np.mean(e**2)))
    assert deviance([e / 9], [Level(0.0, np.ones(400))]) == pytest.approx(deviance([e / 9], [Level(0.0)]))


def test_errors_of_a_motion_that_are_allowed_for_too_widely_are_no_level() -> None:
    """Nine samples of ten lie far within what is allowed for them: a gain of ten squares remains one."""
    e = np.where(np.arange(1000) < 100, 1.0, 0.05)[None]
    own = np.where(np.arange(1000) < 100, 1.0, 0.01)
    better = e.copy()
    better[0, :10] = 0.0
    better[0, :10] += 1e-9
    gain = deviance([e], [Level(1.0, own)]) - deviance([better], [Level(1.0, own)])
    assert 9.0 < gain < 12.0
    assert deviance([e], [Level(1.0)]) - deviance([better], [Level(1.0)]) > 50.0


def test_errors_of_a_motion_that_are_underestimated_are_a_level() -> None:
    e = 4 * RNG.standard_normal((1, 1000))
    own = np.full(1000, 0.1)
    assert deviance([e], [Level(1.0, own)]) == pytest.approx(deviance([e], [Level(1.0)]))


def test_a_scatter_is_told_where_other_errors_are_small() -> None:
    """Corners in two of three samples would be taken for noise."""
    n = np.arange(3000)
    other = np.where(n // 20 % 3 == 0, 0.0, 20.0)
    x = RNG.standard_normal(3000) + other * RNG.standard_normal(3000)
    assert local_scatter(x, beside=other) == pytest.approx(1.0, rel=0.1)
    assert local_scatter(x) > 5
