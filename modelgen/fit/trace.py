"""One recording against a model, or against two: what a plot needs of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from modelgen.fit.series import Array, Series
from modelgen.fit.whitener import Whitener
from modelgen.language import Model


@dataclass(frozen=True, eq=False)
class Trace:
    """One recording against the model, for plots.

    x: (n,) samples of the axis. data, before, after: (n,) complex or real; the first channel where there are
    several. white_before, white_after: (channels, n) whitened residuals (unit noise). outliers: (n,) bool.
    units: of the inputs. channels, left: (channels, n) all data as real numbers, and the residual after.
    """

    name: str
    role: str
    axis: str
    axis_unit: str
    unit: str
    measure: str
    x: Array
    data: Array
    before: Array
    after: Array
    white_before: Array
    white_after: Array
    outliers: Array
    inputs: Mapping[str, Array] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    channels: Array = field(default_factory=lambda: np.zeros((0, 0)))
    left: Array = field(default_factory=lambda: np.zeros((0, 0)))


def make_trace(model: Model, s: Series, before: Array, after: Array, outliers: Array, w: Whitener) -> Trace:
    """From residuals (channels, n) before and after, which `w` whitens."""
    axis = model.inputs[0]

    def joined(x: Array) -> Array:
        return x[0] + 1j * x[1] if s.measure == "complex" else x[0]

    return Trace(
        s.name, s.role, axis.name, axis.unit, s.unit, s.measure, s.inputs[axis.name],
        joined(s.data), joined(s.data + before), joined(s.data + after), w.apply(before), w.apply(after),
        outliers, _stroke_first(model, s.inputs), {i.name: i.unit for i in model.inputs}, s.data, after,
    )  # fmt: skip


def _stroke_first(model: Model, inputs: Mapping[str, Array]) -> dict[str, Array]:
    """The inputs, a displacement at a port before others: a force is drawn over it, not over what drives."""
    strokes = {str(x) for p in model.ports for n, x in p.variables if n == "z"}
    return {n: inputs[n] for n in (*(n for n in inputs if n in strokes), *inputs)}
