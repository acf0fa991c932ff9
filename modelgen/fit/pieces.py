"""Records over time with gaps, in pieces: each a recording of its own, whose memory begins with what nobody
knows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from sympy import sympify

from modelgen.fit.experiment import initial_parameters
from modelgen.language import Model
from modelgen.language.meant import symbols
from modelgen.recordings import Case, Recording
from modelgen.recordings.gaps import gaps
from modelgen.recordings.runs import Array

SHORTEST = 20
"""Samples that a piece has at least; shorter ones are left out."""
MOST = 10
"""Gaps beyond which that is how the record is."""
Pieces = list[tuple[Recording, bool]]
"""Recordings, and whether they begin after a gap."""


def in_pieces(model: Model, case: Case) -> Case:
    """The case with records in pieces where they have gaps; what a piece begins with after one is free. Of
    what is held out, that needs it to be free somewhere in what is fitted; else it ends where a gap begins.

    As it is where the model has no memory, which loses nothing in a gap.
    """
    if not (model.is_time_model and model.states):
        return case
    begins = initial_parameters(model)
    free = all({x.name for x in symbols(sympify(s.initial))} & begins for s in model.states)
    made = [part for r in case.recordings for part in _pieces(model, r, free)]
    held = {
        p.name: p.default
        for p in model.scalar_parameters
        if p.name in begins and p.known and p.default is not None and p.name not in case.bounds
    }
    held |= {n: x for n, x in case.constants.items() if n in begins}
    fitted = [_begun(r, later, held, begins).constants for r, later in made if r.role == "fit"]
    if not all(any(n not in known for known in fitted) for n in begins):
        made = [(r, later) for r, later in made if r.role == "fit" or not later]
    if not any(later for _, later in made):
        return replace(case, recordings=tuple(r for r, _ in made))
    return replace(
        case,
        recordings=tuple(_begun(r, later, held, begins) for r, later in made),
        constants={n: x for n, x in case.constants.items() if n not in begins},
        bounds={**{n: model.parameter(n).bounds for n in held}, **case.bounds},
    )


def _begun(r: Recording, later: bool, held: dict[str, float], begins: set[str]) -> Recording:
    """A recording with what is known of how it begins: all that is `held`, or after a gap nothing."""
    if later:
        return replace(r, constants={n: x for n, x in r.constants.items() if n not in begins})
    return replace(r, constants=held | dict(r.constants))


def _pieces(model: Model, r: Recording, free: bool) -> Pieces:
    """A record's parts between its gaps, the first with a warning; itself where the model has states that
    begin with no number that may be `free`."""
    t = r.inputs.get(model.axis)
    found = [] if t is None else gaps(t, [x for n, x in r.inputs.items() if n != model.axis])
    if t is None or not found:
        return [(r, False)]
    said = _told(model, r, t, found)
    parts = [slice(a, b) for a, b in pairwise([0, *(k + 1 for k in found), r.n]) if b - a >= SHORTEST]
    if not free or len(found) > MOST or not parts:
        said += "; it is left as it is, though nobody knows how it moved there"
        return [(replace(r, warnings=(*r.warnings, said)), False)]
    said += "; what comes after one counts as a recording of its own, whatever the sample went through"
    if r.role != "fit":
        said += ", if at all"
    if (left := r.n - sum(s.stop - s.start for s in parts)) > 0:
        said += f", and {left} samples in shorter pieces than {SHORTEST} do not count"
    names = [r.name, *(f"{r.name} from {t[s.start]:.12g} {_unit(model)}" for s in parts[1:])]
    warnings = [(*r.warnings, said), *[()] * (len(parts) - 1)]
    return [(_part(r, s, name, w), s.start > 0) for s, name, w in zip(parts, names, warnings, strict=True)]


def _told(model: Model, r: Recording, t: Array, found: Sequence[int]) -> str:
    """Where the longest of a record's gaps is, and how long."""
    step, unit = np.diff(t), _unit(model)
    k = max(found, key=lambda k: float(step[k]))
    count = "a gap" if len(found) == 1 else f"{len(found)} gaps"
    return (
        f"'{r.name}' has {count}: {step[k]:.3g} {unit} after {model.axis} = {t[k]:.12g} {unit}, "
        f"{step[k] / np.median(step):.0f} times the usual step"
    )


def _unit(model: Model) -> str:
    return next(i.unit for i in model.inputs if i.name == model.axis)


def _part(r: Recording, some: slice, name: str, said: tuple[str, ...]) -> Recording:
    return replace(
        r,
        name=name,
        inputs={n: x[some] for n, x in r.inputs.items()},
        outputs={n: x[some] for n, x in r.outputs.items()},
        warnings=said,
    )
