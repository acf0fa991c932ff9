"""Draws of samples like the paper's, of the motions they are recorded in, and of the forms of an effect."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from . import novel

Rng = np.random.Generator

# effect -> (first size tried, largest plausible size); relative to k_D and to the largest displacement
SIZES: dict[str, tuple[float, float]] = {
    "contact_damping": (0.1, 5.0),
    "structural_damping": (0.01, 1.0),
    "power_law_viscoelasticity": (0.02, 3.0),
    "maxwell_branch": (0.02, 3.0),
    "cubic_stiffness": (0.01, 2.0),
    "asymmetric_stiffness": (0.01, 1.0),
    "payne_softening": (0.03, 0.9),
    "stress_softening": (0.02, 0.6),
    "quadratic_damping": (0.02, 3.0),
    "inertia": (0.005, 1.0),
    "second_dahl_element": (0.05, 3.0),
    "stribeck_friction": (0.05, 3.0),
    "dahl_exponent": (0.1, 1.1),
    "backlash": (0.01, 0.3),
    "end_stop": (0.1, 20.0),
    "magnetic_pull": (0.01, 0.5),
    "offset_drift": (0.005, 0.5),
    "temperature_drift": (0.005, 0.5),
    "sensor_delay": (1e-4, 0.02),
    "force_sensor_lag": (1e-4, 0.02),
    "contact_compliance": (0.01, 0.5),
    "second_mode": (0.005, 0.5),
    "novel:position_periodic": (0.003, 0.3),
    "novel:mains_hum": (0.002, 0.3),
    "novel:clipped_sensor": (0.02, 0.6),
    **novel.FORCE,
}

VARIANTS: dict[str, str] = {
    "stretched_exponential": "power_law_viscoelasticity",
    "relaxing_friction": "maxwell_branch",
    "smoothed_backlash": "backlash",
    "dead_zone": "backlash",
    "elastic_play": "backlash",
    "half_swing": "payne_softening",
    "peak": "stress_softening",
    "bilinear": "asymmetric_stiffness",
    "gaussian": "stribeck_friction",
    "wandering": "offset_drift",
}


def _log(rng: Rng, lo: float, hi: float) -> float:
    return float(np.exp(rng.uniform(np.log(lo), np.log(max(lo, hi)))))


def draw_base(rng: Rng) -> dict[str, float]:
    """Parameters in the range of the paper's samples."""
    p = {
        "k_D": rng.uniform(0.3, 0.8),
        "c_D": rng.uniform(0.05, 0.15),
        "h_D": _log(rng, 0.03, 0.5),
        "rho": rng.uniform(1, 3),
        "F_0": rng.uniform(1, 2),
    }
    return {k: float(f"{v:.6g}") for k, v in p.items()}


def _loop(rng: Rng) -> dict[str, Any]:
    return {
        "motion": {"type": "steps", "steps": [0.1], "cycles": 2, "amplitude": 3.0},
        "rate": 128.0,
        "seconds": 20.0,
    }


def _steps(rng: Rng, slow: bool = False) -> dict[str, Any]:
    f = np.geomspace(0.2, 0.6, 3) if slow else np.geomspace(0.4, rng.uniform(6, 10), 6)
    motion = {
        "type": "steps",
        "steps": [float(f"{x:.4g}") for x in f],
        "cycles": 3,
        "amplitude": float(rng.choice([0.4, 0.6, 0.8])),
    }
    return {"motion": motion, "rate": 400.0, "seconds": float(round(3 * (1 / f).sum(), 2))}


def _sweep(rng: Rng) -> dict[str, Any]:
    seconds = float(rng.choice([12.0, 15.0]))
    motion = {
        "type": "sweep",
        "from": 0.3,
        "to": 10.0,
        "seconds": seconds,
        "amplitude": float(rng.choice([0.4, 0.6, 0.8])),
    }
    return {"motion": motion, "rate": 500.0, "seconds": seconds}


def _random(rng: Rng, reach: float, top: float) -> dict[str, Any]:
    """A random record that stays within 0.9 of the largest displacement that the fit records reach."""
    lines = np.sort(rng.uniform(0.2, 0.8 * top, 16))
    motion: dict[str, Any] = {
        "type": "random",
        "lines": [float(f"{x:.4g}") for x in lines],
        "phases": [float(f"{x:.4g}") for x in rng.uniform(0, 2 * np.pi, 16)],
    }
    t = np.arange(0, 12, 2e-3)
    peak = np.abs(np.sin(t[:, None] * 2 * np.pi * lines + np.asarray(motion["phases"])).sum(1)).max()
    return {
        "motion": motion | {"amplitude": float(f"{0.9 * min(reach, 1.0) / peak:.4g}")},
        "rate": 400.0,
        "seconds": 12.0,
    }


def _slowest(motion: dict[str, Any]) -> float:
    """Lowest frequency [Hz] of a motion."""
    return float(
        {
            "sweep": lambda: motion["from"],
            "steps": lambda: motion["steps"][0],
            "random": lambda: motion["lines"][0],
        }[motion["type"]]()
    )


def draw_setup(rng: Rng, base: dict[str, float], effects: Sequence[str]) -> dict[str, Any]:
    """Two records to fit (slow wide loop, stepped sines, sweeps, at two amplitudes), a random one held out.

    Lost motion is recorded slowly, as are some others: faster, a clearance is crossed between two samples.
    """
    slow = "backlash" in effects or rng.random() < 0.1
    first = [_loop, _steps, _sweep][0 if slow else int(rng.integers(3))](rng)
    second = _steps(rng, slow=True) if slow else [_steps, _sweep][int(rng.integers(2))](rng)
    second["motion"]["amplitude"] = 0.8 if first["motion"]["amplitude"] == 0.4 else 0.4
    records = [first, second]
    records.append(_random(rng, max(r["motion"]["amplitude"] for r in records), 0.8 if slow else 10.0))
    running = rng.random() < 0.3
    for i, r in enumerate(records):
        pre = round(1 / _slowest(r["motion"]), 1) if running else 0.0
        r |= {"pre": pre, "role": "holdout" if i == 2 else "fit"}
        if running and r["motion"]["type"] != "random":
            r["seconds"] = round(r["seconds"] - pre, 2) if r["seconds"] > 2 * pre else r["seconds"]
    own = ["F_0"] if rng.random() < 0.25 else []
    return {
        "records": records,
        "constants": {} if running else {"r_0": 0.0},
        "per_recording": own + (["r_0"] if running else []),
    }


def draw_form(
    rng: Rng, effect: str, law: str, base: dict[str, float], setup: dict[str, Any]
) -> dict[str, Any]:
    """One effect's parameters; "at" is relative to the largest displacement or speed, in Hz for a mode."""
    if effect in novel.KINDS:
        return novel.draw_form(rng, effect, SIZES[effect][0])
    form: dict[str, Any] = {"size": SIZES[effect][0], "law": law}
    side = float(rng.choice([-1.0, 1.0]))
    draws: dict[str, dict[str, Any]] = {
        "power_law_viscoelasticity": {"alpha": rng.uniform(0.15, 0.6), "tau": _log(rng, 0.03, 1)},
        "maxwell_branch": {"tau": _log(rng, 0.02, 1)},
        "payne_softening": {"at": _log(rng, 0.1, 0.6), "smooth": 0.3},
        "stress_softening": {"at": _log(rng, 2, 30)},
        "second_dahl_element": {"ratio": _log(rng, 4, 15)},
        "stribeck_friction": {"at": _log(rng, 0.02, 0.2)},
        "dahl_exponent": {"sign": side},
        "end_stop": {"at": rng.uniform(0.6, 0.9), "side": side, "power": float(rng.choice([1.0, 1.5]))},
        "magnetic_pull": {"gap": side * rng.uniform(1.3, 2.5)},
        "offset_drift": {"tau": 15.0, "phase": rng.uniform(0, 6)},
        "temperature_drift": {"tau": _log(rng, 5, 40)},
        "second_mode": {"at": rng.uniform(5, 16), "q": _log(rng, 4, 25)},
        "novel:position_periodic": {"pitch": rng.uniform(0.12, 0.35), "phase": rng.uniform(0, 6)},
        "novel:mains_hum": {"phase": rng.uniform(0, 6), "fall": rng.uniform(0.2, 0.5)},
    }
    return form | {k: float(v) for k, v in draws.get(effect, {}).items()}
