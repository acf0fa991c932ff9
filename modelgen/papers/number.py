"""A published number, what we get for it, and what is to be said of the two."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from modelgen.errors import InputError


class Verdict(Enum):
    """What became of a published number."""

    REPRODUCED = "reproduced"
    NOT_REPRODUCIBLE = "not reproducible"
    WRONG = "wrong in print"
    GIVEN = "given"


@dataclass(frozen=True)
class Published:
    """One number of a table, as printed, and how to compute it anew.

    printed: the digits of the paper, "4.3788e-10": half a unit of the last one is its rounding. within: an
    uncertainty that the paper states, if wider. ours: computes it, in `unit`; how: says by what.
    lacks: what the paper does not give, so that `ours`, where there is one, is computed on stand-ins and
    proves nothing. wrong: the evidence that a number which we do not meet is wrong in print. missed: what it
    is put down to when ours, computed from printed numbers alone, does not meet it. given: says why there is
    nothing to compute, as of a setting or of an instrument's reading.
    """

    row: str
    quantity: str
    printed: str
    unit: str
    how: str = ""
    ours: Callable[[], float] | None = None
    lacks: str = ""
    wrong: str = ""
    missed: str = "no reading of the paper was found that gives this number"
    given: str = ""
    within: float = 0.0

    def __post_init__(self) -> None:
        if self.ours is None and not (self.lacks or self.given):
            raise InputError(f"{self.row}, {self.quantity}: neither computed nor said why not")

    @property
    def value(self) -> float:
        """The printed number."""
        return float(self.printed)

    @property
    def rounding(self) -> float:
        """Half a unit of the last printed digit."""
        mantissa, _, exponent = self.printed.lower().partition("e")
        decimals = len(mantissa.partition(".")[2])
        return 0.5 * 10.0 ** (int(exponent or 0) - decimals)

    @property
    def tolerance(self) -> float:
        """How far ours may be from the printed number for it to count as reproduced."""
        return max(self.rounding, self.within) * (1 + 1e-9)


@dataclass(frozen=True)
class Result:
    """A published number with ours (NaN where there is none), the verdict and its reason."""

    number: Published
    ours: float
    verdict: Verdict
    why: str


def judge(number: Published) -> Result:
    """Compute one number and say what became of it.

    What the paper gives no means to compute is never called reproduced, however close a stand-in comes; a
    number that we meet is not wrong in print, whatever was said against it, nor is one for which our
    computation fails.
    """
    ours = math.nan if number.ours is None else float(number.ours())
    if number.given:
        return Result(number, ours, Verdict.GIVEN, number.given)
    if number.lacks:
        return Result(number, ours, Verdict.NOT_REPRODUCIBLE, number.lacks)
    if not math.isfinite(ours):
        return Result(number, ours, Verdict.NOT_REPRODUCIBLE, f"our computation gives {ours:g}, no number")
    gap = abs(ours - number.value)
    if gap <= number.tolerance:
        stated = number.within > number.rounding
        return Result(
            number, ours, Verdict.REPRODUCED, "within " + ("its stated uncertainty" if stated else "rounding")
        )
    if number.wrong:
        return Result(number, ours, Verdict.WRONG, number.wrong)
    return Result(number, ours, Verdict.NOT_REPRODUCIBLE, number.missed)
