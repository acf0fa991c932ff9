"""What follows the motion: the part of a residual over time that functions of the motion explain.

Noise of any colour holds little of it, and as much after a law was added as before. A law that is missing
leaves it in each part of each recording alike, and takes it away once it is there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from modelgen.diagnose.hypotheses import functions
from modelgen.fit.series import Array, Series
from modelgen.language import Model

GROUPS = ("displacement", "speed", "both", "play", "memory")
"""Functions of few variables and memories that make up the space; short wavelengths would be most of it."""
PLAYED = (0.81, 0.86, 0.91, 1.1, 1.16, 1.23)
"""Speeds at which a motion is another of the same kind, which what is left has nothing to do with."""
MORE, MOST = 2.0, 0.5
"""What is left follows the motion that explains so many times what any of these does, or that share of it."""
ROOM = 10
"""Samples of a record for each of them."""
FULL = 1e-8
"""Singular values, over the largest, below which a function adds nothing to the others; and rms of one that
doesn't move."""


def following(model: Model, series: Sequence[Series], white: Sequence[Array]) -> list[Array] | None:
    """The parts of whitened residuals `white` (channels, n) of each record that functions of its motion
    explain; None where no motion is recorded, or a record is too short for so many functions."""
    name = model.moved
    if not name:
        return None
    z = functions.scaled([s.inputs[name] for s in series])
    v = functions.scaled_speed([s.inputs[model.derived_from(name)["rate"]] for s in series])
    parts = []
    for s, x, speed, e in zip(series, z, v, white, strict=True):
        columns = np.stack(list(_columns(x, speed, s.inputs[model.axis])), axis=1)
        if len(columns) < ROOM * columns.shape[1]:
            return None
        used = np.any(e != 0, axis=0)  # what is marked weighs nothing
        columns = (columns - columns.mean(axis=0)) * used[:, None]
        u = _orthonormal(columns)
        parts.append((e - e.mean(axis=1, keepdims=True)) @ u @ u.T)
    return parts


def _orthonormal(columns: Array) -> Array:
    """(n, k) of the space of `columns` (n, m), in units of their own; those that stand are none of it: a play
    is wider than a small stroke, and a record may be at rest."""
    height = np.linalg.norm(columns, axis=0)
    moved = columns[:, height > FULL * np.sqrt(len(columns))]
    if not moved.size:
        return moved
    u, size, _ = np.linalg.svd(moved / np.linalg.norm(moved, axis=0), full_matrices=False)
    return np.asarray(u[:, size > FULL * size[0]])


def ignores_motion(model: Model, series: Sequence[Series], white: Sequence[Array]) -> bool:
    """Whether functions of the motion explain no more of the residuals `white` in any record than functions
    of one that has nothing to do with them: it played faster or slower. False where that can't be told."""
    own = _shares(model, series, white)
    if own is None or np.any(own > MOST):
        return False
    played = [_shares(model, [_played(model, s, speed) for s in series], white) for speed in PLAYED]
    return bool(np.all(own <= MORE * np.max([x for x in played if x is not None], axis=0)))


def _shares(model: Model, series: Sequence[Series], white: Sequence[Array]) -> Array | None:
    """Share of the squares of each record's residuals that functions of its motion explain."""
    parts = following(model, series, white)
    if parts is None:
        return None
    pairs = zip(parts, white, strict=True)
    return np.array([np.sum(p**2) / max(float(np.sum(e**2)), 1e-300) for p, e in pairs])


def _played(model: Model, s: Series, speed: float) -> Series:
    """A record with its motion played at another speed, and back from its end on where that is reached."""
    moved, rate = model.moved, model.derived_from(model.moved)["rate"]
    t = s.inputs[model.axis] - s.inputs[model.axis][0]
    at, way = np.where(speed * t > t[-1], 2 * t[-1] - speed * t, speed * t), np.sign(t[-1] - speed * t)
    z, v = np.interp(at, t, s.inputs[moved]), way * np.interp(at, t, s.inputs[rate])
    return replace(s, inputs={**s.inputs, moved: z, rate: v})


def _columns(z: Array, v: Array, t: Array) -> Iterator[Array]:
    yield z
    yield v
    for _, _, make in functions.groups():
        if make.__name__ in GROUPS:
            yield from make(z, v, t, z)
