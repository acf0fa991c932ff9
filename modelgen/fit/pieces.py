"""Records over time with gaps, in pieces: each a recording of its own, whose memory begins with what nobody
knows."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

from modelgen.fit.experiment import initial_parameters
from modelgen.language import Model
from modelgen.recordings import Case, Recording
from modelgen.recordings.gaps import gaps

SHORTEST = 20
"""Samples that a piece has at least; shorter ones are left out."""
MOST = 10
"""Gaps beyond which that is how the record is."""


def in_pieces(model: Model, case: Case) -> Case:
    """The case with records in pieces where they have gaps; what a piece begins with after one is free. As it
    is where the model has no memory: it loses nothing in a gap."""
    if not (model.is_time_model and model.states):
        return case
    made = [(piece, k > 0) for r in case.recordings for k, piece in enumerate(_pieces(model, r))]
    if not any(later for _, later in made):
        return replace(case, recordings=tuple(r for r, _ in made))
    begins = initial_parameters(model)
    held = {
        p.name: p.default
        for p in model.scalar_parameters
        if p.name in begins and p.known and p.default is not None and p.name not in case.bounds
    }
    held |= {n: x for n, x in case.constants.items() if n in begins}
    records = []
    for r, later in made:
        own = {n: x for n, x in r.constants.items() if n not in begins} if later else held | dict(r.constants)
        records.append(replace(r, constants=own))
    return replace(
        case,
        recordings=tuple(records),
        constants={n: x for n, x in case.constants.items() if n not in begins},
        bounds={**{n: model.parameter(n).bounds for n in held}, **case.bounds},
    )


def _pieces(model: Model, r: Recording) -> list[Recording]:
    """A record's parts between its gaps; a warning with the first of them."""
    moved = [x for n, x in r.inputs.items() if n != model.axis]
    t = r.inputs.get(model.axis)
    found = [] if t is None else gaps(t, moved)
    if t is None or not found:
        return [r]
    unit = next(i.unit for i in model.inputs if i.name == model.axis)
    longest = max(found, key=lambda k: t[k + 1] - t[k])
    what = (
        f"'{r.name}' has {'a gap' if len(found) == 1 else f'{len(found)} gaps'}: "
        f"{t[longest + 1] - t[longest]:.3g} {unit} after {model.axis} = {t[longest]:.6g} {unit}, "
        f"{(t[longest + 1] - t[longest]) / (t[longest] - t[longest - 1]):.0f} times the step before"
    )
    if len(found) > MOST:
        said = f"{what}; so many are left as they are, though nobody knows how it moved in them"
        return [replace(r, warnings=(*r.warnings, said))]
    parts = [slice(a, b) for a, b in pairwise([0, *(k + 1 for k in found), r.n]) if b - a >= SHORTEST]
    if len(parts) < 2:
        said = f"{what}, and is too short to be parted there"
        return [replace(r, warnings=(*r.warnings, said))]
    said = f"{what}: what comes after it counts as a recording of its own, whatever the sample went through"
    first = _part(r, parts[0], r.name, (*r.warnings, said))
    return [first, *(_part(r, s, f"{r.name} from {t[s.start]:.6g} {unit}", ()) for s in parts[1:])]


def _part(r: Recording, some: slice, name: str, said: tuple[str, ...]) -> Recording:
    return replace(
        r,
        name=name,
        inputs={n: x[some] for n, x in r.inputs.items()},
        outputs={n: x[some] for n, x in r.outputs.items()},
        warnings=said,
    )
