"""Sparse regression of the residual on a dictionary of terms, with PySINDy's STLSQ (extra `prove`)."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from typing import Any

import numpy as np
import numpy.typing as npt

from modelgen.prove.oracle import complex_weight
from modelgen.prove.records import Array, Record

THRESHOLDS = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0)
Terms = dict[str, npt.NDArray[Any]]


def available() -> bool:
    """Whether PySINDy is installed."""
    return find_spec("pysindy") is not None


def explain(fit: Sequence[Record], held: Sequence[Record], base: Mapping[str, Any]) -> dict[str, Any]:
    """Whether any term is kept (best threshold by BIC), the effect of the largest, and what is left of each
    held-out residual."""
    parts = [_columns(r, base) for r in fit]
    names = list(parts[0][0])
    theta = np.concatenate([np.column_stack([terms[n] for n in names]) for terms, _ in parts])
    y = np.concatenate([target for _, target in parts])
    size = np.maximum(
        np.sqrt(np.mean(theta**2, axis=0)), 1e-30
    )  # then a coefficient is its term's rms / noise
    coefficients = _sparsest(theta / size, y)
    rest = []
    for r in held:
        terms, target = _columns(r, base, whole=True)
        left = target - np.column_stack([terms[n] for n in names]) / size @ coefficients
        rest.append(left.reshape(-1, len(r.data)))
    best = int(np.argmax(np.abs(coefficients)))
    missing = bool(np.any(coefficients))
    return {"found": missing, "name": names[best] if missing else "", "rest": rest}


def _sparsest(theta: Array, y: Array) -> Array:
    """STLSQ at each threshold; the coefficients with the best BIC, none at all among them."""
    from pysindy import STLSQ

    best, least = np.zeros(theta.shape[1]), float(y @ y)
    for threshold in THRESHOLDS:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            q = STLSQ(threshold=threshold, alpha=1e-6).fit(theta, y[:, None]).coef_.ravel()
        cost = float(np.sum((y - theta @ q) ** 2)) + np.count_nonzero(q) * np.log(len(y))
        if cost < least:
            best, least = q, cost
    return best


def _columns(r: Record, base: Mapping[str, Any], whole: bool = False) -> tuple[Terms, Array]:
    """Terms, each under the id of the effect that it is, and the residual; both over the noise, and without
    outliers unless `whole`."""
    good = np.all(np.isfinite(r.white), axis=0) | whole
    if np.iscomplexobj(r.data):
        weighted = _impedance(r, base, complex_weight(r))  # as the residual's, which turns Re and Im
        terms = {n: np.concatenate([x.real[good], x.imag[good]]) for n, x in weighted.items()}
        return terms, np.concatenate([r.white[0][good], r.white[1][good]])
    terms = _motion(r) if {"t", "z"} <= set(r.inputs) else _stiffness(r)
    return {n: x[good] for n, x in terms.items()}, r.white[0][good]


def _impedance(r: Record, base: Mapping[str, Any], weight: npt.NDArray[Any]) -> Terms:
    """First-order changes of Z by elements at the terminals, and in the motional branch where it can be
    told."""
    w = 2 * np.pi * r.inputs["f"]
    x, Z = 1j * w / w.max(), r.data
    terms = {
        "coil_ac_resistance": (w / w.max()) ** 2,
        "leakage_inductance": x,
        "semi_inductance": x**0.5,
        "eddy_shunt": x**2,
        "coil_capacitance": x * Z**2,
        "sensor_delay": x * Z,
        "temperature_drift": np.linspace(0, 1, len(w)),
    }
    if {"R_e", "L_e"} <= set(base):
        motional = (Z - base["R_e"]["value"] - 1j * w * base["L_e"]["value"]) ** 2
        more = {"contact_damping": 1.0, "inertia": x, "structural_damping": 1 / np.abs(x)}
        terms |= {n: motional * g for n, g in more.items()}
    return {n: np.asarray(v * weight, complex) for n, v in terms.items()}


def _motion(r: Record) -> Terms:
    """Functions of position, speed, acceleration and time."""
    t, z = r.inputs["t"], r.inputs["z"]
    v = np.gradient(z, t)
    return {
        "asymmetric_stiffness": z**2,
        "cubic_stiffness": z**3,
        "contact_damping": v,
        "quadratic_damping": v * np.abs(v),
        "inertia": np.gradient(v, t),
        "stribeck_friction": np.sign(v) * np.exp(-np.abs(v) / (0.1 * np.abs(v).max())),
        "offset_drift": t - t.mean(),
        "temperature_drift": (t - t.mean()) * z,
        "stress_softening": z * np.cumsum(np.abs(np.diff(z, prepend=z[0]))),
        "payne_softening": z * np.abs(z),
    }


def _stiffness(r: Record) -> Terms:
    """Functions of frequency for the stiffness k_s."""
    w = r.inputs["f"] / r.inputs["f"].max()
    return {
        "inertia": w**2,
        "power_law_viscoelasticity": w**0.5,
        "structural_damping": np.log(w),
        "payne_softening": np.ones_like(w),
        "temperature_drift": np.linspace(0, 1, len(w)),
    }
