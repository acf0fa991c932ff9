"""Score tests: what the base's own sensitivities leave of a column, without making it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelgen.diagnose.search.screen import Tangent


@given(seed=st.integers(0, 10_000), near=st.floats(1e-9, 1.0), size=st.floats(1e-6, 1e6))
def test_products_are_those_of_the_parts_that_are_left(seed: int, near: float, size: float) -> None:
    rng = np.random.default_rng(seed)
    n, p, m, k = 60, 4, 5, 2
    tangent = Tangent.of(rng.standard_normal(n), rng.standard_normal((n, p)))
    columns = rng.standard_normal((m, n, k))
    columns[2, :, 0] = tangent.q @ rng.standard_normal(p) + near * rng.standard_normal(
        n
    )  # all but the base's own
    columns *= size
    among, along, square = tangent.products(columns)
    rest = tangent.off(columns)
    scale = np.sqrt(square)[:, :, None] * np.sqrt(square)[:, None, :]
    assert np.allclose(among, np.swapaxes(rest, 1, 2) @ rest, rtol=1e-8, atol=1e-15 * scale.max())
    assert np.allclose(np.einsum("mkk->mk", among), np.sum(rest**2, axis=1), rtol=1e-8)
    assert np.allclose(along, tangent.r @ rest, rtol=1e-8, atol=1e-12 * size)
    assert np.allclose(square, np.sum(columns**2, axis=1))


def test_what_is_not_finite_spoils_no_other_column() -> None:
    rng = np.random.default_rng(0)
    tangent = Tangent.of(rng.standard_normal(30), rng.standard_normal((30, 3)))
    columns = rng.standard_normal((3, 30, 1))
    columns[1, 4, 0] = np.nan
    with np.errstate(all="ignore"):
        among, along, square = tangent.products(columns)
    assert np.isnan(square[1]).all() and np.isfinite(square[[0, 2]]).all()
    alone = tangent.products(columns[[0, 2]])
    assert along[[0, 2]] == pytest.approx(alone[1]) and among[[0, 2]] == pytest.approx(alone[0])
