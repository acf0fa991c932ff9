"""A sample's stiffness and loss angle against frequency at given amplitudes, from a steady cycle in time.

The cycle's force is built point by point: friction by Dahl's closed form over the strokes, nonlinear springs
and dampers by their laws, linear memory as a complex stiffness. As in the MRE paper, k_s is the greatest
force over the amplitude (eq. 4), and the loss angle asin(h_s/A_F), with h_s the force at z = 0 (eq. 6).
Units N/mm, mm, deg.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from . import elements as el
from . import friction, novel, unforeseen
from .elements import Array, Complex
from .force_draw import draw_form as force_form
from .further import entries
from .impedance import frequencies, in_order, stretched
from .noise import Levels
from .solve import NOTHING, Refit, Responses, Strength, refit_sweep

Rng = np.random.Generator
POINTS, CYCLES = 512, 8
THETA = 2 * np.pi * np.arange(POINTS) / POINTS
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
    **novel.STIFFNESS,
}
VARIANTS = {"stretched_exponential": "power_law_viscoelasticity"}


class StiffnessScene:
    """Sweeps at one amplitude each: see `Scene`. A response is (2, n): k_s [N/mm], loss angle [deg]."""

    def __init__(self, base: Mapping[str, float], setup: Mapping[str, Any], levels: Levels) -> None:
        self.base, self.sweeps, self.free = base, entries(setup), list(setup["free"])
        self.drawn = setup["sweeps"]
        self.f = [frequencies(s) for s in self.sweeps]
        self.fit = [i for i, s in enumerate(self.drawn) if s["role"] == "fit"]
        self.sigma = np.array([[levels["k_s"]], [levels["loss_angle"]]]) * np.sqrt(
            1 + levels.get("step", 0.0) ** 2 / 12
        )
        self.rho_ar = levels.get("rho", 0.0)

    @cached_property
    def reach(self) -> float:
        return max(float(s["known"]["A_z"]) for s in self.drawn)

    def simulate(self, strength: Strength) -> Responses:
        return [self._sweep(self.base, i, strength) for i in range(len(self.f))]

    def refit(self, y: Responses, beside: Strength = NOTHING) -> Refit:
        def base(p: Mapping[str, float]) -> Responses:
            return [self._sweep(p, i, beside) for i in self.fit]

        return refit_sweep(base, self.base, self.free, self._whiten, y)

    def _whiten(self, y: Responses, base: Responses) -> Array:
        pairs = zip(self.fit, y, base, strict=False)
        return np.concatenate([self.white(i, a - b, a).ravel() for i, a, b in pairs])

    def white(self, i: int, e: Array, data: Array) -> Array:
        x, rho = e / self.sigma, self.rho_ar
        return np.hstack([x[:, :1], (x[:, 1:] - rho * x[:, :-1]) / np.sqrt(1 - rho**2)])

    def _sweep(self, p: Mapping[str, float], i: int, e: Strength) -> Array:
        A = float(self.sweeps[i]["known"]["A_z"])
        first = len(self.f[0])
        return measured(steady_cycle(2 * np.pi * self.f[i], p, e, A, self.reach, first), A)


def steady_cycle(
    w: Array, p: Mapping[str, float], e: Strength, A: float, reach: float, first: int | None = None
) -> Array:
    """Force [N] over one cycle of z = -A cos θ, shape (n, POINTS), at ω [rad/s], shape (n,)."""
    when = in_order(len(w), first or len(w))
    lost = p["k_D"] * unforeseen.broken(w * A / (W1 * reach), when, e)
    K = (_linear(w, p, e, A, reach) - lost)[:, None]
    F = A * (K.imag * np.sin(THETA) - K.real * np.cos(THETA)) + _nonlinear(p, e, A, reach)
    if s := e.get("quadratic_damping"):
        v = w[:, None] * A * np.sin(THETA)
        F = F + p["c_D"] * s["size"] * v * np.abs(v) / (W1 * 10 * reach)
    if s := e.get("temperature_drift"):
        F = F * (1 - s["size"] * -np.expm1(-when / s["tau"]))[:, None]
    order = 1j * w[:, None] * np.arange(POINTS // 2 + 1)  # jω of each harmonic
    gain = np.ones_like(order)
    if s := e.get("force_sensor_lag"):
        gain = gain / (1 + order * s["size"])
    if s := e.get("sensor_delay"):
        gain = gain * np.exp(-order * s["size"])
    if s := e.get("novel:echo"):
        gain = gain * (1 + s["size"] * np.exp(-order * s["late"]))
    return np.asarray(np.fft.irfft(np.fft.rfft(F, axis=1) * gain, POINTS, axis=1))


def measured(F: Array, A: float) -> Array:
    """k_s [N/mm] and loss angle [deg], (2, n), of cycles (n, POINTS); peaks by a parabola."""
    top = np.argmax(F, axis=1)
    at = np.arange(len(F))
    before, peak, after = (F[at, (top + i) % POINTS] for i in (-1, 0, 1))
    A_F = peak - (after - before) ** 2 / (8 * (after - 2 * peak + before))
    h_s = F[:, POINTS // 4]
    return np.array([A_F / A, np.degrees(np.arcsin(np.clip(h_s / A_F, -1, 1)))])


def _linear(w: Array, p: Mapping[str, float], e: Strength, A: float, reach: float) -> Complex:
    """Complex stiffness [N/mm] of spring, dashpot and all that is linear in the displacement."""
    k, mass = p["k_D"] * np.ones(len(w), complex), p["k_D"] / (10 * W1) ** 2
    if s := e.get("payne_softening"):
        k = k * (1 - s["size"] * (1 - 1 / (1 + (A / (s["at"] * reach)) ** 2)))
    K = k + 1j * w * p["c_D"] + p["k_D"] * _memory(w, e)
    if s := e.get("inertia"):
        K = K - s["size"] * mass * w**2
    if s := e.get("second_mode"):
        K = K + 1j * w * el.resonator(w, s["size"] * mass, s["at"] * W1, s["q"])
    if s := e.get("novel:mount_modes"):
        K = K + 1j * w * sum(
            el.resonator(w, s["size"] * mass / n, s["at"] * n * W1, s["q"]) for n in (1, 2, 3, 4, 5)
        )
    if s := e.get("contact_compliance"):
        K = 1 / (1 / K + s["size"] / p["k_D"])
    return K


def _nonlinear(p: Mapping[str, float], e: Strength, A: float, reach: float) -> Array:
    """Friction and nonlinear springs [N] over the last of some cycles, (POINTS,)."""
    x = -A * np.cos(2 * np.pi * np.arange(CYCLES * POINTS + 1) / POINTS)
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
    return np.asarray(F[-POINTS - 1 : -1])


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


def draw_base(rng: Rng) -> dict[str, float]:
    """Parameters like the paper's, with a dashpot that doesn't yet outweigh the spring at 15 Hz."""
    p = {
        "k_D": rng.uniform(0.3, 0.8),
        "c_D": float(np.exp(rng.uniform(np.log(0.002), np.log(0.012)))),
        "h_D": float(np.exp(rng.uniform(np.log(0.03), np.log(0.3)))),
        "rho": rng.uniform(1, 3),
    }
    return {k: float(f"{v:.6g}") for k, v in p.items()}


def draw_setup(rng: Rng, base: Mapping[str, float], effects: Sequence[str]) -> dict[str, Any]:
    """Two or three amplitudes to fit, 0.1 or 0.3 to 15 Hz, and one in between held out."""
    amplitudes = [0.4, 0.8] if rng.random() < 0.5 else [0.2, 0.6, 2.0]
    roles = ["fit"] * len(amplitudes) + ["holdout"]
    lo, n = float(rng.choice([0.1, 0.3])), int(rng.integers(25, 61))
    sweeps = [
        {"lo": lo, "hi": 15.0, "n": n, "role": role, "known": {"A_z": A}}
        for A, role in zip([*amplitudes, 0.5], roles, strict=True)
    ]
    return {"sweeps": sweeps, "constants": {}, "free": ["k_D", "c_D", "h_D", "rho"]}


def draw_form(
    rng: Rng, effect: str, law: str, base: Mapping[str, float], setup: Mapping[str, Any]
) -> dict[str, Any]:
    """The parameters of one effect; "at" is relative to the largest amplitude, or in Hz for a mode."""
    if effect in novel.KINDS:
        return novel.draw_form(rng, effect, SIZES[effect][0])
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
