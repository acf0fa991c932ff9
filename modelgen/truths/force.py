"""A magnetorheological sample between a shaker and a load cell: force against displacement, on a fine grid.

Base: F = k z + c ż + h r + F_0 with Dahl's r. Effects change the path that the sample sees (lost motion, a
soft joint), the coefficients, the forces, and the channel that records them. Units mm, s, N.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from . import friction, memory, once_unforeseen, unforeseen
from .drive import Array, Motion
from .further import entries
from .solve import NOTHING, Refit, Responses, Strength

W1 = 2 * np.pi  # reference angular frequency of the memory effects, 1 Hz


@dataclass(frozen=True)
class Path:
    """What the sample undergoes: position with its reversals; x, v, a on the grid."""

    t: Array  # since the start of the record, negative before it
    dt: float
    points: Array
    keep: npt.NDArray[np.intp]
    x: Array
    v: Array
    a: Array


class ForceScene:
    """Records of one sample: see `Scene`."""

    def __init__(
        self, base: Mapping[str, float], setup: Mapping[str, Any], levels: Mapping[str, float]
    ) -> None:
        from .force_refit import Columns

        self.base, self.records = base, entries(setup)
        self.motions = [Motion(r["motion"], r["rate"], r["seconds"], r["pre"]) for r in self.records]
        drawn = self.motions[: len(setup["records"])]  # what effects are relative to
        self.reach = max(float(np.abs(m.zva[0]).max()) for m in drawn)
        self.speed = max(float(np.abs(m.zva[1]).max()) for m in drawn)
        fit = [m for m, r in zip(drawn, setup["records"], strict=True) if r["role"] == "fit"]
        self.columns = Columns(base, fit, levels, own_offset="F_0" in setup["per_recording"])

    def simulate(self, strength: Strength) -> Responses:
        return [m.recorded(self._force(m, strength)) for m in self.motions]

    @cached_property
    def plain(self) -> Responses:
        return self.simulate({})

    def refit(self, y: Responses, beside: Strength = NOTHING) -> Refit:
        """See `Scene`. What the effects beside bring is taken at the true base: all but a soft joint and
        softening bring a force of their own."""
        if beside:
            brought = zip(y, self.simulate(beside), self.plain, strict=True)
            y = [a - (b - c) for a, b, c in brought]
        return self.columns.refit(y)

    def white(self, i: int, e: Array, data: Array) -> Array:
        return np.array([self.columns.white(self.motions[i].rate, x) for x in e])

    def _force(self, m: Motion, e: Strength) -> Array:
        """Force [N] on the fine grid of one motion, as its channel shows it."""
        z, v, a = m.zva
        t, dt, points = m.t - m.pre, 1 / m.dense, m.path
        moving = np.ones(len(z))
        if s := e.get("backlash"):
            points, moving = lost_motion(m, s, self.reach)
        p = Path(t, dt, points, m.keep, points[m.keep], v * moving, a * moving)
        if s := e.get("contact_compliance"):
            p = self._behind_joint(p, e, self.base["k_D"] / s["size"])
        return channel(t, dt, self._forces(p, e), e, self._scale())

    def _scale(self) -> float:
        return self.base["k_D"] * self.reach

    def _forces(self, p: Path, e: Strength) -> Array:
        b = self.base
        k = b["k_D"] * softening(p, e, self.reach)
        F = k * p.x + b["c_D"] * p.v + b["F_0"] + b["h_D"] * self._friction(p, e)
        F = F + self._elastic(p, e) + self._viscous(p, e) + self._material(p, e)
        return F + self._scale() * unforeseen.force(p.x / self.reach, p.v / self.speed, p.dt, e)

    def _friction(self, p: Path, e: Strength) -> Array:
        """Friction over h_D."""
        rho = self.base["rho"]
        relaxing = e.get("maxwell_branch", {"law": ""})
        if relaxing["law"] == "relaxing_friction":
            r = friction.rate_dahl(p.v, p.dt, rho, np.ones(len(p.v)), relaxing["size"] / relaxing["tau"])
        elif s := e.get("stribeck_friction"):
            fast = np.abs(p.v) / (s["at"] * self.speed)
            level = 1 + s["size"] * np.exp(-(fast**2 if s["law"] == "gaussian" else fast))
            r = friction.rate_dahl(p.v, p.dt, rho, level, 0.0)
        elif s := e.get("dahl_exponent"):
            r = friction.dahl_power(p.points, rho, float(np.exp(s["sign"] * s["size"])))[p.keep]
        else:
            r = friction.dahl(p.points, rho)[p.keep]
        if s := e.get("second_dahl_element"):
            r = r + s["size"] * friction.dahl(p.points, rho * s["ratio"])[p.keep]
        return r

    def _elastic(self, p: Path, e: Strength) -> Array:
        """Forces that depend on position alone."""
        F, x = np.zeros(len(p.x)), p.x / self.reach
        if s := e.get("cubic_stiffness"):
            F += s["size"] * x**3
        if s := e.get("asymmetric_stiffness"):
            F += s["size"] * (np.maximum(x, 0) if s["law"] == "bilinear" else x**2)
        if s := e.get("end_stop"):
            F += s["side"] * s["size"] * np.maximum(s["side"] * x - s["at"], 0) ** s["power"]
        if s := e.get("magnetic_pull"):
            F -= np.sign(s["gap"]) * s["size"] * (1 / (1 - x / s["gap"]) ** 2 - 1)
        if s := e.get("novel:position_periodic"):
            F += s["size"] * np.sin(2 * np.pi * p.x / s["pitch"] + s["phase"])
        return F * self._scale()

    def _viscous(self, p: Path, e: Strength) -> Array:
        """Forces that depend on velocity and acceleration."""
        F = np.zeros(len(p.x))
        if s := e.get("contact_damping"):
            F += s["size"] * self.base["c_D"] * p.v
        if s := e.get("quadratic_damping"):
            F += s["size"] * self.base["c_D"] * p.v * np.abs(p.v) / self.speed
        mass = self.base["k_D"] / (10 * W1) ** 2  # in N·s²/mm, resonant with the sample at 10 Hz
        if s := e.get("inertia"):
            F += s["size"] * mass * p.a
        if s := e.get("second_mode"):
            F += s["size"] * mass * memory.appendage(p.a, p.dt, W1 * s["at"], s["q"])
        return F

    def _material(self, p: Path, e: Strength) -> Array:
        """Forces with a memory of the path in time."""
        F = np.zeros(len(p.x))
        if s := e.get("structural_damping"):
            F += s["size"] * memory.hysteretic(p.x)
        if s := e.get("power_law_viscoelasticity"):
            if s["law"] == "stretched_exponential":
                F += s["size"] * memory.relaxing(p.x, p.dt, s["tau"], s["alpha"])
            else:
                F += s["size"] * memory.fractional(p.x, p.dt, s["alpha"]) / W1 ** s["alpha"]
        if (s := e.get("maxwell_branch")) and s["law"] != "relaxing_friction":
            F += s["size"] * memory.relaxing(p.x, p.dt, s["tau"], 1.0)
        return F * self.base["k_D"]

    def _behind_joint(self, p: Path, e: Strength, joint: float) -> Path:
        """The path behind a spring `joint` [N/mm]: its linear part exact, the rest by iteration."""
        b = self.base
        stiff = joint + b["k_D"]
        x = p.x
        for _ in range(12):
            v = np.gradient(x, p.dt)
            inner = Path(p.t, p.dt, x, np.arange(len(x)), x, v, np.gradient(v, p.dt))
            rest = self._forces(inner, e) - b["k_D"] * x - b["c_D"] * v
            new = memory.low_pass((joint * p.x - rest) / stiff, p.dt, b["c_D"] / stiff)
            done = np.abs(new - x).max() < 1e-9 * self.reach
            x = new
            if done:
                break
        v = np.gradient(x, p.dt)
        return Path(p.t, p.dt, x, np.arange(len(x)), x, v, np.gradient(v, p.dt))


def lost_motion(m: Motion, s: Mapping[str, Any], reach: float) -> tuple[Array, Array]:
    """Path behind a backlash, with the share of the velocity that gets through."""
    width = s["size"] * reach
    if s["law"] == "dead_zone":  # of spring and friction; the dashpot is driven all the same
        return m.path - np.clip(m.path, -width / 2, width / 2), np.ones(len(m.t))
    if s["law"] == "elastic_play":
        return friction.play(m.path, width), np.ones(len(m.t))
    if s["law"] == "smoothed_backlash":
        points = friction.soft_play(m.path, width, 0.8)
    else:
        points = friction.play(m.path, width)
    step = np.diff(points[m.keep], prepend=points[0])
    full = np.diff(m.zva[0], prepend=m.zva[0][0])
    return points, np.clip(np.divide(step, full, out=np.zeros_like(step), where=full != 0), 0, 1)


def softening(p: Path, e: Strength, reach: float) -> Array:
    """Stiffness over its virgin value."""
    k = np.ones(len(p.x))
    if s := e.get("payne_softening"):
        if s["law"] == "half_swing":
            edge = friction.branches(p.x)
            half = np.repeat(0.5 * np.abs(np.diff(p.x[edge])), np.diff(edge))
            amp = memory.low_pass(np.concatenate([half[:1], half]), p.dt, s["smooth"])
        else:
            amp = memory.envelope(p.x, p.dt, s["smooth"])
        k *= 1 - s["size"] * (1 - 1 / (1 + (amp / (s["at"] * reach)) ** 2))  # Kraus
    if s := e.get("stress_softening"):
        if s["law"] == "peak":
            worn = np.maximum.accumulate(np.abs(p.x)) / reach
        else:
            worn = friction.travelled(p.x) / (s["at"] * reach)
        k *= 1 - s["size"] * -np.expm1(-worn)
    if s := e.get("temperature_drift"):
        k *= 1 - s["size"] * -np.expm1(-np.clip(p.t, 0, None) / s["tau"])
    return k * once_unforeseen.stiffness(p.t, e)


def channel(t: Array, dt: float, F: Array, e: Strength, scale: float) -> Array:
    """The force as it is recorded."""
    if s := e.get("offset_drift"):
        F = F + s["size"] * scale * wander(t, s)
    if s := e.get("force_sensor_lag"):
        F = memory.low_pass(F, dt, s["size"])
    if s := e.get("sensor_delay"):
        F = CubicSpline(t, F)(np.maximum(t - s["size"], t[0]))
    if s := e.get("novel:clipped_sensor"):
        F = np.minimum(F, (1 - s["size"]) * F.max())
    F = unforeseen.detected(t, F * once_unforeseen.gain(t, e), e)
    if s := e.get("novel:mains_hum"):
        F = F + s["size"] * scale * sum(
            np.sin(2 * np.pi * 50 * n * t + n * s["phase"]) * s["fall"] ** (n - 1) for n in (1, 2, 3)
        )
    return F


def wander(t: Array, s: Mapping[str, Any]) -> Array:
    """A slow change of the zero: steady, or two slow waves that no straight line follows."""
    x = np.clip(t, 0, None) / s["tau"]
    if s["law"] == "wandering":
        return np.asarray(np.sin(2.1 * x + s["phase"]) - np.sin(s["phase"]) + 0.5 * np.sin(4.7 * x))
    return x
