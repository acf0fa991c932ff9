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

SURE = 12.0
"""Standard deviations of the displacement's noise that a glitch is off the path, at least,"""
SEEN = 0.002
"""part of the whole stroke, as what is smaller does no harm,"""
DIGITS = 3.0
"""steps of its resolution,"""
STEPS = 0.5
"""and times the largest step of the samples around it: a turn of the path is off by less."""
SMOOTH = 6.0, 0.05
"""Standard deviations, and part of the glitch, that the path without it may be off a smooth one nearby."""
EITHER = 0.6
"""Part of it that shows from the samples before it and from those after it alone: a corner is the end of
either."""
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
                one = found.size == 1
                many, are = ("glitch", "a single sample, is") if one else ("glitches", "single samples, are")
                notes.append(f"{found.size} {many} of {name} in '{r.name}', {are} bridged")
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
    std, step = noise_std(t, z), np.abs(np.diff(z))
    digit = float(np.min(step[step > 0], initial=np.inf))
    least = max(SURE * std, SEEN * float(np.ptp(z)), DIGITS * digit if np.isfinite(digit) else 0.0)
    off = np.abs(_off(t, z))
    large = np.flatnonzero(off > least)
    if not 0 < large.size <= 3 * FEW * z.size:  # each glitch shows in its neighbours, too
        return z, none
    path, found = z.copy(), []
    for n in (large[np.argsort(-off[large])] + 2).tolist():
        size = float(_off(t[n - 2 : n + 3], path[n - 2 : n + 3])[0])
        if abs(size) > least and _from_either_side(t, path, n, size):
            path[n] -= size
            some = slice(max(n - NEAR - 2, 0), n + NEAR + 3)
            rest = np.abs(_off(t[some], path[some])).max(initial=0.0)
            around = np.abs(np.diff(path[some])).max()
            if rest < SMOOTH[0] * std + SMOOTH[1] * abs(size) and abs(size) > STEPS * around:
                found.append(n)
            else:
                path[n] += size
    few = 0 < len(found) <= FEW * z.size
    return (path, np.array(sorted(found), dtype=np.intp)) if few else (z, none)


def _from_either_side(t: Array, z: Array, n: int, size: float) -> bool:
    """Whether sample n is off the parabolas through three before it and through three after it as it is off
    the path between these; at an end of the record, the one that there is."""
    sides = [k for k in (slice(n - 3, n), slice(n + 1, n + 4)) if k.start >= 0 and k.stop <= len(z)]
    seen = [(z[n] - np.polyval(np.polyfit(t[k] - t[n], z[k], 2), 0.0)) / size for k in sides]
    return min(seen) > EITHER


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
