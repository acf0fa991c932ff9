"""What a search works on, and what it comes back with."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import log
from typing import TypeVar

from modelgen.diagnose.hypotheses.addition import Addition
from modelgen.diagnose.hypotheses.refit import Fit, Judge, misfit
from modelgen.fit.pool import share
from modelgen.fit.series import Array, Series
from modelgen.language import Model
from modelgen.recordings import Case

ALARM = 10.0
"""ΔBIC that an effect must gain to be claimed: with thirty candidates a false alarm in less than one of a
hundred."""
TEMPER = 1.3
"""BIC differences are divided by this before they become odds: laws are never exactly those of the
catalogue."""
CLOSE = 2 * TEMPER * log(20)
"""ΔBIC within which the data do not exclude a hypothesis: odds of one to twenty."""
CHEAP = 3000
"""Samples up to which any fit is cheap: what is promising by its score need not be chosen so carefully."""
COLOUR_TIME, COLOUR_SWEEP = 12, 3
"""Greatest order of a noise's colour along time, and along a sweep's frequencies."""

Part = TypeVar("Part")
Result = TypeVar("Result")
Progress = Callable[[float, str], None] | None


@dataclass(frozen=True, eq=False)
class Setting:
    """What a search works on.

    others: θ of further optima of the base, which may be nearer to the truth. averaged: whether samples are
    averages of blocks, in which a noise that is stated of each counts as independent. base: the base as it
    was fitted to these series at first, as if all noise were independent. before: what a search had found
    that took these recordings otherwise: with outliers, or with a past of the sample.
    """

    model: Model
    case: Case
    series: tuple[Series, ...]
    additions: tuple[Addition, ...]
    others: tuple[Array, ...] = ()
    averaged: bool = False
    base: Fit | None = None
    before: Fit | None = None
    beam: int = 3
    refits: int = 12
    pairs: int = 5

    @property
    def colour(self) -> int:
        return COLOUR_TIME if self.model.is_time_model else COLOUR_SWEEP

    @property
    def cheap(self) -> bool:
        """Whether any fit is."""
        return sum(x.n for x in self.series) <= CHEAP

    def each(self, task: Callable[[Part], Result], parts: Sequence[Part]) -> list[Result]:
        """`task` of each part, in order, on all cores."""
        return share(task, parts)


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a search found, all under the judge at its end: the base, the chosen fit, and all that were
    tried."""

    judge: Judge
    base: Fit
    best: Fit
    tried: tuple[Fit, ...]
    blind: tuple[Addition, ...]


def nearest(s: Setting, base: Fit) -> Fit:
    """The base as it comes nearest to the recordings as they are: by a colour that is its own misfit's, a fit
    may be led far away."""
    return base if s.base is None or misfit(base) <= misfit(s.base) else s.base
