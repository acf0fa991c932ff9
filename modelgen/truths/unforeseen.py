"""Physics of no catalogue that nobody had in mind when the diagnosis was written.

Chosen from what happens on benches, without a look at what the diagnosis can say, and kept apart from the
older kinds (`secret.FORESEEN`), so that the scores tell how often the unexpected is called unknown.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.signal import lfilter

from .elements import Array, Complex
from .once_unforeseen import Form, Sizes, Spans, within
from .solve import Strength

# effect -> (first size tried, largest plausible size)
SWEEPS: Sizes = {
    "novel:pulled_oscillator": (3e-4, 0.05),
    "novel:log_ripple": (0.001, 0.2),
    "novel:bead_chain": (0.003, 0.5),
}
FORCE: Sizes = {
    "novel:snapping_dome": (0.005, 0.5),
    "novel:knock": (0.005, 0.5),
    "novel:leaky_detector": (2e-3, 0.3),  # in s
}
STIFFNESS: Sizes = {"novel:thixotropy": (0.01, 0.8)}


def pulled(read: Callable[[Array], Complex], w: Array, e: Strength) -> Complex:
    """What `read` gives at ω [rad/s], or where a feeble oscillator really is that was set there: the load
    pulls it by `size` times the sine of its own phase."""
    Z = read(w)
    if s := e.get("novel:pulled_oscillator"):
        Z = read(w * (1 + s["size"] * Z.imag / np.abs(Z)))
    return Z


def at_terminals(Z: Complex, e: Strength, z: float) -> Complex:
    """An impedance [ohm] as a detector tells it whose logarithm is that of a chain of limiting stages: once a
    stage, of `stage` in ln |Z|, it reads too much and too little. `z` [ohm] is where the first begins."""
    if s := e.get("novel:log_ripple"):
        stages = np.log(np.abs(Z) / z) / s["stage"]
        Z = Z * np.exp(s["size"] * np.sin(2 * np.pi * stages + s["phase"]))
    return Z


def on_moving_side(x: Array, e: Strength) -> Complex:
    """Mechanical impedance over M ω0 that is added at ω = x ω0."""
    if s := e.get("novel:bead_chain"):
        return np.asarray(s["size"] * chain(x / s["at"]))
    return np.zeros(len(x), complex)


def chain(x: Array) -> Complex:
    """Impedance over √(k m) at the first of endlessly many beads m on springs k, x = ω/(2 √(k/m)): waves
    carry power away up to x = 1, and none enters beyond."""
    return np.asarray(1j * x + np.where(x < 1, 1, -1j) * np.sqrt(np.abs(1 - x**2)))


def force(x: Array, v: Array, dt: float, e: Strength) -> Array:
    """Force over that of the spring at full reach, of the position over its reach and the velocity over its
    largest, each `dt` [s]."""
    F = np.zeros(len(x))
    if s := e.get("novel:snapping_dome"):
        F -= s["size"] * s["side"] * snapped(s["side"] * x, s)
    if s := e.get("novel:knock"):
        F += s["size"] * ringing(v, dt, s)
    return F


def snapped(x: Array, s: Form) -> Array:
    """1 where a bistable dome is snapped through, 0 where it isn't: it goes over at x = `over` and comes back
    `width` below."""
    told = np.where(x > s["over"], 1, np.where(x < s["over"] - s["width"], 0, -1))
    told[0] = max(told[0], 0)
    last = np.maximum.accumulate(np.where(told >= 0, np.arange(len(x)), 0))
    return np.asarray(told[last], float)


def ringing(v: Array, dt: float, s: Form) -> Array:
    """A fixture with a clearance that is crossed at each reversal, as fast as √acceleration, and rings."""
    hit, turn = np.zeros(len(v)), np.flatnonzero(v[:-1] * v[1:] < 0)
    change = v[turn + 1] - v[turn]
    hit[turn] = np.sign(change) * np.sqrt(np.abs(change) / (20 * np.pi * dt))  # 1 at full speed and 10 Hz
    pole = np.exp((2j * np.pi * s["rings"] - 1 / s["tau"]) * dt)
    return np.asarray(lfilter([0, pole.imag], [1, -2 * pole.real, abs(pole) ** 2], hit))


def detected(t: Array, F: Array, e: Strength) -> Array:
    """A force behind a carrier's detector: its capacitor follows up at once, but leaks no faster than in
    `size` [s] towards the lowest force."""
    if not (s := e.get("novel:leaky_detector")):
        return F
    with np.errstate(divide="ignore"):
        above = np.log(F - F.min())
    return np.asarray(F.min() + np.exp(np.maximum.accumulate(above + t / s["size"]) - t / s["size"]))


def broken(speed: Array, order: Array, e: Strength) -> Array:
    """Share of a stiffness that is lost, at speeds (n,) over 2π reach/s that come one after the other: a
    structure is broken down by the motion and builds up again in `tau` of a sweep."""
    if not (s := e.get("novel:thixotropy")):
        return np.zeros(len(speed))
    whole, found = 1.0, []
    for rate, dt in zip(1 + speed / s["at"], np.diff(order, prepend=0), strict=True):
        whole = 1 / rate + (whole - 1 / rate) * np.exp(-rate * dt / s["tau"])
        found.append(whole)
    return np.asarray(s["size"] * (1 - np.array(found)))


def draw_form(rng: np.random.Generator, effect: str, size: float) -> dict[str, Any]:
    """The parameters of one effect; "at" is a frequency over the resonance, or in Hz at full reach."""
    spans: Spans = {
        "novel:pulled_oscillator": {},
        "novel:log_ripple": {"stage": (0.4, 1.0), "phase": (0, 6)},
        "novel:bead_chain": {"at": (0.85, 1.5)},
        "novel:snapping_dome": {"over": (0.25, 0.5), "width": (0.3, 0.6)},
        "novel:knock": {"rings": (15, 40), "tau": (0.05, 0.2)},
        "novel:leaky_detector": {},
        "novel:thixotropy": {"at": (0.5, 4), "tau": (0.05, 0.4)},
    }
    form = within(rng, spans[effect], size)
    if effect == "novel:snapping_dome":
        form["side"] = float(rng.choice([-1.0, 1.0]))
    return form
