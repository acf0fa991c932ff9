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
    "novel:bead_chain": (0.003, 0.5),
    "novel:rippling_supply": (0.02, 0.6),
    "novel:hopping_grain": (0.003, 0.4),
}
FORCE: Sizes = {
    "novel:snapping_dome": (0.005, 0.5),
    "novel:knock": (0.005, 0.5),
    "novel:leaky_detector": (2e-3, 0.3),  # in s
}
STIFFNESS: Sizes = {"novel:thixotropy": (0.01, 0.8)}


def rippled(read: Callable[[Array], Complex], w: Array, e: Strength) -> Complex:
    """What `read` gives at ω [rad/s], or with one supply for source and detector that ripples by `size`: each
    sideband of the drive passes the device, and the detector brings it back to ω."""
    Z = read(w)
    if s := e.get("novel:rippling_supply"):
        ripple, share = 2 * np.pi * s["ripple"], s["size"] ** 2 / 4
        for side in (w + ripple, w - ripple):
            off = read(np.maximum(np.abs(side), 1e-6 * ripple))
            Z = Z + share * np.where(side < 0, off.conj(), off)
        Z = Z / (1 + 2 * share)
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


FLIGHTS = np.linspace(0, 2 * np.pi, 401)[4:]


def hopped(Z: Complex, x: Array, unit: float, e: Strength) -> Complex:
    """Mechanical impedance [N·s/m] of all that moves, at ω = x ω0 under constant current; `unit` is M ω0. A
    share `size` of the mass, weighed with the rest, lies loose upon it, and hops where that is shaken harder
    than g: the drive of a sweep is set for `peak` g at most."""
    if not (s := e.get("novel:hopping_grain")):
        return Z
    m, drive = 1j * x * s["size"] * unit, s["peak"] * float(np.min(np.abs(Z) / x))
    lo, hi = np.zeros(len(x)), np.full(len(x), 1e6)
    for _ in range(60):
        shaken = 0.5 * (lo + hi)
        over = shaken * np.abs(Z + m * (carried(shaken) - 1)) > drive * x
        lo, hi = np.where(over, lo, shaken), np.where(over, shaken, hi)
    return np.asarray(Z + m * (carried(0.5 * (lo + hi)) - 1))


def carried(shaken: Array) -> Complex:
    """First harmonic of the force that carries a loose mass, over that of a fixed one, at an acceleration
    over g. From √(1 + π²) on it leaves as it lands, and each flight takes one period."""
    known, N = hop(FLIGHTS)
    far = np.maximum(shaken, known[-1])
    always = -2 * (np.sqrt(far**2 - np.pi**2) + 1j * np.pi) / far**2
    partly = np.interp(shaken, np.append(1, known), np.append(1, N))
    return np.asarray(np.where(shaken < known[-1], partly, always))


def hop(flight: Array) -> tuple[Array, Complex]:
    """Acceleration over g that throws a mass which doesn't bounce for an angle `flight` of the motion sin θ,
    and what `carried` is there: it leaves where the floor falls at g, and takes the floor's speed at once."""
    speed = (flight**2 / 2 - 1 + np.cos(flight)) / (flight - np.sin(flight))  # at which it leaves, in g/ω
    shaken, left = np.hypot(1, speed), np.arctan2(1, speed)
    lands = left + flight
    blow = shaken * np.cos(lands) - (speed - flight)

    def held(a: Array) -> Complex:  # ∫(1 - shaken sin θ) e^{-jθ} dθ
        return np.asarray(1j * np.exp(-1j * a) + shaken * (0.5j * a + 0.25 * np.exp(-2j * a)))

    pushed = held(left + 2 * np.pi) - held(lands) + blow * np.exp(-1j * lands)
    return np.asarray(shaken), np.asarray(pushed / (1j * np.pi * shaken))


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
        "novel:bead_chain": {"at": (0.85, 1.5)},
        "novel:rippling_supply": {"ripple": (90, 400)},  # in Hz
        "novel:hopping_grain": {"peak": (1.6, 5)},
        "novel:snapping_dome": {"over": (0.25, 0.5), "width": (0.3, 0.6)},
        "novel:knock": {"rings": (15, 40), "tau": (0.05, 0.2)},
        "novel:leaky_detector": {},
        "novel:thixotropy": {"at": (0.5, 4), "tau": (0.05, 0.4)},
    }
    form = within(rng, spans[effect], size)
    if effect == "novel:snapping_dome":
        form["side"] = float(rng.choice([-1.0, 1.0]))
    return form
