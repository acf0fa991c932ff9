"""A sample's complex stiffness against frequency at given amplitudes, from one steady cycle followed in time.

The cycle's force is built point by point (friction by Dahl's closed form over the two strokes, nonlinear
springs and dampers by their laws), and its first harmonic over that of the displacement is K* = k_s e^{jδ}.
Linear memory is added to K* in frequency. Units N/mm, mm, deg.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from . import elements as el
from . import friction
from .elements import Array, Complex
from .force_draw import draw_form as force_form
from .impedance import stretched
from .noise import Levels
from .solve import Refit, Responses, Strength, refit_sweep

Rng = np.random.Generator
POINTS, CYCLES = 512, 8
W1 = 2 * np.pi

SIZES: dict[str, tuple[float, float]] = {
    "structural_damping": (0.05, 2.0),
    "power_law_viscoelasticity": (0.05, 4.0),
    "maxwell_branch": (0.1, 4.0),
    "payne_softening": (0.05, 0.9),
    "quadratic_damping": (0.02, 5.0),
    "inertia": (0.02, 2.0),
    "second_dahl_element": (0.1, 4.0),
    "dahl_exponent": (0.2, 1.1),
    "cubic_stiffness": (0.02, 3.0),
    "temperature_drift": (0.01, 0.5),
    "sensor_delay": (5e-4, 0.02),
    "force_sensor_lag": (5e-4, 0.02),
    "contact_compliance": (0.01, 1.0),
    "second_mode": (0.01, 0.5),
    "novel:mount_modes": (0.01, 0.5),
}
VARIANTS = {"stretched_exponential": "power_law_viscoelasticity"}


class StiffnessScene:
    """Sweeps at one amplitude each: see `Scene`. A response is (2, n): k_s [N/mm], loss angle [deg]."""

    def __init__(self, base: Mapping[str, float], setup: Mapping[str, Any], levels: Levels) -> None:
        self.base, self.sweeps, self.free = base, setup["sweeps"], list(setup["free"])
        self.f = [np.geomspace(s["lo"], s["hi"], s["n"]) for s in self.sweeps]
        self.fit = [i for i, s in enumerate(self.sweeps) if s["role"] == "fit"]
        self.sigma = np.array([[levels["k_s"]], [levels["loss_angle"]]]) * np.sqrt(
            1 + levels.get("step", 0.0) ** 2 / 12
        )
        self.rho_ar = levels.get("rho", 0.0)

    @cached_property
    def reach(self) -> float:
        return max(float(s["known"]["A_z"]) for s in self.sweeps)

    def simulate(self, strength: Strength) -> Responses:
        return [self._sweep(self.base, i, strength) for i in range(len(self.f))]

    def refit(self, y: Responses, extra: Sequence[Responses] = ()) -> Refit:
        def base(p: Mapping[str, float]) -> Responses:
            return [self._sweep(p, i, {}) for i in self.fit]

        return refit_sweep(base, self.base, self.free, self._whiten, y, extra)

    def _whiten(self, y: Responses, base: Responses) -> Array:
        n, rho = len(self.fit), self.rho_ar
        e = [(a - b) / self.sigma for a, b in zip(y[:n], base[:n], strict=True)]
        if rho:
            root = np.sqrt(1 - rho**2)
            e = [np.hstack([x[:, :1], (x[:, 1:] - rho * x[:, :-1]) / root]) for x in e]
        return np.concatenate([x.ravel() for x in e])

    def _sweep(self, p: Mapping[str, float], i: int, e: Strength) -> Array:
        K = complex_stiffness(2 * np.pi * self.f[i], p, e, float(self.sweeps[i]["known"]["A_z"]), self.reach)
        return np.array([np.abs(K), np.degrees(np.angle(K))])


def complex_stiffness(w: Array, p: Mapping[str, float], e: Strength, A: float, reach: float) -> Complex:
    """K* [N/mm] at ω [rad/s] and displacement amplitude A [mm]."""
    k = p["k_D"] + 0j
    if s := e.get("payne_softening"):
        k = k * (1 - s["size"] * (1 - 1 / (1 + (A / (s["at"] * reach)) ** 2)))
    K = k + 1j * w * p["c_D"] + _cycle(p, e, A, reach)
    K = K + p["k_D"] * _memory(w, e)
    if s := e.get("quadratic_damping"):
        theta = 2 * np.pi * np.arange(POINTS) / POINTS
        square = 2 * float(np.mean(np.abs(np.sin(theta)) * np.sin(theta) ** 2))
        K = K + 1j * w * p["c_D"] * s["size"] * square * w * A / (W1 * 10 * reach)
    mass = p["k_D"] / (10 * W1) ** 2
    if s := e.get("inertia"):
        K = K - s["size"] * mass * w**2
    if s := e.get("second_mode"):
        K = K + 1j * w * el.resonator(w, s["size"] * mass, s["at"] * W1, s["q"])
    if s := e.get("novel:mount_modes"):
        K = K + 1j * w * sum(
            el.resonator(w, s["size"] * mass / n, s["at"] * n * W1, s["q"]) for n in (1, 2, 3, 4, 5)
        )
    if s := e.get("temperature_drift"):
        K = K * (1 - s["size"] * -np.expm1(-np.linspace(0, 1, len(w)) / s["tau"]))
    return _measured(w, np.asarray(K), p["k_D"], e)


def _cycle(p: Mapping[str, float], e: Strength, A: float, reach: float) -> complex:
    """First harmonic over A of friction and nonlinear springs, from the last of some cycles -A cos θ."""
    theta = 2 * np.pi * np.arange(CYCLES * POINTS + 1) / POINTS
    x = -A * np.cos(theta)
    steady = -float(np.tanh(p["rho"] * A))  # at the lower reversal, from symmetry
    if s := e.get("dahl_exponent"):
        r = friction.dahl_power(x, p["rho"], float(np.exp(s["sign"] * s["size"])), steady)
    else:
        r = friction.dahl(x, p["rho"], steady)
    if s := e.get("second_dahl_element"):
        rho = p["rho"] * s["ratio"]
        r = r + s["size"] * friction.dahl(x, rho, -np.tanh(rho * A))
    F = p["h_D"] * r
    if s := e.get("cubic_stiffness"):
        F = F + s["size"] * p["k_D"] * x**3 / reach**2
    last = F[-POINTS - 1 : -1]
    harmonic = np.exp(-1j * theta[:POINTS])
    return complex((last @ harmonic) / (x[:POINTS] @ harmonic))


def _memory(w: Array, e: Strength) -> Complex:
    """Stiffness over k_D that linear memory adds."""
    K = np.zeros(len(w), complex)
    if s := e.get("structural_damping"):
        K += 1j * s["size"]
    if s := e.get("power_law_viscoelasticity"):
        if s["law"] == "stretched_exponential":
            K += s["size"] * stretched(w * s["tau"], s["alpha"])
        else:
            K += s["size"] * el.springpot(w, s["alpha"], W1)
    if s := e.get("maxwell_branch"):
        K += s["size"] * 1j * w * s["tau"] / (1 + 1j * w * s["tau"])
    return K


def _measured(w: Array, K: Complex, k: float, e: Strength) -> Complex:
    if s := e.get("contact_compliance"):
        K = 1 / (1 / K + s["size"] / k)
    if s := e.get("force_sensor_lag"):
        K = K / (1 + 1j * w * s["size"])
    if s := e.get("sensor_delay"):
        K = K * np.exp(-1j * w * s["size"])
    return K


def draw_setup(rng: Rng, base: Mapping[str, float], effects: Sequence[str]) -> dict[str, Any]:
    """Two or three amplitudes to fit, 1-30 Hz or 0.1-30 Hz, and one in between held out."""
    amplitudes = [0.4, 0.8] if rng.random() < 0.5 else [0.2, 0.6, 2.0]
    roles = ["fit"] * len(amplitudes) + ["holdout"]
    lo, n = float(rng.choice([0.1, 0.3])), int(rng.integers(25, 61))
    sweeps = [
        {"lo": lo, "hi": 30.0, "n": n, "role": role, "known": {"A_z": A}}
        for A, role in zip([*amplitudes, 0.5], roles, strict=True)
    ]
    return {"sweeps": sweeps, "constants": {}, "free": ["k_D", "c_D", "h_D", "rho"]}


def draw_form(
    rng: Rng, effect: str, law: str, base: Mapping[str, float], setup: Mapping[str, Any]
) -> dict[str, Any]:
    """The parameters of one effect; "at" is relative to the largest amplitude, or in Hz for a mode."""
    if effect == "novel:mount_modes":
        return {
            "size": SIZES[effect][0],
            "law": law,
            "at": float(rng.uniform(3, 6)),
            "q": float(rng.uniform(8, 20)),
        }
    form = force_form(rng, effect, law, dict(base), dict(setup)) | {"size": SIZES[effect][0]}
    if effect == "temperature_drift":
        form["tau"] = float(rng.uniform(0.3, 1.5))  # of the time that a sweep takes
    return form
