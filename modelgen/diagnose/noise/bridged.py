"""Glitches of a recorded displacement: samples that stand alone, far off a path that is smooth without them;
and what was lost of it otherwise.

A hysteresis would take one for a way there and back, and remember it; a derivative is spoilt for as many
samples as it looks at. So they are bridged, and the verdict says so.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modelgen.diagnose.noise.lost import without_lost
from modelgen.fit.series import Array
from modelgen.language import Model
from modelgen.recordings import Case
from modelgen.recordings.noise import noise_std

SURE = 25.0
"""Standard deviations of the displacement's noise that a glitch is off the path, at least,"""
STEPS = 3.0
"""times the largest step of the samples around it,"""
SEEN = 0.02
"""and part of the whole stroke: a blow is slower, and what is smaller does no harm."""
SMOOTH = 8.0, 0.05
"""Standard deviations, and part of the glitch, that the path without it may be off a smooth one nearby."""
FEW = 0.01
"""Share of the samples that may be glitches: what comes more often is how the sensor works."""
NEAR = 3
"""Samples around that must go on smoothly without it."""
SHORTEST = 12
"""Samples of a record in which a path can be told from what is off it."""


def bridged(model: Model, case: Case) -> tuple[Case, tuple[str, ...]]:
    """The case with glitches of recorded displacements bridged, and a note for each of its recordings that
    has some."""
    moved = {i.derived[1] for i in model.inputs if i.derived and i.derived[0] in ("rate", "turning")}
    records, notes = [], []
    for r in case.recordings:
        for name in sorted(moved & set(r.inputs)):
            t, outputs = r.inputs[model.axis], [y for y in r.outputs.values() if not np.iscomplexobj(y)]
            z, found = without_glitches(t, r.inputs[name])
            z, lost = without_lost(t, z, outputs)
            if found.size:
                many = "glitch" if found.size == 1 else "glitches"
                notes.append(f"{found.size} {many} of {name} in '{r.name}', single samples, are bridged")
            if lost.size:
                many, it = ("sample", "it") if lost.size == 1 else ("samples", "them")
                what = f"{lost.size} {many} of {name} in '{r.name}' lie far off what is recorded around {it}"
                names = " and ".join(sorted(r.outputs))
                notes.append(f"{what}, of which {names} shows nothing: bridged as lost")
            if found.size or lost.size:
                r = replace(r, inputs={**r.inputs, name: z})
        records.append(r)
    return (replace(case, recordings=tuple(records)), tuple(notes)) if notes else (case, ())


def without_glitches(t: Array, z: Array) -> tuple[Array, NDArray[np.intp]]:
    """z (n,) sampled at t (n,) with glitches on the cubic through the samples next to them; which they
    were."""
    none = np.zeros(0, dtype=np.intp)
    if z.size < SHORTEST or not (np.diff(t) > 0).all():  # the latter is refused later, in words
        return z, none
    std, stroke = noise_std(t, z), float(np.ptp(z))
    off = _off(t, z)
    step = np.abs(np.diff(z))
    around = np.max([step[:-3], step[3:], np.abs(z[3:-1] - z[1:-3])], axis=0)
    large = np.abs(off) > np.maximum(np.maximum(SURE * std, STEPS * around), SEEN * stroke)
    path, found = z.copy(), []
    for n in (np.flatnonzero(large) + 2).tolist():
        path[n] -= off[n - 2]
        some = slice(max(n - NEAR - 2, 0), n + NEAR + 3)
        rest = np.abs(_off(t[some], path[some])).max(initial=0.0)
        if rest < SMOOTH[0] * std + SMOOTH[1] * abs(off[n - 2]):
            found.append(n)
        else:
            path[n] = z[n]
    few = 0 < len(found) <= FEW * z.size
    return (path, np.array(found, dtype=np.intp)) if few else (z, none)


def _off(t: Array, z: Array) -> Array:
    """(n − 4,) how far each sample is off the cubic through the two before and the two after it."""
    n = z.size - 4
    nodes = [slice(k, n + k) for k in (0, 1, 3, 4)]
    at = t[2:-2]
    predicted = np.zeros(n)
    for i in nodes:
        weight = np.ones(n)
        for j in nodes:
            if i != j:
                weight *= (at - t[j]) / (t[i] - t[j])
        predicted += weight * z[i]
    return np.asarray(z[2:-2] - predicted)
