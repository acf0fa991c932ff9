"""Exported C compiled and called on this machine: how far from the truth it is, over which inputs."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mpmath as mp
import numpy as np

from modelgen.codegen.compiler import compile_library
from modelgen.export.exact import DIGITS, FAILURES
from modelgen.export.floats import rounder
from modelgen.export.unit import Unit
from modelgen.export.values import Range, Trial, default_range
from modelgen.export.vectors import EPSILON, Vector, exact_outputs, unit_inputs

STRICT = ("-O2", "-ffp-contract=off")
DECADES = 36


class Compiled:
    """The exported functions of a unit, by name; structs are arrays of the one type they hold."""

    def __init__(self, unit: Unit, real: str, files: Mapping[str, str]) -> None:
        own = {n: t for n, t in files.items() if n in (f"{unit.prefix}.h", f"{unit.prefix}.c")}
        self.unit, self.type = unit, np.dtype(np.float32 if real == "float" else np.float64)
        self._library = ctypes.CDLL(str(compile_library(own, STRICT)))
        self.state = np.zeros(max(1, len(unit.states)), self.type)
        self.tangent = np.zeros(max(1, len(unit.tangents)), self.type)

    def call(
        self, name: str, parameters: Sequence[float], inputs: Sequence[float]
    ) -> tuple[int, np.ndarray, np.ndarray]:
        """Status, outputs and Jacobian (rows, columns) of one call; the state is kept in `self.state`."""
        u, jacobian = self.unit, name.endswith("jacobian")
        out = np.full(len(u.outputs), np.nan, self.type)
        jac = np.full((len(u.rows), len(u.columns)), np.nan, self.type)
        arrays = [np.array(parameters or [0.0], self.type)]
        arrays += [np.array(inputs, self.type)] if u.inputs else []
        arrays += [self.state] if u.steps else []
        arrays += [self.tangent] if jacobian and u.tangents else []
        arrays += [out] + ([jac] if jacobian else [])
        function = getattr(self._library, f"{u.prefix}_{name}")
        status = function(*(a.ctypes.data_as(ctypes.c_void_p) for a in arrays))
        return int(status), out, jac


def measured_errors(c: Compiled, tried: Sequence[Trial], vectors: Sequence[Vector]) -> dict[str, float]:
    """Worst relative error by output over the vectors, and of the "derivatives"."""
    worst = dict.fromkeys([*(s.name for s in c.unit.outputs), "derivatives"], 0.0)
    for v in vectors:
        p = [tried[v.trial].parameters[s.name] for s in c.unit.parameters]
        plain, slopes = ("start", "start_jacobian") if v.first else ("step", "step_jacobian")
        if not c.unit.steps:
            plain, slopes = "evaluate", "jacobian"
        if v.jacobian:
            kept = c.state.copy()
            _, _, jac = c.call(slopes, p, v.inputs)
            c.state[:] = kept
            wanted = np.array(v.jacobian)
            judged = wanted[..., 1] > 0
            relative = np.abs(jac - wanted[..., 0])[judged] / wanted[..., 1][judged]
            worst["derivatives"] = float(np.max(relative, initial=worst["derivatives"]))
        _, out, _ = c.call(plain, p, v.inputs)
        for s, got, wanted_, scale in zip(c.unit.outputs, out, v.wanted, v.scale, strict=True):
            if scale > 0:
                worst[s.name] = float(np.fmax(worst[s.name], abs(float(got) - wanted_) / scale))
    return worst


@dataclass(frozen=True)
class Reach:
    """Over which values of an input results are right to half the digits, and what happens beyond."""

    name: str
    unit: str
    low: float
    high: float
    below: str
    above: str


def reach(
    c: Compiled, real: str, trial: Trial, peak: Sequence[float], ranges: Mapping[str, Range]
) -> tuple[Reach, ...]:
    """Each input alone, over ±10^k, the others as in the first trial.

    peak: of each output; a model with memory is judged by it.
    """
    found: list[Reach] = []
    units = {i.name: i.unit for i in c.unit.model.inputs}
    for slot in c.unit.inputs:
        low, high = _tested(c.unit, trial, slot.name, ranges)
        powers = [10.0**k for k in range(-DECADES, DECADES + 1, 2)]
        tried = {*powers, *(v for v in (low, high) if v), *(-x for x in powers if slot.name != c.unit.step)}
        values = sorted(rounder(real)(v) for v in tried)
        says = [_judge(c, real, trial, peak, slot.name, v) for v in values]
        first = min(range(len(values)), key=lambda k: abs(values[k] - rounder(real)(high or low)))
        a = b = first
        while a > 0 and says[a - 1] == "right":
            a -= 1
        while b < len(values) - 1 and says[b + 1] == "right":
            b += 1
        found.append(
            Reach(
                slot.name, units.get(slot.name, slot.unit), values[a], values[b],
                says[a - 1] if a else "", says[b + 1] if b < len(values) - 1 else "",
            )
        )  # fmt: skip
    return tuple(found)


def _tested(unit: Unit, trial: Trial, name: str, ranges: Mapping[str, Range]) -> Range:
    for i in unit.model.inputs:
        if i.name == name:
            return ranges.get(name, default_range(i))
    step = unit_inputs(unit, trial.samples, 1)[[s.name for s in unit.inputs].index(name)]
    return (step, step)


def _judge(c: Compiled, real: str, trial: Trial, peak: Sequence[float], name: str, value: float) -> str:
    unit, p = c.unit, [trial.parameters[s.name] for s in c.unit.parameters]
    middle = dict(trial.samples[len(trial.samples) // 2])
    first, second = trial.samples[0], trial.samples[1 % len(trial.samples)]
    moved = {unit.model.axis: first[unit.model.axis] + value} if name == unit.step else {name: value}
    samples = [dict(first), {**second, **moved}]
    samples = samples if unit.steps else [{**middle, name: value}]
    if unit.steps:
        c.call("start", p, unit_inputs(unit, samples, 0))
    last = unit_inputs(unit, samples, len(samples) - 1)
    status, out, _ = c.call("step" if unit.steps else "evaluate", p, last)
    if status:
        return "refused"
    try:
        with mp.workdps(DIGITS):
            wanted = exact_outputs(unit, trial.parameters, samples)[-1]
            sizes = _sizes(unit, wanted)
            sizes = [max(s, p) for s, p in zip(sizes, peak, strict=True)] if unit.steps else sizes
            error = max(
                abs(mp.mpf(float(g)) - w) / s if s else abs(mp.mpf(float(g)))
                for g, w, s in zip(out, wanted, sizes, strict=True)
            )
    except FAILURES:
        return "no exact value"
    return "right" if error <= EPSILON[real] ** 0.5 else "inaccurate"


def _sizes(unit: Unit, wanted: Sequence[Any]) -> list[Any]:
    """Of a complex output both parts are judged by the modulus."""
    sizes, k = [], 0
    for o in unit.model.outputs:
        if unit.program.step.equations[o.name][1] is None:
            sizes.append(abs(wanted[k]))
            k += 1
        else:
            sizes += [mp.hypot(wanted[k], wanted[k + 1])] * 2
            k += 2
    return sizes
