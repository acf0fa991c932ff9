"""Starts in the recordings' own units: a sample of microns has other numbers than one of metres."""

from __future__ import annotations

from functools import cache

import numpy as np

from modelgen.fit.experiment import Experiment
from modelgen.fit.series import Array
from modelgen.units import factor, parse, registry

DIMENSIONS = ("[mass]", "[length]", "[time]", "[current]")


@cache
def _dimensions(unit: str) -> tuple[float, Array]:
    """A unit's size in base units of the SI, and its powers of DIMENSIONS."""
    base = registry().Quantity(1.0, parse(unit)).to_base_units()
    powers = dict(base.dimensionality)
    return factor(unit, str(base.units)), np.array([powers.get(d, 0) for d in DIMENSIONS], dtype=float)


def in_own_units(e: Experiment, default: Array) -> Array:
    """θ (p,) of a time model with every parameter 1 in units made of the recordings' stroke, time and output.

    Those without a dimension, and all of a model without a displacement, stay at `default`.
    """
    inputs = {i.name: i for i in e.model.inputs}
    rate = next((i for i in e.model.inputs if i.derived and i.derived[0] == "rate"), None)
    if rate is None or rate.derived is None:
        return default
    moved = inputs[rate.derived[1]]
    stroke = max(float(np.ptp(s.inputs[moved.name])) / 2 for s in e.series)
    speed = max(float(np.quantile(np.abs(s.inputs[rate.name]), 0.995)) for s in e.series)
    output = max(float(np.std(s.data)) for s in e.series)
    sizes = [(stroke, moved.unit), (speed, rate.unit), (output, e.series[0].unit)]
    if min(size for size, _ in sizes) <= 0:
        return default
    known = [_dimensions(unit) for _, unit in sizes]
    logs = np.log([size * scale for (size, _), (scale, _) in zip(sizes, known, strict=True)])
    basis = np.array([powers for _, powers in known]).T
    theta = default.copy()
    for k, p in enumerate(e.layout.parameters):
        scale, powers = _dimensions(p.unit)
        made = np.linalg.lstsq(basis, powers, rcond=None)[0]
        if np.any(powers) and np.allclose(basis @ made, powers):
            sign = -1.0 if p.bounds[1] <= 0 else 1.0
            theta[k] = np.clip(sign * float(np.exp(made @ logs)) / scale, *p.bounds)
    return theta
