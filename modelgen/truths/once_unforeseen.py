"""Physics of no catalogue that nobody had in mind when the diagnosis was first proved, and which has been
looked at since: it counts as foreseen (`secret.FORESEEN`) from then on.

Chosen from what happens on benches, without a look at what the diagnosis could say.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from .elements import Array, Complex
from .solve import Strength

Form = Mapping[str, Any]
Sizes = dict[str, tuple[float, float]]
Spans = Mapping[str, Mapping[str, tuple[float, float]]]

# effect -> (first size tried, largest plausible size)
SWEEPS: Sizes = {
    "novel:echoing_line": (0.01, 0.6),
    "novel:ferroresonance": (0.05, 8.0),
    "novel:phase_creep": (0.002, 0.5),
    "novel:pulled_oscillator": (3e-4, 0.05),
    "novel:log_ripple": (0.001, 0.2),
}
FORCE: Sizes = {
    "novel:pumped_stiffness": (0.005, 0.5),
    "novel:loose_clamp": (0.005, 0.5),
    "novel:thermostat": (0.003, 0.3),
}
STIFFNESS: Sizes = {"novel:echo": (0.005, 0.5)}


def pulled(read: Callable[[Array], Complex], w: Array, e: Strength) -> Complex:
    """What `read` gives at ω [rad/s], or where a feeble oscillator really is that was set there: the load
    pulls it by `size` times the sine of its own phase."""
    Z = read(w)
    if s := e.get("novel:pulled_oscillator"):
        Z = read(w * (1 + s["size"] * Z.imag / np.abs(Z)))
    return Z


def at_terminals(Z: Complex, w: Array, e: Strength, top: float, z: float, order: Array) -> Complex:
    """An impedance [ohm] as the terminals show it; `z` [ohm] is the size of a series element, `order` the
    time over the first sweep's length."""
    if s := e.get("novel:echoing_line"):
        Z = Z + z * echo(w / top, s)
    if s := e.get("novel:ferroresonance"):
        Z = Z + s["size"] * z * ferroresonance(w / (top * s["at"]), s)
    if s := e.get("novel:phase_creep"):  # of the reference, with the logarithm of the time
        creep = np.log1p(np.clip(order, 0, None) / s["tau"]) / np.log1p(1 / s["tau"])
        Z = Z * np.exp(-1j * s["size"] * creep)
    return detected(Z, e, z)


def detected(Z: Complex, e: Strength, z: float) -> Complex:
    """An impedance [ohm] as a detector tells it whose logarithm is that of a chain of limiting stages: once a
    stage, of `stage` in ln |Z|, it reads too much and too little. `z` [ohm] is where the first begins."""
    if s := e.get("novel:log_ripple"):
        stages = np.log(np.abs(Z) / z) / s["stage"]
        Z = Z * np.exp(s["size"] * np.sin(2 * np.pi * stages + s["phase"]))
    return Z


def echo(x: Array, s: Form) -> Complex:
    """What a mismatched line in series adds over its own impedance: (1 + r)/(1 - r) - 1, where r is the wave
    that comes back after `trips` periods of the highest frequency (x = 1)."""
    back = s["size"] * np.exp(-2j * np.pi * s["trips"] * x)
    return np.asarray(2 * back / (1 - back))


def ferroresonance(x: Array, s: Form) -> Complex:
    """A parallel resonance whose inductance saturates: 1/(1 + j(d - κu)), u = |·|², of the detuning d. Where
    three u solve this the sweep stays on the branch that it came by, and jumps where that ends."""
    detuning, u, found = s["q"] * (x - 1 / x), 0.0, []
    for d in detuning:
        roots = np.roots([s["bend"] ** 2, -2 * d * s["bend"], d**2 + 1, -1.0])
        real = roots.real[np.abs(roots.imag) < 1e-6 * np.maximum(1.0, np.abs(roots))]
        u = float(real[np.argmin(np.abs(real - u))])
        found.append(u)
    return np.asarray(1 / (1 + 1j * (detuning - s["bend"] * np.array(found))))


def stiffness(t: Array, e: Strength) -> Array:
    """Stiffness over its resting value at times t [s] of a record."""
    k = np.ones(len(t))
    if s := e.get("novel:pumped_stiffness"):  # by a machine near by, at a frequency of its own
        k *= 1 + s["size"] * np.sin(2 * np.pi * s["pump"] * t + s["phase"])
    if s := e.get("novel:loose_clamp"):  # it slips and catches again, at instants with no period
        x = 2 * np.pi * t / s["tau"] + s["phase"]
        k *= 1 - s["size"] * (np.sin(x) + np.sin(1.618 * x) + 0.6 * np.sin(2.718 * x) > 0.3)
    return k


def gain(t: Array, e: Strength) -> Array:
    """Gain of a force sensor over its nominal one: a heater beside it goes on and off, of each period for a
    share `duty`."""
    if not (s := e.get("novel:thermostat")):
        return np.ones(len(t))
    slow, x = s["slow"], np.mod(t / s["period"] + s["phase"], 1.0)
    hot = -np.expm1(-s["duty"] / slow) / -np.expm1(-1 / slow)
    cold = hot * np.exp((s["duty"] - 1) / slow)
    warming = 1 - (1 - cold) * np.exp(-x / slow)
    cooling = hot * np.exp(-(x - s["duty"]) / slow)
    return np.asarray(1 + s["size"] * np.where(x < s["duty"], warming, cooling))


def draw_form(rng: np.random.Generator, effect: str, size: float) -> dict[str, Any]:
    """The parameters of one effect; "at" is a frequency over the highest."""
    spans: Spans = {
        "novel:echoing_line": {"trips": (4, 10)},
        "novel:ferroresonance": {"at": (0.1, 0.6), "q": (8, 20), "bend": (2, 6)},
        "novel:phase_creep": {"tau": (0.02, 0.3)},
        "novel:pulled_oscillator": {},
        "novel:log_ripple": {"stage": (0.4, 1.0), "phase": (0, 6)},
        "novel:pumped_stiffness": {"pump": (2.3, 9), "phase": (0, 6)},
        "novel:loose_clamp": {"tau": (4, 9), "phase": (0, 6)},
        "novel:thermostat": {"period": (3, 9), "duty": (0.3, 0.6), "slow": (0.2, 0.5), "phase": (0, 1)},
        "novel:echo": {"late": (0.15, 0.4)},
    }
    return within(rng, spans[effect], size)


def within(rng: np.random.Generator, spans: Mapping[str, tuple[float, float]], size: float) -> dict[str, Any]:
    """An effect's form, each of its parameters drawn evenly within its span."""
    form: dict[str, Any] = {"size": size, "law": ""}
    return form | {name: float(rng.uniform(*span)) for name, span in spans.items()}
