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
    """θ (p,) with every parameter 1 in units made of the recordings' own: stroke (or what drives), time and
    output.

    Those without a dimension, and all of a model of sweeps that knows no displacement, stay at `default`.
    """
    sizes = _over_time(e) if e.model.is_time_model else _of_cycles(e)
    if not sizes or min(size for size, _ in sizes) <= 0:
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


def _over_time(e: Experiment) -> list[tuple[float, str]]:
    """Stroke, speed and spread of the output, each with its unit; without a displacement those of what drives
    it, of the output and of its time."""
    inputs = {i.name: i for i in e.model.inputs}
    rate = next((i for i in e.model.inputs if i.derived and i.derived[0] == "rate"), None)
    if rate is None or rate.derived is None:
        return _driven(e)
    moved = inputs[rate.derived[1]]
    stroke = max(float(np.ptp(s.inputs[moved.name])) / 2 for s in e.series)
    speed = max(float(np.quantile(np.abs(s.inputs[rate.name]), 0.995)) for s in e.series)
    output = max(float(np.std(s.data)) for s in e.series)
    return [(stroke, moved.unit), (speed, rate.unit), (output, e.series[0].unit)]


def _driven(e: Experiment) -> list[tuple[float, str]]:
    """Spread of each recorded input, of the output, and the time in which that changes by its spread."""
    axis = next(i for i in e.model.inputs if i.name == e.model.axis)
    recorded = [i for i in e.model.inputs if i.derived is None and i is not axis]
    inputs = [(max(float(np.std(s.inputs[i.name])) for s in e.series), i.unit) for i in recorded]
    output = max(float(np.std(s.data[0])) for s in e.series)
    rate = max(float(np.std(np.diff(s.data[0]) / np.diff(s.inputs[axis.name]))) for s in e.series)
    return [*inputs, (output, e.series[0].unit), (output / rate if rate else 0.0, axis.unit)]


def _of_cycles(e: Experiment) -> list[tuple[float, str]]:
    """Greatest amplitude, greatest frequency and typical output of sweeps, each with its unit; none where a
    port knows no amplitude."""
    names = {str(x) for p in e.model.ports for n, x in p.variables if n == "amplitude"}
    known = next((p for p in e.model.scalar_parameters if p.name in names), None)
    values = [] if known is None else [{**e.constants, **s.constants}.get(known.name) for s in e.series]
    told = [abs(v) for v in values if v is not None]
    if known is None or not told:
        return []
    axis = next(i for i in e.model.inputs if i.name == e.model.axis)
    top = 2 * np.pi * max(float(np.max(s.inputs[axis.name])) for s in e.series)
    output = max(float(np.median(np.abs(s.data[0]))) for s in e.series)
    return [(max(told), known.unit), (top, axis.unit), (output, e.series[0].unit)]
