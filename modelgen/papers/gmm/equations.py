"""Numbers that stand in equations: the series of the eddy-current factor (5), and constants."""

from __future__ import annotations

from fractions import Fraction
from functools import cache, partial
from math import factorial

from modelgen.papers.number import Published
from modelgen.papers.paper import Table

TYPO = "the exact coefficient is 473/4423680: two digits have changed places"


@cache
def coefficients(order: int = 5) -> tuple[Fraction, ...]:
    """c_n of χ = Σ c_n (−jp)^n, p = f/f_c: 2J_1(x)/(xJ_0(x)) with x² = −jp, by division of the power series.

    J_0 = Σ (−x²/4)^k/k!², 2J_1/x = Σ (−x²/4)^k/(k!(k+1)!).
    """
    top = [Fraction((-1) ** k, 4**k * factorial(k) * factorial(k + 1)) for k in range(order + 1)]
    base = [Fraction((-1) ** k, 4**k * factorial(k) ** 2) for k in range(order + 1)]
    found: list[Fraction] = []
    for n in range(order + 1):
        found.append(top[n] - sum((base[k] * found[n - k] for k in range(1, n + 1)), Fraction(0)))
    return tuple(found)


def _denominator(n: int, numerator: int) -> float:
    return float(abs(numerator / coefficients()[n]))


def _of(n: int, numerator: int, denominator: str, row: str, wrong: str = "") -> Published:
    return Published(
        row, f"denominator under {numerator} (f/f_c)^{n}", denominator, "1",
        "series of 2J_1(x)/(xJ_0(x)), x² = −jf/f_c",
        partial(_denominator, n, numerator), wrong=wrong,
    )  # fmt: skip


SERIES = Table(
    "Eq. 5",
    "The eddy-current factor's series, χ_r and χ_i. Its sign in (6) is printed wrong, too: with e^(+jωt) "
    "it is χ_r − jχ_i, or eddy currents generate power",
    (
        _of(2, 1, "48", "χ_r"),
        _of(4, 19, "30720", "χ_r"),
        _of(1, 1, "8", "χ_i"),
        _of(3, 11, "3072", "χ_i"),
        _of(5, 473, "4343680", "χ_i", TYPO),
        Published("constants", "f_c", "30", "kHz", given="of the slotted rod, from the paper's reference 28"),
        Published("constants", "k_M²", "0.9205", "1", given="flux leakage, from the paper's reference 31"),
    ),
)
