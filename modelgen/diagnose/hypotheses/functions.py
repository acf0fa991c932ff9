"""Functions of few variables over time, by which a missing force is described without a catalogue."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from modelgen.fit.colour import recursive
from modelgen.fit.series import Array


def scaled(parts: Sequence[Array]) -> list[Array]:
    """The recordings' values, in common from −1 to 1: one law holds in all of them."""
    low, high = min(x.min() for x in parts), max(x.max() for x in parts)
    half = float(high - low) / 2 or 1.0
    return [(x - (high + low) / 2) / half for x in parts]


def scaled_speed(parts: Sequence[Array]) -> list[Array]:
    """The recordings' speeds over the greatest but for a few samples of all."""
    fast = float(np.quantile(np.abs(np.concatenate(list(parts))), 0.995)) or 1.0
    return [v / fast for v in parts]


PITCHES = np.arange(1.0, 80.0, 0.5)
"""Half waves in half a stroke that are tried: at the ends of the stroke none is missed by more than π/4."""

WAVE = "wave"
"""A term of one of them, by its wave number."""

LINE = "line"
"""A wave in time, by its frequency [Hz]."""
PUMP = "pump"
"""What changes with waves in time: the lowest frequency [Hz], what the change is in proportion to, and how
many."""
ORDERS = 3
"""Harmonics that either is described by."""
LEVEL = "level"
"""A distortion of a channel, by where it begins."""
LEVELS = (0.3, 0.5, 0.7, 0.8, 0.85, 0.9, 0.93, 0.95, 0.97, 0.98, 0.99, 0.995)
"""Where it is tried, from the middle of what was recorded to its ends."""


def level(which: int, force: Sequence[Array]) -> tuple[float, int]:
    """Where the distortion `which` of recordings of a force begins, in its unit, and on which side."""
    low, high = min(x.min() for x in force), max(x.max() for x in force)
    side = -1 if which % 2 else 1
    return float((high + low) / 2 + side * LEVELS[which // 2] * (high - low) / 2), side


def wave_number(which: int, z: Sequence[Array]) -> float:
    """That of the pitch `which` in recordings of a displacement, in its unit."""
    stroke = max(x.max() for x in z) - min(x.min() for x in z)
    return 2 * np.pi * float(PITCHES[which]) / (float(stroke) or 1.0)


Group = tuple[str, str, Callable[[Array, Array, Array, Array], Iterable[Array]]]
"""What it would be, kind of port, columns of displacement, speed, time and force, each in units of its own
size."""


def groups() -> list[Group]:
    """All that are tried."""

    def position(z: Array, v: Array, t: Array, F: Array) -> Iterable[Array]:
        for k in PITCHES:
            yield np.cos(k * np.pi * z)
            yield np.sin(k * np.pi * z)

    def displacement(z: Array, v: Array, t: Array, F: Array) -> Iterable[Array]:
        return (z**k for k in range(2, 9))

    def speed(z: Array, v: Array, t: Array, F: Array) -> Iterable[Array]:
        yield from (np.sign(v) * np.abs(v) ** p for p in (0.3, 0.6, 1.5, 2.0, 3.0))
        yield from (np.abs(v) ** p for p in (0.5, 1.0, 2.0))

    def both(z: Array, v: Array, t: Array, F: Array) -> Iterable[Array]:
        for a in (1, 2, 3):
            yield z**a * v
            yield z**a * np.abs(v)
            yield z**a * np.sign(v)

    def play(z: Array, v: Array, t: Array, F: Array) -> Iterable[Array]:
        for g in (0.02, 0.05, 0.1, 0.2, 0.4, 0.8):
            yield _play(z, g)

    def memory(z: Array, v: Array, t: Array, F: Array) -> Iterable[Array]:
        step = float(np.median(np.diff(t)))
        for tau in np.geomspace(3 * step, max((t[-1] - t[0]) / 2, 6 * step), 7):
            a = np.exp(-step / tau)
            yield recursive(np.array([1.0, -a]), (1 - a) * (z - z[0])[None])[0]

    def shown(z: Array, v: Array, t: Array, F: Array) -> Iterable[Array]:
        for q in LEVELS:
            yield np.maximum(F - q, 0.0)
            yield np.minimum(F + q, 0.0)

    return [
        ("a force that depends on position, with short wavelengths", "force", position),
        ("a force that depends on displacement alone", "force", displacement),
        ("a force that depends on speed alone", "force", speed),
        ("a force that depends on displacement and speed together", "force", both),
        ("a hysteretic memory of the displacement", "force", play),
        ("a linear memory of the displacement", "force", memory),
        ("a distortion of the force channel: it depends on the force itself", "sensor", shown),
    ]


def _play(z: Array, g: float) -> Array:
    """Play operator of half width g."""
    out = np.empty_like(z)
    w = z[0]
    for i, x in enumerate(z):
        w = min(max(w, x - g), x + g)
        out[i] = w
    return out
