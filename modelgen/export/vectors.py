"""Test vectors: what a unit must give, by 40-digit arithmetic, and how far rounding may take it from that."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import mpmath as mp
import numpy as np

from modelgen.errors import InputError
from modelgen.export.exact import DIGITS, FAILURES, run
from modelgen.export.floats import rounder
from modelgen.export.unit import Unit
from modelgen.export.values import Range, Trial, trials

EPSILON = {"double": 2.0**-52, "float": 2.0**-23}
ALLOWANCE = 64.0
"""What a test lets pass, in units of what one rounding of every operand does to the result."""


@dataclass(frozen=True)
class Vector:
    """One sample of a trial: inputs, outputs wanted, the size each is judged by, the error allowed.

    `jacobian` (rows × columns × (value, size, error allowed)) is given for the first trial alone.
    """

    trial: int
    first: bool
    inputs: tuple[float, ...]
    wanted: tuple[float, ...]
    scale: tuple[float, ...]
    allowed: tuple[float, ...]
    jacobian: tuple[tuple[tuple[float, ...], ...], ...] = ()


@dataclass(frozen=True)
class Sensed:
    """Vectors of a trial, and how much larger than its size a change of an output by its operands is."""

    vectors: tuple[Vector, ...]
    ratio: np.ndarray


def make_vectors(
    unit: Unit, real: str, ranges: Mapping[str, Range]
) -> tuple[tuple[Trial, ...], tuple[Vector, ...]]:
    """Trials and their vectors. Inputs are numbers of the type `real`, so that no error is theirs."""
    tried = _usable(unit, trials(unit.model, dict(unit.fixed), ranges, rounder(real), unit.steps))
    found: list[Sensed] = []
    with mp.workdps(DIGITS):
        for k, trial in enumerate(tried):
            found.append(_of_trial(unit, k, trial, EPSILON[real], found[0] if found else None))
    return tried, tuple(v for s in found for v in s.vectors)


def _usable(unit: Unit, tried: Sequence[Trial]) -> tuple[Trial, ...]:
    """The samples at which all trials have real, finite outputs; a model with memory needs them all."""
    count = len(tried[0].samples)
    batches = [range(count)] if unit.steps else [range(i, i + 1) for i in range(count)]
    with mp.workdps(DIGITS):
        good = [i for batch in batches if all(_has_values(unit, t, batch) for t in tried) for i in batch]
    if not good:
        where = ", ".join(f"{i.name} [{i.unit}]" for i in unit.model.inputs if not i.derived)
        hint = f"; give --range for {where}" if where else ""
        raise InputError(f"model '{unit.model.id}' has no finite value where it is tested{hint}")
    return tuple(replace(t, samples=tuple(t.samples[i] for i in good)) for t in tried)


def _has_values(unit: Unit, trial: Trial, at: range) -> bool:
    try:
        values = exact_outputs(unit, trial.parameters, [trial.samples[i] for i in at], real=True)
        return all(mp.isfinite(x) for x in values.ravel())
    except FAILURES:
        return False


def _floats(values: Any) -> tuple[float, ...]:
    return tuple(float(x) for x in values)


def _of_trial(unit: Unit, k: int, trial: Trial, epsilon: float, first: Sensed | None) -> Sensed:
    """A trial's vectors. Derivatives are taken in the first trial; later ones have its relative condition."""
    wanted = exact_outputs(unit, trial.parameters, trial.samples)
    scale = _scales(unit, wanted)
    if first is None:
        names = dict.fromkeys([*(s.name for s in unit.parameters), *unit.columns])
        slopes = {n: _slope(unit, trial, n, wanted) for n in names}
        moved = [np.abs(d * (trial.parameters[n] or 1.0)) for n, d in slopes.items()]
        condition = sum(moved) + _input_slopes(unit, trial, wanted)
        if unit.steps:
            condition = np.broadcast_to(np.max(condition, axis=0), wanted.shape)
        ratio = np.where(scale == 0, 1, (condition + scale) / np.where(scale == 0, 1, scale))
    else:
        slopes, ratio = {}, 2 * first.ratio
    allowed = ALLOWANCE * epsilon * ratio * scale
    jacobian = np.zeros((len(trial.samples), 0, 0, 3))
    if slopes and unit.columns:
        jacobian = _jacobian(unit, trial, slopes, scale, allowed)
    vectors = tuple(
        Vector(
            k, i == 0 or not unit.steps, unit_inputs(unit, trial.samples, i),
            _floats(wanted[i]), _floats(scale[i]), _floats(allowed[i]),
            tuple(tuple(_floats(e) for e in row) for row in jacobian[i]),
        )
        for i in range(len(trial.samples))
    )  # fmt: skip
    return Sensed(vectors, ratio)


def _jacobian(
    unit: Unit, trial: Trial, slopes: Mapping[str, np.ndarray], size: np.ndarray, allowed: np.ndarray
) -> np.ndarray:
    """(samples, rows, columns, 3): derivative, size to judge by (output/parameter/1000 or more), limit."""
    names = [s.name for s in unit.outputs]
    rows = [names.index(r) for r in unit.rows]
    value = np.stack([slopes[c][:, rows] for c in unit.columns], axis=-1)
    sizes = np.array([abs(trial.parameters[c]) or 1.0 for c in unit.columns])
    whole = np.max(size[:, rows], axis=0)[:, None] / sizes
    peak = np.broadcast_to(np.maximum(np.max(np.abs(value), axis=0), whole / 1000), value.shape)
    value = np.where(np.abs(value) < mp.mpf(10) ** -20 * whole, mp.mpf(0), value)
    limit = 8 * allowed[:, rows][:, :, None] / sizes
    return np.stack([value, peak, np.broadcast_to(limit, value.shape)], axis=-1)


def exact_outputs(
    unit: Unit, parameters: Mapping[str, Any], samples: Sequence[Mapping[str, Any]], real: bool = False
) -> np.ndarray:
    """Exact outputs, an array (samples, outputs) of mpmath numbers.

    Raises ValueError where `real` is asked for and an output that should be real is not.
    """
    batches = [samples] if unit.steps else [[s] for s in samples]
    rows = []
    for batch in batches:
        for env in run(unit.model, batch, **parameters):
            row: list[Any] = []
            for o in unit.model.outputs:
                pair = unit.program.step.equations[o.name]
                z = env[o.name]
                if real and pair[1] is None and mp.im(z) != 0:
                    raise ValueError(o.name)
                row += [mp.re(z)] if pair[1] is None else [mp.re(z), mp.im(z)]
            rows.append(row)
    return np.array(rows, dtype=object)


def _slope(unit: Unit, trial: Trial, name: str, base: np.ndarray) -> np.ndarray:
    """d(outputs)/d(parameter): a difference in 40 digits, some 18 of them right."""
    value = mp.mpf(trial.parameters[name])
    h = (abs(value) or mp.mpf(1)) * mp.mpf(10) ** -19
    return (exact_outputs(unit, {**trial.parameters, name: value + h}, trial.samples) - base) / h


def _input_slopes(unit: Unit, trial: Trial, base: np.ndarray) -> Any:
    """Σ |x d(outputs)/dx| over the inputs of a model without memory."""
    total: Any = mp.mpf(0)
    for s in unit.inputs if not unit.steps else ():
        h = mp.mpf(10) ** -19
        moved = [{**row, s.name: mp.mpf(row[s.name]) * (1 + h)} for row in trial.samples]
        total = total + np.abs((exact_outputs(unit, trial.parameters, moved) - base) / h)
    return total


def _scales(unit: Unit, wanted: np.ndarray) -> np.ndarray:
    """What an error is relative to: the value, a complex one's modulus, or the peak of a motion's output."""
    scale = np.abs(wanted)
    column = 0
    for o in unit.model.outputs:
        if unit.program.step.equations[o.name][1] is not None:
            modulus = np.array([mp.hypot(a, b) for a, b in wanted[:, column : column + 2]], dtype=object)
            scale[:, column] = scale[:, column + 1] = modulus
            column += 1
        column += 1
    return np.broadcast_to(scale.max(axis=0), scale.shape) if unit.steps else scale


def unit_inputs(unit: Unit, samples: Sequence[Mapping[str, float]], i: int) -> tuple[float, ...]:
    axis = unit.model.axis
    step = samples[i][axis] - samples[max(i - 1, 0)][axis] if axis else 0.0
    return tuple(step if s.name == unit.step else samples[i][s.name] for s in unit.inputs)
