"""What is printed says no more than is known: tiny deviations, computations that fail."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelgen.papers.number import Published, Verdict, judge
from modelgen.report.words import measured


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (100.0, 1e-14, "100 ± 1.0·10⁻¹⁴"),
        (-0.1 - 0.2, 1e-17, "−0.3 ± 1.0·10⁻¹⁷"),
        (1.2e-9, 3e-25, "1.2·10⁻⁹ ± 3.0·10⁻²⁵"),
        (0.001, 2e-14, "0.001000000000000 ± 0.000000000000020"),
        (0.3834, 0.0012, "0.3834 ± 0.0012"),
    ],
)
def test_a_tiny_deviation_is_no_zero(value: float, std: float, text: str) -> None:
    assert measured(value, std) == text


@given(st.floats(-12, 12), st.floats(-25, 0))
def test_no_deviation_prints_as_certain(size: float, relative: float) -> None:
    std = re.search("± ([0-9.]+)", measured(10.0**size, 10.0 ** (size + relative)))
    assert std and float(std[1]) > 0


@pytest.mark.parametrize("ours", [float("nan"), float("inf"), -float("inf")])
def test_a_computation_that_fails_proves_no_misprint(ours: float) -> None:
    number = Published("row", "quantity", "1.00", "N", "formula", lambda: ours, wrong="it is twice that")
    result = judge(number)
    assert result.verdict is Verdict.NOT_REPRODUCIBLE
    assert result.why == f"our computation gives {ours:g}, no number"
