"""Whether the samples of a record show its motion: between them the path is a guess."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from modelgen.fit.series import Array, Series
from modelgen.language import Model

FEWEST = 6
"""Samples from one reversal to the next by which a path is known: at fewer its extremes are off by a
thousandth of the amplitude and more (the error of a Hermite cubic, h⁴ ω⁴/384)."""
OFTEN = 0.2
"""Share of the reversals that may follow faster."""
WIGGLE = 0.02
"""Share of the stroke that is no swing, but the noise's."""
SOME = 5
"""Reversals below which a record is a few strokes, not a motion."""


def unresolved(model: Model, series: Sequence[Series]) -> tuple[str, ...]:
    """A note for each record over time whose displacement turns too fast for its samples."""
    moved = next((i.derived[1] for i in model.inputs if i.derived and i.derived[0] == "turning"), "")
    motion = model.derived_from(moved)
    if "previous" not in motion:
        return ()
    notes = []
    for s in series:
        turns = _turns(s.inputs[moved], s.inputs[motion["turning"]], s.inputs[motion["previous"]])
        if len(turns) < SOME:
            continue
        between = np.diff(turns)
        if np.mean(between < FEWEST) > OFTEN:
            notes.append(
                f"'{s.name}' turns every {float(np.median(between)):.0f} samples: the path between them is a "
                "guess, and what it misses can look like physics; a recording with more samples a cycle tells"
            )
    return tuple(notes)


def _turns(z: Array, turning: Array, before: Array) -> Array:
    """Where a displacement turns, but for wiggles that go next to no way."""
    least, kept = WIGGLE * float(np.ptp(z)), list[int]()
    for k in np.flatnonzero(turning != before):
        if not kept or abs(turning[k] - turning[kept[-1]]) > least:
            kept.append(int(k))
    return np.array(kept, dtype=int)
