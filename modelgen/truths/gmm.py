"""A Terfenol-D rod in a coil, pressed against a load: impedance from the constitutive equations themselves.

ε = S σ + d H,  B = d σ + μ H with H = N I / l; the rod is held at one end and drives the load at the other.
Solving the balance of forces and the flux's voltage for I gives Z, with no equivalent circuit. e^{+jωt};
lossy constants have negative imaginary parts; eddy currents multiply μ' by the flux in a solid cylinder
(Bessel functions).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.special import jv

from . import elements as el
from . import once_unforeseen, unforeseen
from .elements import Array, Complex
from .impedance import (
    Scale,
    Sweeps,
    cable_trap,
    capacitor,
    in_order,
    mains_hum,
    suspension,
    viscoelastic,
)
from .solve import Strength

MU0 = 4e-7 * np.pi
Base = Mapping[str, float]


class GmmScene(Sweeps):
    """Sweeps of one magnetostrictive transducer."""

    def __init__(self, base: Base, setup: Mapping[str, Any], levels: Mapping[str, float]) -> None:
        super().__init__(base, setup, levels)
        w0 = np.sqrt((base["A"] / (base["l"] * base["S33_re"]) + base["K_spr"]) / base["M_t"])
        self.scale = Scale(base["M_t"], float(w0), self.top)
        self.flux = [flux(f / base["f_c"]) for f in self.f]

    def _sweep(self, p: Base, i: int, strength: Strength) -> Complex:
        known, set_to = self.sweeps[i]["known"], 2 * np.pi * self.f[i]
        order = in_order(len(set_to), self.sweeps[0]["n"])

        def read(w: Array) -> Complex:
            chi = self.flux[i] if w is set_to else flux(w / (2 * np.pi * self.base["f_c"]))
            return impedance(w, {**p, **known}, strength, self.scale, order, chi)

        return self._set_to(set_to, read, strength)


def flux(ratio: Array) -> Complex:
    """χ(f/f_c): flux in a conducting cylinder over its static value, 2 J1(x)/(x J0(x)), x² = -j f/f_c."""
    x = np.sqrt(-1j * np.asarray(ratio, complex))
    return np.asarray(2 * jv(1, x) / (x * jv(0, x)))


def impedance(w: Array, p: Base, e: Strength, scale: Scale, order: Array, chi: Complex) -> Complex:
    """Z [ohm] at ω [rad/s]; `order`: see `in_order`."""
    top, A, l, N = scale.top, p["A"], p["l"], p["N"]
    S, d = p["S33_re"] + 1j * p["S33_im"], p["d33_re"] + 1j * p["d33_im"]
    mu = _permeability(w, p, e, top, chi)
    # Balance of forces at the driven end: A d H / S = (rod + load) v
    push = A * d * N / (S * l)
    whole = _rod(w, A / (l * S), e, top) + _load(w, p, e, scale)
    motion = push / unforeseen.hopped(whole, w / scale.w0, scale.mass * scale.w0, e)  # v / I
    # Faraday: mean B over the rod, from its mean stress (u/l - d H)/S
    flux_per_amp = A * ((mu - d**2 / S) * N / l + d * motion / (1j * w) / (l * S))
    winding = p["R_0"] * _winding(w, e, top, order)
    Z = winding + 1j * w * N * flux_per_amp
    L = abs(mu[0]) * N**2 * A / l
    if s := e.get("leakage_inductance"):
        Z = Z + s["size"] * 1j * w * L
    if s := e.get("semi_inductance"):
        Z = Z + s["size"] * top * L * el.springpot(w, s["n"], top)
    if s := e.get("eddy_shunt"):
        Z = 1 / (1 / (Z - winding) + s["size"] / (top * L)) + winding  # the inductance alone is shunted
    if s := e.get("coil_capacitance"):
        Z = 1 / (1 / Z + capacitor(w, s, top, top * L))
    if s := e.get("novel:cable_trap"):
        Z = Z + cable_trap(w, s, top, p["R_0"])
    if s := e.get("novel:mains_hum"):
        Z = Z + mains_hum(w, s, p["R_0"])
    Z = once_unforeseen.at_terminals(Z, w, e, top, p["R_0"], order)
    if s := e.get("sensor_delay"):
        Z = Z * np.exp(-1j * w / top * s["size"])
    return np.asarray(Z)


def _permeability(w: Array, p: Base, e: Strength, top: float, chi: Complex) -> Complex:
    """Absolute complex permeability [H/m]."""
    mu = MU0 * (p["mu33_re"] * chi + 1j * p["mu33_im"])
    if s := e.get("permeability_relaxation"):
        mu = mu + s["size"] * MU0 * p["mu33_re"] * el.cole_cole(w, 1 / (top * s["at"]), s["a"])
    return np.asarray(mu)


def _winding(w: Array, e: Strength, top: float, order: Array) -> Complex:
    ratio = np.ones(len(w), complex)
    if s := e.get("coil_ac_resistance"):
        x2 = 1j * w / top * s["size"]
        ratio = el.proximity(x2, s["layers"]) if s["law"] == "proximity" else el.round_wire(x2)
    if s := e.get("temperature_drift"):
        ratio = ratio * (1 + s["size"] * (1 - np.exp(-order / s["tau"])) / (1 - np.exp(-1 / s["tau"])))
    return ratio


def _rod(w: Array, K: complex, e: Strength, top: float) -> Complex:
    """Impedance [N·s/m] of the clamped rod at its driven end; its mass counts only where waves do."""
    if s := e.get("distributed_rod"):
        return suspension(w, K, s, top)
    return np.asarray(K / (1j * w))


def _load(w: Array, p: Base, e: Strength, scale: Scale) -> Complex:
    """Impedance [N·s/m] of what the rod drives: mass, washers, dampers, and what was left out."""
    M, w0 = scale.mass, scale.w0
    spring = viscoelastic(w, p["K_spr"], e, w0)
    Z = 1j * w * p["M_t"] + p["R_d"] + p["R_f"] + spring / (1j * w)
    if s := e.get("inertia"):
        Z = Z + 1j * w * s["size"] * M
    if s := e.get("contact_damping"):
        Z = Z + s["size"] * p["R_d"]
    if s := e.get("second_mode"):
        Z = Z + el.resonator(w, s["size"] * M, s["at"] * w0, s["q"])
    if s := e.get("radiation_load"):
        load = el.sphere if s["law"] == "sphere" else el.piston
        Z = Z + s["size"] * 0.05 * M * w0 * load(w, 1.0, s["at"] * w0)
    if s := e.get("novel:cavity_comb"):
        at = s["at"] * w0 * np.arange(1, 9)
        Z = Z + sum(s["size"] * 0.05 * M * w0 / (1 + 1j * s["q"] * (w / wk - wk / w)) for wk in at)
    Z = Z + M * w0 * unforeseen.on_moving_side(w / w0, e)
    if s := e.get("contact_compliance"):  # right at the rod it would be a part of S: so behind the head mass
        head = s["share"] * M
        joint = (1 - s["share"]) * head * w0**2 / s["size"] * (1 + 0.01j)
        Z = 1j * w * head + 1 / (1 / (Z - 1j * w * head) + 1j * w / joint)
    return np.asarray(Z)
