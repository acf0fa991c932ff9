"""An effect at a port of the model, with the ranges in which its numbers are searched."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf

import numpy as np

from modelgen.effects import Effect, Shape, Strength, family, search_range
from modelgen.fit.experiment import Layout
from modelgen.fit.series import Array
from modelgen.language import Model, Parameter, Port

MARGIN = 3.0
"""A fit may leave the range in which a shape is searched first by this factor."""
UNSEEN = 10.0
"""The same of a motion that is not recorded: how far it goes is known by the base alone, and that may be far
off."""
MOTIONS = ("displacement", "position", "speed")
"""Scales of a motion."""


RESONANT = 16
"""Values of one quantity that are tried where it places resonances."""


@dataclass(frozen=True, eq=False)
class Addition:
    """An effect at a port, with the search range of each of its shapes (and of strengths tried at a finite
    value); `repeats`: names of the recordings in which strengths have values of their own; `unseen`: the
    motion at the port is not recorded."""

    effect: Effect
    port: Port
    ranges: Mapping[str, tuple[float, float]]
    repeats: tuple[str, ...] = ()
    unseen: bool = False

    @property
    def id(self) -> str:
        return self.effect.id

    @property
    def key(self) -> tuple[str, str, int]:
        return (self.effect.id, f"{self.port.kind} {self.port.equation}", id(self.effect))

    @property
    def strengths(self) -> tuple[str, ...]:
        if self.effect.each:
            return tuple(f"{n}[{r}]" for n in self.shared for r in self.repeats)
        return self.shared

    @property
    def nulls(self) -> dict[str, float]:
        """Strengths and their values in the model without the effect."""
        nulls = {f"{self.id}_{q.name}": q.null for q in self.effect.strengths}
        return {n: nulls[n.partition("[")[0]] for n in self.strengths}

    @property
    def shared(self) -> tuple[str, ...]:
        """Names of the strengths in the model; `strengths` are those of θ."""
        return tuple(f"{self.id}_{q.name}" for q in self.effect.strengths)

    @property
    def count(self) -> int:
        """How many numbers it has."""
        return len(self.strengths) + len(self.effect.shapes)

    @property
    def family(self) -> str:
        return family(self.effect)

    @property
    def place(self) -> str:
        """Name of the parameter that places resonances; "" if the effect has none."""
        tried: list[Strength | Shape] = [
            *(self.effect.strengths if self.effect.secant else ()),
            *self.effect.shapes,
        ]
        return next((f"{self.id}_{q.name}" for q in tried if q.points >= RESONANT), "")

    def extend(self, model: Model) -> Model:
        """`model` with this effect; the port is looked up by its equation, which other effects keep in
        place."""
        port = next(p for p in model.ports if p.kind == self.port.kind and p.equation == self.port.equation)
        return _with_ranges(self.effect.extend(model, port), self)

    @cached_property
    def grid(self) -> list[Mapping[str, float]]:
        """Values of shapes (and of strengths of `secant` effects) that are tried first."""
        tried: list[Shape | Strength] = [*self.effect.shapes]
        if self.effect.secant:
            tried += [q for q in self.effect.strengths if q.name in self.ranges]
        points: list[Mapping[str, float]] = [{}]
        for q in tried:
            low, high = self.ranges[q.name]
            values = (
                np.geomspace(low, high, q.points) if q.log and low > 0 else np.linspace(low, high, q.points)
            )
            points = [{**p, f"{self.id}_{q.name}": float(v)} for p in points for v in values]
        return points


def _with_ranges(model: Model, a: Addition) -> Model:
    """Bounds of the effect's shapes: the range that is searched, and somewhat beyond; and of strengths that
    have one."""
    new: list[Parameter] = []
    for s in a.effect.strengths if not a.effect.secant else ():
        if s.name in a.ranges:
            p = model.parameter(f"{a.id}_{s.name}")
            new.append(replace(p, bounds=(p.bounds[0], min(a.ranges[s.name][1], p.bounds[1]))))
    for q in a.effect.shapes:
        p = model.parameter(f"{a.id}_{q.name}")
        low, high = _margins(a, q)
        low, high = max(low, p.bounds[0]), min(high, p.bounds[1])
        new.append(replace(p, bounds=(low, high), default=None))
    names = {p.name: p for p in new}
    return replace(model, parameters=tuple(names.get(p.name, p) for p in model.parameters))


def _margins(a: Addition, q: Shape) -> tuple[float, float]:
    """Bounds of a shape that is searched first in its range."""
    low, high = a.ranges[q.name]
    unseen = a.unseen and any(m in q.scale for m in MOTIONS)
    if q.scale == "1" or (isinstance(q, Shape) and q.within and not unseen):
        return low, high
    more = UNSEEN if unseen else MARGIN
    beyond = (high - low) * (more - 1) / 2
    return (low / more, high * more) if q.log and low > 0 else (low - beyond, high + beyond)


def ranged(a: Addition, scales: Mapping[str, Array]) -> Addition:
    """The addition with the search ranges of shapes that other scales of recordings give it.

    Those in scales that recordings alone don't tell (of a port, of a motion that is not recorded) stay.
    """
    tried = {}
    for q in a.effect.shapes:
        try:
            tried[q.name] = search_range(q, scales)
        except KeyError:
            continue
    return replace(a, ranges={**a.ranges, **tried})


def widened(layout: Layout, added: Sequence[Addition]) -> Layout:
    """The layout with bounds of shapes that reach as far as the ranges of `added`, too."""
    bounds = {p.name: p.bounds for p in layout.parameters}
    for a in added:
        for q in a.effect.shapes:
            low, high = bounds.get(name := f"{a.id}_{q.name}", (inf, -inf))
            least, most = _margins(a, q)
            bounds[name] = min(low, max(least, 0.0) if q.log else least), max(high, most)
    return replace(layout, parameters=tuple(replace(p, bounds=bounds[p.name]) for p in layout.parameters))


def additions(
    model: Model,
    effects: Sequence[Effect],
    scales: Mapping[str, Array],
    port_sizes: Mapping[str, Array],
    motions: Mapping[str, Mapping[str, Array]],
    repeats: tuple[str, ...] = (),
    records: tuple[str, ...] = (),
) -> list[Addition]:
    """All effects that fit a port of `model` and whose scales the recordings have, or the `motions` at the
    port. `records`: names of the recordings; `repeats`: of those that repeat each other."""
    found = []
    for e in effects:
        alike = records if e.levels else repeats
        for port in e.fits(model) if len(alike) > 1 or not e.each else ():
            known = {**scales, **motions.get(port.equation, {}), "port": port_sizes[port.equation]}
            if not model.is_time_model:
                known["mass"] = known["port"] / known["omega"] ** (2 if port.kind == "stiffness" else 1)
            try:
                tried: list[Strength | Shape] = [*e.shapes, *(q for q in e.strengths if q.scale)]
                ranges = {q.name: search_range(q, known) for q in tried}
            except KeyError:
                continue
            if all(np.isfinite(r).all() and r[0] < r[1] for r in ranges.values()):
                own = alike[0 if e.first else 1 :] if e.each else ()
                found.append(Addition(e, port, ranges, own, bool(motions.get(port.equation))))
    return found
