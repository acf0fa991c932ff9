"""Draws of magnetostrictive transducers like the paper's, of their sweeps, and of the forms of an effect."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from . import novel
from .impedance_draw import draw_form as coil_form

Rng = np.random.Generator

SIZES: dict[str, tuple[float, float]] = {
    "contact_damping": (1.0, 200.0),
    "structural_damping": (0.05, 3.0),
    "power_law_viscoelasticity": (0.1, 8.0),
    "maxwell_branch": (0.2, 10.0),
    "inertia": (0.002, 0.3),
    "temperature_drift": (0.003, 0.3),
    "sensor_delay": (0.002, 0.5),
    "semi_inductance": (0.01, 2.0),
    "eddy_shunt": (0.01, 2.0),
    "coil_capacitance": (0.005, 0.5),
    "coil_ac_resistance": (0.5, 60.0),
    "leakage_inductance": (0.02, 2.0),
    "permeability_relaxation": (0.02, 1.5),
    "second_mode": (0.002, 0.3),
    "distributed_rod": (0.3, 1.5),
    "radiation_load": (0.02, 5.0),
    "contact_compliance": (0.005, 0.5),
    "novel:cavity_comb": (0.01, 2.0),
    "novel:cable_trap": (0.02, 10.0),
    "novel:mains_hum": (0.01, 2.0),
    **novel.SWEEPS,
}

VARIANTS: dict[str, str] = {
    "lossy_capacitor": "coil_capacitance",
    "lossy_rod": "distributed_rod",
    "sphere": "radiation_load",
    "proximity": "coil_ac_resistance",
}

MATERIAL = ("mu33_re", "mu33_im", "S33_re", "S33_im", "d33_re", "d33_im")


def draw_base(rng: Rng) -> dict[str, float]:
    """The paper's transducer with its material and fittings changed by up to some ten per cent."""

    def near(value: float, spread: float) -> float:
        return float(f"{value * np.exp(rng.normal(0, spread)):.6g}")

    p = {
        "mu33_re": near(2.814, 0.05),
        "mu33_im": -near(0.137, 0.3),
        "S33_re": near(2.547e-11, 0.05),
        "S33_im": -near(2.5e-13, 0.3),
        "d33_re": near(1.587e-9, 0.05),
        "d33_im": -near(4e-11, 0.2),
        "R_0": near(3.0, 0.2),
        "N": 940.0,
        "A": 3.14159e-4,
        "l": 0.1,
        "K_spr": near(3e6, 0.2),
        "R_d": 6.79,
        "R_f": near(150.0, 0.5),
        "f_c": 30e3,
        "k_M2": 0.9205,
        "M_t": near(1.25, 0.08),
    }
    return p


def draw_setup(rng: Rng, base: dict[str, float], effects: Sequence[str]) -> dict[str, Any]:
    """Two fit sweeps with known loads, one held out with the first; R_f known in half of the cases."""
    n = int(rng.choice([201, 301, 401]))
    loads = (base["M_t"], float(f"{base['M_t'] * rng.uniform(1.2, 1.6):.5g}"))
    sweeps = [
        {
            "lo": 1000.0,
            "hi": 2500.0,
            "n": n,
            "linear": True,
            "down": bool(i == 1 and rng.random() < 0.5),
            "role": "holdout" if i == 2 else "fit",
            "known": {"M_t": loads[i % 2]},
        }
        for i in range(3)
    ]
    names = ("R_0", "N", "A", "l", "K_spr", "R_d", "R_f", "f_c", "k_M2")
    constants = {n: base[n] for n in names}
    free = list(MATERIAL)
    if "contact_damping" not in effects and rng.random() < 0.5:
        del constants["R_f"]
        free.append("R_f")
    return {"sweeps": sweeps, "constants": constants, "free": free}


def draw_form(
    rng: Rng, effect: str, law: str, base: dict[str, float], setup: dict[str, Any]
) -> dict[str, Any]:
    """The parameters of one effect, relative to the loaded resonance and to the highest frequency."""
    w0 = np.sqrt((base["A"] / (base["l"] * base["S33_re"]) + base["K_spr"]) / base["M_t"])
    form = coil_form(rng, effect, law, {"K_m": w0**2, "M_m": 1.0}, setup)
    own = {
        "second_mode": (0.7, 1.45),
        "radiation_load": (0.5, 3.0),
        "novel:cavity_comb": (0.1, 0.3),
        "novel:cable_trap": (0.45, 0.95),
        "maxwell_branch": (0.5, 2.0),
        "novel:ferroresonance": (0.45, 0.95),
    }
    if effect in own:
        form["at"] = float(rng.uniform(*own[effect]))
    return form | {"size": SIZES[effect][0]}
