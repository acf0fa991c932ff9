"""Hypotheses between which a recording shall decide."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import Setting
from modelgen.fit.series import Array


@dataclass(frozen=True, eq=False)
class Rivals:
    """Hypotheses that the data do not exclude, all under one judge.

    near: others that come next, and might come back; they are not taken for the truth. scale: χ² per sample
    of the best; k: the recording that a planned one is like. together: what leaves the same of every sample
    need not be told apart.
    """

    setting: Setting
    judge: Judge
    fits: tuple[Fit, ...]
    near: tuple[Fit, ...]
    k: int
    scale: float
    together: bool = False

    @cached_property
    def _normals(self) -> dict[int, Array]:
        return {}

    def normal(self, fit: Fit) -> Array:
        """Normal matrix of the recordings that are there."""
        if id(fit) not in self._normals:
            e = fit.hypothesis.experiment
            self._normals[id(fit)] = e.normal(fit.theta, self.judge.whiteners)[2]
        return self._normals[id(fit)]

    def others(self, i: int) -> list[Fit]:
        """Those that would have to be excluded if the one at `i` is true."""
        return self._others[i]

    @cached_property
    def _others(self) -> list[list[Fit]]:
        every = (*self.fits, *self.near)
        return [
            [g for g in every if set(g.ids) != set(f.ids) and not (self.together and same(f, g))]
            for f in self.fits
        ]


SAME = 1e-3
"""Standard deviations of the noise by which laws that are one under two names differ by rounding."""


def same(a: Fit, b: Fit) -> bool:
    """Whether two hypotheses leave the same of every sample."""
    return all(np.allclose(x, y, atol=SAME) for x, y in zip(a.white, b.white, strict=True))
