"""A moving-coil device recorded as impedance sweeps, with or without what its five elements leave out.

Base: Z = R_e + jωL_e + Bl²/(R_m + jωM_m + K_m/(jω)). What was left out is the device's own, the same in each
sweep whatever known mass is added: its figures are relative to `Scale`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import elements as el
from . import once_unforeseen, unforeseen
from .elements import Array, Complex
from .further import entries
from .noise import sweep_whitener, white_sweep
from .solve import NOTHING, Refit, Responses, Strength, refit_sweep

Base = Mapping[str, float]
Form = Mapping[str, Any]


@dataclass(frozen=True)
class Scale:
    """The device without added loads: moving mass [kg], resonance and highest recorded frequency [rad/s]."""

    mass: float
    w0: float
    top: float


class Sweeps(ABC):
    """Sweeps of one device, by the impedance that it has in each: see `Scene`."""

    def __init__(self, base: Base, setup: Mapping[str, Any], levels: Mapping[str, float]) -> None:
        self.base, self.sweeps, self.free = base, entries(setup), list(setup["free"])
        drawn = setup["sweeps"]
        self.f = [frequencies(s) for s in self.sweeps]
        self.fit = [i for i, s in enumerate(drawn) if s["role"] == "fit"]
        self.top = 2 * np.pi * max(f.max() for f in self.f[: len(drawn)])
        self.levels = levels
        self.whiten = sweep_whitener([self.f[i] for i in self.fit], levels)

    def simulate(self, strength: Strength) -> Responses:
        return [self._sweep(self.base, i, strength) for i in range(len(self.f))]

    def refit(self, y: Responses, beside: Strength = NOTHING) -> Refit:
        def base(p: Base) -> Responses:
            return [self._sweep(p, i, beside) for i in self.fit]

        return refit_sweep(base, self.base, self.free, self.whiten, y)

    def white(self, i: int, e: Array, data: Array) -> Array:
        return white_sweep(self.f[i], self.levels, e, data)

    def _set_to(self, w: Array, read: Callable[[Array], Complex], e: Strength) -> Complex:
        """Z [ohm] of a device that `read` tells, as its analyser does when set to ω [rad/s]."""
        return unforeseen.rippled(lambda w: once_unforeseen.pulled(read, w, e), w, e)

    @abstractmethod
    def _sweep(self, p: Base, i: int, strength: Strength) -> Complex:
        """Z [ohm] of sweep i."""


class ImpedanceScene(Sweeps):
    """Sweeps of one moving-coil device."""

    def __init__(self, base: Base, setup: Mapping[str, Any], levels: Mapping[str, float]) -> None:
        super().__init__(base, setup, levels)
        self.scale = Scale(base["M_m"], float(np.sqrt(base["K_m"] / base["M_m"])), self.top)

    def _sweep(self, p: Base, i: int, strength: Strength) -> Complex:
        known, f = self.sweeps[i]["known"], self.f[i]
        order = in_order(len(f), self.sweeps[0]["n"])

        def read(w: Array) -> Complex:
            return impedance(w, {**p, **known}, strength, self.scale, order)

        return self._set_to(2 * np.pi * f, read, strength)


def in_order(n: int, first: int) -> Array:
    """Time of each of n samples since the start of its sweep, over the length of the first sweep. Every
    sample takes as long."""
    return np.asarray(np.arange(n) / max(first - 1, 1))


def frequencies(sweep: Mapping[str, Any]) -> Array:
    """Recorded frequencies [Hz] in the order in which they were measured."""
    space = np.linspace if sweep.get("linear") else np.geomspace
    f = space(sweep["lo"], sweep["hi"], sweep["n"])
    return np.asarray(f[::-1] if sweep.get("down") else f)


def impedance(w: Array, p: Base, e: Strength, scale: Scale, order: Array) -> Complex:
    """Z [ohm] at ω [rad/s] of base parameters p and effects e; `order`: see `in_order`."""
    top = scale.top
    Z = _winding(w, p, e, top, order) + _inductance(w, p, e, top) + p["Bl"] ** 2 / _mechanical(w, p, e, scale)
    if s := e.get("coil_capacitance"):
        Z = 1 / (1 / Z + capacitor(w, s, top, p["R_e"] + top * p["L_e"]))
    if s := e.get("novel:cable_trap"):
        Z = Z + cable_trap(w, s, top, p["R_e"])
    if s := e.get("novel:mains_hum"):
        Z = Z + mains_hum(w, s, p["R_e"])
    Z = once_unforeseen.at_terminals(Z, w, e, top, p["R_e"], order)
    if s := e.get("sensor_delay"):
        Z = Z * np.exp(-1j * w / top * s["size"])
    return Z


def capacitor(w: Array, s: Form, top: float, z_top: float) -> Complex:
    """Admittance of a winding's capacitance; a lossy one has a loss angle and a lead resistance."""
    y = 1j * w / top * s["size"] / z_top
    if s["law"] == "lossy_capacitor":
        y = y * (1 - 1j * s["tan_delta"])
        y = y / (1 + y * s["lead"] * z_top)
    return np.asarray(y)


def cable_trap(w: Array, s: Form, top: float, z: float) -> Complex:
    """A narrow parallel resonance in series with the cable."""
    wt = top * s["at"]
    return np.asarray(s["size"] * z / (1 + 1j * s["q"] * (w / wt - wt / w)))


def mains_hum(w: Array, s: Form, z: float) -> Complex:
    """What 50 Hz and its odd harmonics leave in an analyser of finite bandwidth."""
    hum = np.zeros(len(w), complex)
    for n in range(1, 40, 2):
        away = (w / (2 * np.pi) - 50 * n) / s["bandwidth"]
        hum += np.sinc(away) * np.exp(1j * (s["phase"] + n)) / n
    return hum * s["size"] * z


def _winding(w: Array, p: Base, e: Strength, top: float, order: Array) -> Complex:
    ratio = np.ones(len(w), complex)
    if s := e.get("coil_ac_resistance"):
        x2 = 1j * w / top * s["size"]
        wound = el.proximity(x2, s["layers"]) if s["law"] == "proximity" else el.round_wire(x2)
        ratio = ratio * wound
    if s := e.get("temperature_drift"):
        heat = (1 - np.exp(-order / s["tau"])) / (1 - np.exp(-1 / s["tau"]))
        ratio = ratio * (1 + s["size"] * heat)
    return np.asarray(p["R_e"] * ratio)


def _inductance(w: Array, p: Base, e: Strength, top: float) -> Complex:
    L = p["L_e"]
    Z = np.asarray(1j * w * L)
    if s := e.get("eddy_shunt"):
        if s["law"] == "shorted_turn":
            Z = el.shorted_turn(w, L, s["size"], top * s["at"])
        elif s["law"] == "two_cell_ladder":
            cells = (el.shorted_turn(w, L, 1.0, top * s["at"] * r) for r in (1, s["ratio"]))
            Z = Z + s["size"] * sum(cells)
        else:
            Z = el.shorted_turn(w, L, 1.0, top / s["size"])
    if s := e.get("semi_inductance"):
        if s["law"] == "solid_core":
            Z = Z + s["size"] * 1j * w * L * el.solid_core(1j * w / (top * s["at"]))
        else:
            Z = Z + s["size"] * top * L * el.springpot(w, s["n"], top)
    if s := e.get("permeability_relaxation"):
        Z = Z + s["size"] * 1j * w * L * el.cole_cole(w, 1 / (top * s["at"]), s["a"])
    if s := e.get("leakage_inductance"):
        Z = Z + s["size"] * 1j * w * L
    return Z


def _mechanical(w: Array, p: Base, e: Strength, scale: Scale) -> Complex:
    """Mechanical impedance [N·s/m] that the coil's force acts on."""
    R, K, M, w0 = p["R_m"], p["K_m"], scale.mass, scale.w0
    spring, moving = viscoelastic(w, K, e, w0), mass(w, p["M_m"], e, scale)
    if (s := e.get("distributed_rod")) and s["law"] != "moving_rod":
        spring = spring - K + 1j * w * suspension(w, K, s, scale.top)
    Z = R * np.ones(len(w)) + spring / (1j * w) + moving
    if s := e.get("contact_damping"):
        Z = Z + s["size"] * R
    if s := e.get("second_mode"):
        Z = Z + el.resonator(w, s["size"] * M, s["at"] * w0, s["q"])
    if s := e.get("radiation_load"):
        load = el.sphere if s["law"] == "sphere" else el.piston
        Z = Z + s["size"] * M * w0 * load(w, 1.0, s["at"] * w0)
    if s := e.get("novel:cavity_comb"):
        Z = Z + sum(
            s["size"] * M * w0 / (1 + 1j * s["q"] * (w / wk - wk / w))
            for wk in s["at"] * w0 * np.arange(1, 9)
        )
    Z = Z + M * w0 * unforeseen.on_moving_side(w / w0, e)
    if s := e.get("contact_compliance"):
        coil = s["share"] * M  # the coil's own mass, before the joint
        joint = (1 - s["share"]) * coil * w0**2 / s["size"] * (1 + 0.02j)
        Z = 1j * w * coil + 1 / (1 / (Z - 1j * w * coil) + 1j * w / joint)
    if "cubic_stiffness" in e or "quadratic_damping" in e:
        Z = _at_amplitude(w, Z, p, e, w0)
    return unforeseen.hopped(np.asarray(Z), w / w0, M * w0, e)


def suspension(w: Array, K: complex, s: Form, top: float) -> Complex:
    """Impedance [N·s/m] of a spring with waves in it, far end held; size is kl at the top frequency."""
    loss = 1 - 1j * s["eta"] if s["law"] == "lossy_rod" else 1.0  # of the waves alone
    return el.rod_clamped(w, K, K.real * loss * (s["size"] / top) ** 2)


def viscoelastic(w: Array, K: float, e: Strength, w0: float) -> Complex:
    """Complex stiffness of a spring K with what its material adds."""
    k = np.full(len(w), K, complex)
    if s := e.get("structural_damping"):
        k = k + 1j * s["size"] * K
    if s := e.get("power_law_viscoelasticity"):
        if s["law"] == "log_creep":  # compliance rises with the logarithm of time
            k = k / (1 - s["size"] * np.log(1j * w / w0) / np.log(10))
        elif s["law"] == "stretched_exponential":
            k = k + s["size"] * K * stretched(w / w0 / s["at"], s["alpha"])
        else:
            k = k + s["size"] * K * el.springpot(w, s["alpha"], w0)
    if s := e.get("maxwell_branch"):
        x = 1j * w / (s["at"] * w0)
        k = k + s["size"] * K * x / (1 + x)
    return k


def stretched(x: Array, beta: float) -> Complex:
    """jx∫exp(-t^β) e^{-jxt} dt, the modulus of a stretched-exponential relaxation, on a ray without swings.

    t = -jy turns the integral into ∫exp(-(-jy)^β - xy) dy; the branch is the one that decays for β < 1.
    """
    y = np.exp(np.arange(-45, 12, 0.02))
    kernel = np.exp(-((-1j) ** beta) * y**beta) * y * 0.02
    return np.asarray([xi * (kernel * np.exp(-xi * y)).sum() for xi in x])


def mass(w: Array, M: float, e: Strength, scale: Scale) -> Complex:
    """Impedance of the moving mass, part of which may be a rod that waves travel in."""
    z = np.asarray(1j * w * M)
    if (s := e.get("distributed_rod")) and s["law"] == "moving_rod":
        rod = s["share"] * scale.mass
        z = z - 1j * w * rod + el.rod_free(w, rod * (scale.top / s["size"]) ** 2, rod)
    if s := e.get("inertia"):
        z = z + 1j * w * s["size"] * scale.mass
    return z


def _at_amplitude(w: Array, Z: Complex, p: Base, e: Strength, w0: float) -> Complex:
    """First-harmonic impedance under constant current, the amplitude (1 at resonance) found by bisection."""
    theta = 2 * np.pi * np.arange(32) / 32
    cubic = 2 * float(np.mean(np.cos(theta) ** 4))
    square = 2 * float(np.mean(np.abs(np.sin(theta)) * np.sin(theta) ** 2))
    k3 = e.get("cubic_stiffness", {"size": 0.0})["size"] * p["K_m"] * cubic
    r2 = e.get("quadratic_damping", {"size": 0.0})["size"] * p["R_m"] * square

    def at(a: Array) -> Complex:
        return np.asarray(Z + k3 * a**2 / (1j * w) + r2 * a * w / w0)

    lo, hi = np.zeros(len(w)), np.full(len(w), 1e3)
    for _ in range(60):
        a = 0.5 * (lo + hi)
        over = a * w * np.abs(at(a)) > p["R_m"] * w0
        lo, hi = np.where(over, lo, a), np.where(over, a, hi)
    return at(0.5 * (lo + hi))
