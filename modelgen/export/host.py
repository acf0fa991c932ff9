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
            worst["derivatives"] = float(
                np.max(np.abs(jac - wanted[..., 0]) / wanted[..., 1], initial=worst["derivatives"])
            )
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


def reach(c: Compiled, real: str, trial: Trial, ranges: Mapping[str, Range]) -> tuple[Reach, ...]:
    """Each input alone, over ±10^k, the others in the middle of their ranges."""
    found = []
    for i in c.unit.model.inputs:
        if i.name not in {s.name for s in c.unit.inputs}:
            continue
        low, high = ranges.get(i.name, default_range(i))
        powers = [10.0**k for k in range(-DECADES, DECADES + 1, 2)]
        inner = [v for v in (low, high) if v]
        values = sorted({*powers, *(-x for x in powers), *inner})
        values = [rounder(real)(v) for v in values]
        says = [_judge(c, real, trial, i.name, v) for v in values]
        first = min(range(len(values)), key=lambda k: abs(values[k] - rounder(real)(high or low)))
        a = b = first
        while a > 0 and says[a - 1] == "right":
            a -= 1
        while b < len(values) - 1 and says[b + 1] == "right":
            b += 1
        found.append(
            Reach(
                i.name, i.unit, values[a], values[b],
                says[a - 1] if a else "", says[b + 1] if b < len(values) - 1 else "",
            )
        )  # fmt: skip
    return tuple(found)


def _judge(c: Compiled, real: str, trial: Trial, name: str, value: float) -> str:
    unit, p = c.unit, [trial.parameters[s.name] for s in c.unit.parameters]
    middle = dict(trial.samples[len(trial.samples) // 2])
    samples = [dict(trial.samples[0]), {**dict(trial.samples[1 % len(trial.samples)]), name: value}]
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
