"""Displacements that a sample is driven with, as formulas of time, so that they are exact on any grid.

z [mm] and its first two derivatives follow from a phase φ(t) and an envelope, or from a sum of sines. A
record either starts at rest (the envelope rises from zero) or in the middle of a motion that has run for
`pre` seconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def _rise(t: Array, length: float) -> tuple[Array, Array, Array]:
    """A smooth rise from 0 to 1 over `length` with two continuous derivatives: 10x³ - 15x⁴ + 6x⁵."""
    x = np.clip(t / length, 0, 1)
    return (
        x**3 * (10 - 15 * x + 6 * x**2),
        30 * x**2 * (1 - x) ** 2 / length,
        60 * x * (1 - x) * (1 - 2 * x) / length**2,
    )


def _steps(t: Array, spec: Mapping[str, Any]) -> tuple[Array, Array, Array]:
    """Phase, its rate and its acceleration for frequencies held for some cycles, with smooth passages."""
    f = np.asarray(spec["steps"], float)
    edge = np.cumsum(spec["cycles"] / f)
    passage = 0.5 / f[1:]
    phase, rate, accel = 2 * np.pi * f[0] * t, np.full(len(t), 2 * np.pi * f[0]), np.zeros(len(t))
    for jump, at, length in zip(2 * np.pi * np.diff(f), edge[:-1], passage, strict=True):
        x = np.clip((t - at) / length, 0, 1)
        share = length * (2.5 * x**4 - 3 * x**5 + x**6) + np.clip(
            t - at - length, 0, None
        )  # integral of the rise
        up, slope, _ = _rise(t - at, length)
        phase, rate, accel = phase + jump * share, rate + jump * up, accel + jump * slope
    return phase, rate, accel


def displacement(t: Array, spec: Mapping[str, Any]) -> tuple[Array, Array, Array]:
    """z [mm], ż [mm/s], z̈ [mm/s²] at times t >= 0 [s] since the start of the motion.

    A motion may go about a "mean" [mm], and back and forth again after "fold" [s].
    """
    back = np.ones_like(t)
    if once := spec.get("fold"):
        back = np.where((t > once) & (t < 2 * once), -1.0, 1.0)
        t = np.where(t <= once, t, np.where(back < 0, 2 * once - t, t - 2 * once))
    z, v, a = _hold(t, spec) if spec["type"] == "hold" else _driven(t, spec)
    return z + spec.get("mean", 0.0), v * back, a


def _hold(t: Array, spec: Mapping[str, Any]) -> tuple[Array, Array, Array]:
    """From one end to the other along half a cosine, and held there."""
    w = np.pi / spec["rise"]
    angle = np.clip(w * (t - spec["start"]), 0, np.pi)
    moving = (angle > 0) & (angle < np.pi)
    amp = spec["amplitude"]
    return -amp * np.cos(angle), amp * w * np.sin(angle) * moving, amp * w**2 * np.cos(angle) * moving


def _driven(t: Array, spec: Mapping[str, Any]) -> tuple[Array, Array, Array]:
    """About zero, starting from rest."""
    if spec["type"] == "random":
        lines = 2 * np.pi * np.asarray(spec["lines"])
        angle = t[:, None] * lines + np.asarray(spec["phases"])
        s, v, a = np.sin(angle).sum(1), (np.cos(angle) * lines).sum(1), (-np.sin(angle) * lines**2).sum(1)
        first = float(lines[0]) / (2 * np.pi)
    else:
        if spec["type"] == "sweep":
            c = np.log(spec["to"] / spec["from"]) / spec["seconds"]
            rate = 2 * np.pi * spec["from"] * np.exp(c * np.clip(t, 0, spec["seconds"]))
            phase, accel = (rate - 2 * np.pi * spec["from"]) / c, c * rate
        else:
            phase, rate, accel = _steps(t, spec)
        s, v, a = np.sin(phase), np.cos(phase) * rate, np.cos(phase) * accel - np.sin(phase) * rate**2
        first = spec.get("from", spec.get("steps", [1.0])[0])
    e, de, dde = _rise(t, 0.5 / first)
    amp = spec["amplitude"]
    return amp * s * e, amp * (v * e + s * de), amp * (a * e + 2 * v * de + s * dde)


@dataclass(frozen=True)
class Motion:
    """One record's displacement on a fine grid, with the instants of reversal put in.

    `spec` gives the motion, `rate` [Hz] is the record's, the grid is `over` times finer and begins `pre`
    seconds earlier.
    """

    spec: Mapping[str, Any]
    rate: float
    seconds: float
    pre: float
    over: int = 8

    @cached_property
    def t(self) -> Array:
        """Fine times since the start of the motion, (n,)."""
        return np.asarray(np.arange(round((self.pre + self.seconds) * self.rate) * self.over) / self.dense)

    @property
    def dense(self) -> float:
        """Fine sampling rate [Hz]."""
        return self.rate * self.over

    @cached_property
    def start(self) -> int:
        """Index of the first recorded instant in the fine grid."""
        return round(self.pre * self.rate) * self.over

    @cached_property
    def zva(self) -> tuple[Array, Array, Array]:
        return displacement(self.t, self.spec)

    @cached_property
    def _path(self) -> tuple[Array, npt.NDArray[np.intp]]:
        """z on the fine grid with its extrema inserted, and the places of the grid in it."""
        z, v, _ = self.zva
        turn = np.flatnonzero(np.sign(v[:-1]) * np.sign(v[1:]) < 0)
        a, b, va = self.t[turn], self.t[turn + 1], v[turn]
        for _ in range(30):
            m = 0.5 * (a + b)
            same = np.sign(displacement(m, self.spec)[1]) == np.sign(va)
            a, b = np.where(same, m, a), np.where(same, b, m)
        keep = np.arange(len(z)) + np.searchsorted(turn, np.arange(len(z)))
        return np.insert(z, turn + 1, displacement(0.5 * (a + b), self.spec)[0]), keep

    @property
    def path(self) -> Array:
        return self._path[0]

    @property
    def keep(self) -> npt.NDArray[np.intp]:
        return self._path[1]

    def recorded(self, x: Array) -> Array:
        """The samples of a fine signal that are recorded."""
        return np.asarray(x[self.start :: self.over])
