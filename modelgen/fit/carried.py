"""What an estimation in stages knows after each of them: errors of early stages reach the later ones, and so
does what the data leave open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from modelgen.fit.experiment import Experiment
from modelgen.fit.problem import Matrix, Vector
from modelgen.fit.uncertainty import ROUNDING, Judged, Product, column_norms, judge, split


@dataclass(frozen=True, eq=False)
class Known:
    """Values so far (NaN: none yet), and the error of each, linear in independent unit sources: (names,
    sources).

    The measured constants are the first sources; each stage adds those of its own data, rotated into as many
    as it has parameters. open: (names, q), directions in which the data let the values move. scale: (names,)
    norms of the columns of J in the stage that last sought each, by which shares in a direction compare.
    """

    names: tuple[str, ...]
    values: Mapping[str, float]
    error: Matrix
    open: Matrix
    scale: Vector

    @classmethod
    def nothing(cls, names: Sequence[str]) -> Known:
        empty = np.zeros((len(names), 0))
        return cls(tuple(names), dict.fromkeys(names, np.nan), empty, empty, np.ones(len(names)))

    def with_sources(self, spread: Mapping[str, float]) -> Known:
        """The same before any stage, with measured constants of these standard deviations."""
        more = Known.nothing((*self.names, *spread))
        error = np.zeros((len(more.names), len(spread)))
        error[len(self.names) :] = np.diag(list(spread.values()))
        return replace(more, values=self.values, error=error)

    def judged(self, names: Sequence[str], span: Vector, powers: Product) -> Judged:
        """Covariance of the parameters `names` and what is determined of them, as `judge` says it."""
        at = [self.names.index(n) for n in names]
        directions, sizes, _ = np.linalg.svd(self.open[at] * self.scale[at, None], full_matrices=False)
        covariance = (self.error @ self.error.T)[np.ix_(at, at)]
        # a direction is gone once a later stage has determined all that it moved
        return judge(covariance, directions[:, sizes > ROUNDING], self.scale[at], span, tuple(names), powers)


def after(
    known: Known, ex: Experiment, whole: Vector, sought: Sequence[str], assumed: Mapping[str, float]
) -> Known:
    """Carry errors through a stage: δθ = −J⁺ (e + J_held δheld), e of the size of the residual.

    What moves along an open direction takes the parameters with it in the same way.
    Raises InputError, naming the parameter, where a derivative is not finite.
    """
    r, J = ex.linearised(whole)
    place = [ex.layout.names.index(n) for n in sought]
    scale = column_norms(sought, J[:, place])
    unit = J[:, place] / scale
    blind, inverse = split(unit)
    back = inverse @ unit.T
    spare = r.size - len(place) + blind.shape[1]
    level = float(np.sqrt(r @ r / spare)) if spare > 0 else np.nan
    U, s, _ = np.linalg.svd(back, full_matrices=False)
    others = [k for k, n in enumerate(ex.layout.names) if n not in sought and n not in assumed]
    rows = [known.names.index(ex.layout.names[k]) for k in others]
    mine = [known.names.index(n) for n in sought]
    moved = -back @ J[:, others]

    def through(before: Matrix, own: Matrix) -> Matrix:
        found = np.hstack([before, np.zeros((len(known.names), own.shape[1]))])
        found[mine] = np.hstack([moved @ before[rows], own]) / scale[:, None]
        return found

    scales = known.scale.copy()
    scales[mine] = scale
    return Known(
        known.names,
        dict(known.values) | dict(zip(sought, whole[place].tolist(), strict=True)),
        through(known.error, level * U * s),  # as many unit sources as parameters have the covariance of J⁺e
        through(known.open, blind),
        scales,
    )
