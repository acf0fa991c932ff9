"""Outliers of records over time that come back wherever the motion comes to some place: no glitch does.

What a model misses for a few samples at a time, as at a stop, at a reversal or where a gap closes, stands as
far off its neighbours in time as a glitch does. In the order of the motion it has neighbours.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from modelgen.fit.series import Array, Series
from modelgen.language import Model
from modelgen.language.quantities import BACKWARD

PLACES = 20
"""Parts of the range of an input, each with as many samples."""
ODD = 1e-4
"""Probability below which so many glitches in one of them are no accident."""

Outliers = Callable[[Array], Array]


def without_recurring(model: Model, s: Series, white: Array, marks: Array, outliers: Outliers) -> Array:
    """`marks` (n,) bool of a record over time without those in places where marks recur that stand off
    nothing when whitened residuals `white` (channels, n) are sorted by the place, rising and falling strokes
    apart."""
    found = marks
    for u in _moved(model, s) if marks.any() else ():
        recur = _recurring(u, marks)
        if not (found & recur).any():
            continue
        rises = np.gradient(u) >= 0
        alone = np.zeros_like(marks)
        for stroke in (rises, ~rises):
            order = np.flatnonzero(stroke)[np.argsort(u[stroke], kind="stable")]
            alone[order] = outliers(white[:, order])
        found = found & (alone | ~recur)
    return found


def _moved(model: Model, s: Series) -> Iterator[Array]:
    """The inputs of a record that say where the motion is and how fast."""
    for i in model.inputs:
        looks_back = i.derived is not None and i.derived[0] in BACKWARD
        u = s.inputs.get(i.name)
        if u is not None and i.name != model.axis and not looks_back and np.ptp(u) > 0:
            yield u


def _recurring(u: Array, marks: Array) -> Array:
    """(n,) bool: samples in parts of the range of u that hold more of the marks than chance gives any."""
    from scipy.special import bdtrc

    part = np.argsort(np.argsort(u, kind="stable")) * PLACES // len(u)
    count = np.bincount(part[marks], minlength=PLACES)
    chance = bdtrc(count - 1.0, int(marks.sum()), 1.0 / PLACES)
    return np.asarray(((count > 1) & (chance < ODD))[part])
