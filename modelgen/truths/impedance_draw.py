"""Draws of moving-coil devices, of their sweeps, and of the forms that an effect can take in them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from . import novel

Rng = np.random.Generator

# effect -> (first size tried, largest plausible size)
SIZES: dict[str, tuple[float, float]] = {
    "contact_damping": (0.1, 20.0),
    "structural_damping": (0.01, 0.5),
    "power_law_viscoelasticity": (0.05, 3.0),
    "maxwell_branch": (0.05, 3.0),
    "cubic_stiffness": (0.01, 3.0),
    "quadratic_damping": (0.05, 5.0),
    "inertia": (0.02, 2.0),
    "temperature_drift": (0.005, 0.3),
    "sensor_delay": (0.005, 1.5),
    "semi_inductance": (0.05, 3.0),
    "eddy_shunt": (0.05, 5.0),
    "coil_capacitance": (0.005, 0.8),
    "coil_ac_resistance": (0.3, 60.0),
    "leakage_inductance": (0.1, 3.0),
    "permeability_relaxation": (0.05, 3.0),
    "second_mode": (0.01, 0.6),
    "distributed_rod": (0.3, 6.0),
    "radiation_load": (0.02, 3.0),
    "contact_compliance": (0.01, 0.5),
    "novel:cavity_comb": (0.01, 2.0),
    "novel:cable_trap": (0.02, 5.0),
    "novel:mains_hum": (0.01, 1.0),
    **novel.SWEEPS,
}

VARIANTS: dict[str, str] = {
    "lossy_capacitor": "coil_capacitance",
    "lossy_rod": "distributed_rod",
    "moving_rod": "distributed_rod",
    "two_cell_ladder": "eddy_shunt",
    "shorted_turn": "eddy_shunt",
    "solid_core": "semi_inductance",
    "sphere": "radiation_load",
    "stretched_exponential": "power_law_viscoelasticity",
    "log_creep": "power_law_viscoelasticity",
    "proximity": "coil_ac_resistance",
}

FREE = ("R_e", "L_e", "Bl", "K_m", "R_m")


def _log(rng: Rng, lo: float, hi: float) -> float:
    return float(np.exp(rng.uniform(np.log(lo), np.log(max(lo, hi)))))


def draw_base(rng: Rng) -> dict[str, float]:
    """A loudspeaker (two in three) or a stiffer, lighter damped resonator."""
    if rng.random() < 0.65:
        M, f0, q = _log(rng, 5e-3, 60e-3), _log(rng, 25, 90), rng.uniform(2, 8)
        R_e, L_e, peak = rng.uniform(3, 8), _log(rng, 1e-4, 1.2e-3), rng.uniform(2, 12)
    else:
        M, f0, q = _log(rng, 0.05, 2.0), _log(rng, 200, 2000), _log(rng, 10, 60)
        R_e, L_e, peak = _log(rng, 2, 30), 0.0, rng.uniform(0.7, 6)
        L_e = R_e * rng.uniform(0.5, 4) / (2 * np.pi * f0)
    w0 = 2 * np.pi * f0
    R_m = w0 * M / q
    Bl = float(np.sqrt(peak * R_e * R_m))
    return {
        k: float(f"{v:.6g}") for k, v in dict(R_e=R_e, L_e=L_e, Bl=Bl, M_m=M, K_m=M * w0**2, R_m=R_m).items()
    }


def draw_setup(rng: Rng, base: dict[str, float], effects: Sequence[str]) -> dict[str, Any]:
    """One to three sweeps to fit and one to hold out; the moving mass known, or two known loads on it."""
    f0 = float(np.sqrt(base["K_m"] / base["M_m"])) / (2 * np.pi)
    loud = f0 < 150
    span = (20.0, 20e3) if loud else (f0 / rng.uniform(2.5, 5), f0 * rng.uniform(2.5, 6))
    loads = "inertia" in effects or rng.random() < 0.35
    count = 2 if loads else int(rng.integers(1, 4))
    sweeps = []
    for i in range(count + 1):
        extra = float(f"{base['M_m'] * (0.0, 0.6, 0.3)[min(i, 2)]:.4g}") if loads else 0.0
        sweeps.append(
            {
                "lo": span[0],
                "hi": span[1],
                "n": int(rng.choice([200, 301, 401])),
                "linear": False,
                "down": bool(i % 2 == 1 and count > 1),
                "role": "holdout" if i == count else "fit",
                "known": {"M_m": base["M_m"] + extra} if loads else {},
            }
        )
    constants = {} if loads else {"M_m": base["M_m"]}
    free = list(FREE)
    if "contact_damping" in effects or rng.random() < 0.1:  # told apart from R_m only where that is known
        constants["R_m"] = base["R_m"]
        free.remove("R_m")
    return {"sweeps": sweeps, "constants": constants, "free": free}


def draw_form(
    rng: Rng, effect: str, law: str, base: dict[str, float], setup: dict[str, Any]
) -> dict[str, Any]:
    """The parameters of one effect; "at" is a frequency over `top` (electrical) or over w0 (mechanical)."""
    if effect in novel.KINDS:
        return novel.draw_form(rng, effect, SIZES[effect][0])
    f0 = float(np.sqrt(base["K_m"] / base["M_m"])) / (2 * np.pi)
    lo, hi = setup["sweeps"][0]["lo"] / f0, setup["sweeps"][0]["hi"] / f0
    form: dict[str, Any] = {"size": SIZES[effect][0], "law": law}
    draws: dict[str, dict[str, Any]] = {
        "power_law_viscoelasticity": {"alpha": rng.uniform(0.15, 0.6), "at": _log(rng, 0.3, 3)},
        "maxwell_branch": {"at": _log(rng, max(0.3, 1.5 * lo), 3)},
        "temperature_drift": {"tau": _log(rng, 0.3, 3)},
        "semi_inductance": {"n": rng.uniform(0.4, 0.75), "at": _log(rng, 0.003, 0.05)},
        "eddy_shunt": {"at": _log(rng, 0.05, 0.5), "ratio": _log(rng, 0.05, 0.3)},
        "coil_capacitance": {"tan_delta": _log(rng, 0.02, 0.3), "lead": _log(rng, 0.01, 0.3)},
        "coil_ac_resistance": {"layers": float(rng.integers(2, 7))},
        "permeability_relaxation": {"at": _log(rng, 0.02, 0.5), "a": rng.uniform(0.6, 0.95)},
        "second_mode": {"at": _log(rng, max(1.3 * lo, 0.6), min(0.7 * hi, 12)), "q": _log(rng, 8, 60)},
        "distributed_rod": {"share": rng.uniform(0.3, 0.8), "eta": _log(rng, 0.02, 0.2)},
        "radiation_load": {"at": _log(rng, 0.8, min(0.5 * hi, 20))},
        "contact_compliance": {"share": rng.uniform(0.15, 0.5)},
        "novel:cavity_comb": {"at": _log(rng, max(1.2 * lo, 0.4), hi / 6), "q": _log(rng, 10, 40)},
        "novel:cable_trap": {"at": _log(rng, 0.05, 0.6), "q": _log(rng, 20, 80)},
        "novel:mains_hum": {"bandwidth": _log(rng, 4, 12), "phase": rng.uniform(0, 6)},
    }
    return form | {k: float(v) for k, v in draws.get(effect, {}).items()}
