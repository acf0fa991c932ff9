"""A time model's recordings cut into segments, each with an initial state of its own: multiple shooting.

Bock, Recent advances in parameter identification techniques for O.D.E. (1983): over a short stretch a model
cannot run away from its data, however bad its parameters are; that the stretches join is a condition of the
optimum.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from modelgen.codegen import build_many
from modelgen.codegen.function import Function, Prepared
from modelgen.codegen.lower import primary_outputs
from modelgen.errors import InputError
from modelgen.fit.series import Array, Series
from modelgen.fit.whitener import Whitener
from modelgen.language import Model, Output, Parameter

if TYPE_CHECKING:
    from modelgen.fit.experiment import Experiment


@dataclass(frozen=True, eq=False)
class Leg:
    """One segment, run: whitened residual (m,), the states (s,) after its last sample, and the derivatives of
    both by θ and the states it began with: (m, p + s), (s, p + s)."""

    residual: Array
    residual_slope: Array
    end: Array
    end_slope: Array


@dataclass(frozen=True, eq=False)
class Segment:
    """Samples of one recording from one edge to the next. `own`: those that count in the residual; the first
    counts in the segment before."""

    recording: int
    own: slice
    prepared: Prepared
    data: Array
    weight: Array


@dataclass(frozen=True, eq=False)
class Segments:
    """All recordings in segments.

    states: s, how many a model has. joins: for each segment, whether it goes on where the one before ends,
    with states of its own that must be the other's; else it is the first of its recording.
    """

    parts: tuple[Segment, ...]
    place: Array
    held: Array
    rows: tuple[tuple[int, ...], ...]
    state_rows: tuple[int, ...]
    size: int

    @property
    def states(self) -> int:
        return len(self.state_rows)

    @property
    def joins(self) -> tuple[bool, ...]:
        return tuple(part.own.start == 1 for part in self.parts)

    def run(self, k: int, theta: Array, start: Array) -> Leg:
        """Segment k for θ (p,) from the states `start` (s,), which count where it joins another."""
        part, s = self.parts[k], self.states
        place = self.place[part.recording]
        local = np.where(place >= 0, np.append(theta, 0.0)[place], self.held[part.recording])
        values = np.concatenate([local, start]) if self.joins[k] else local
        out, jac = part.prepared.jacobian(values, "real")
        rows, moves = list(self.rows[part.recording]), np.flatnonzero(place >= 0)
        found = np.zeros((self.size + s, *jac.shape[::2]))  # by θ and states: (p + s, channels, samples)
        found[place[moves]] = jac[:, moves].transpose(1, 0, 2)
        if self.joins[k]:
            found[self.size :] = jac[:, len(place) :].transpose(1, 0, 2)
        at, ends = part.own, list(self.state_rows)
        e = (out[rows, at] - part.data) * part.weight
        slope = found[:, rows, at] * part.weight
        return Leg(e.ravel(), slope.reshape(len(slope), -1).T, out[ends, -1], found[:, ends, -1].T)


def segments(ex: Experiment, count: int, whiteners: Sequence[Whitener] | None = None) -> Segments:
    """Cut each recording of `ex` into `count` segments (fewer where it has not so many samples).

    Raises InputError where none has so many.
    """
    most = max(s.n for s in ex.series) - 1
    if count > most:
        raise InputError(f"shooting = {count}: the longest recording can be cut into {most} segments at most")
    whole, later = _begun(ex.model, ex.layout.wrt)
    parts = []
    for k, s in enumerate(ex.series):
        w = whiteners[k] if whiteners else s.whitener
        edges = np.unique(np.linspace(0, s.n - 1, min(count, max(s.n - 1, 1)) + 1).round().astype(int))
        for first, last in pairwise(edges):
            function, own = (whole, slice(0, None)) if first == 0 else (later, slice(1, None))
            span = slice(int(first), int(last) + 1)
            weight = np.broadcast_to(w.weight, s.data.shape)[:, span][:, own]
            ready = _prepared(ex, function, s, span)
            parts.append(Segment(k, own, ready, s.data[:, span][:, own], weight))
    names = primary_outputs(whole.model)
    return Segments(
        tuple(parts), ex.layout.place, ex.layout.held, tuple(s.rows for s in ex.series),
        tuple(names.index(x.name) for x in ex.model.states), len(ex.layout.names),
    )  # fmt: skip


def _prepared(ex: Experiment, function: Function, s: Series, span: slice) -> Prepared:
    values: dict[str, Any] = dict.fromkeys(function.wrt, 0.0) | {**ex.constants, **s.constants}
    values |= {i.name: np.ascontiguousarray(s.inputs[i.name][span]) for i in ex.model.inputs}
    return function.prepare(**values)


def _begun(model: Model, wrt: tuple[str, ...]) -> list[Function]:
    """`model` with its states as outputs, and the same begun from any states: parameters of their own."""
    shown = [o.name for o in model.outputs]
    outputs = (*model.outputs, *(Output(x.name) for x in model.states if x.name not in shown))
    used = {p.name for p in model.parameters} | {s.name for s in model.statements}
    starts = []
    for x in model.states:
        name = f"{x.name}_start"
        while name in used:
            name += "_"
        starts.append(Parameter(name, x.unit, 0.0, text=f"{x.name} where the segment begins"))
    begin = dict(zip([x.name for x in model.states], starts, strict=True))
    statements = tuple(
        replace(s, initial=begin[s.name].symbol) if s.name in begin else s for s in model.statements
    )
    whole = replace(model, outputs=outputs)
    later = replace(whole, parameters=(*model.parameters, *starts), statements=statements)
    free = (*wrt, *(p.name for p in starts))
    return build_many([(whole, wrt), (later, free)], ("jacobian",), quick=False)
