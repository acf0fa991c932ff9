"""A Gaussian process for what the base misses (Kennedy and O'Hagan 2001), with nothing of physics in it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.optimize import minimize

from modelgen.prove.records import Array, Record

POINTS = 240
"""Points that the process is conditioned on, spread evenly over the recordings."""


def explain(fit: Sequence[Record], held: Sequence[Record]) -> dict[str, Any]:
    """Whether a discrepancy is there (evidence against white residuals by BIC), and what it leaves of each
    held-out residual."""
    x, y = _gathered(fit)
    centre, spread = x.mean(axis=0), np.maximum(x.std(axis=0), 1e-12)
    x = (x - centre) / spread
    keep = np.linspace(0, len(x) - 1, min(POINTS, len(x))).astype(int)
    x, y = x[keep], y[keep]
    start = np.concatenate([[np.log(max(np.std(y), 1e-3))], np.zeros(x.shape[1])])
    low = [(-9.0, 12.0), *[(-4.0, 4.0)] * x.shape[1]]
    found = minimize(_cost, start, args=(x, y), method="L-BFGS-B", bounds=low, options={"maxiter": 40})
    none = 0.5 * float(np.sum(y**2))
    gain = 2 * (none - float(found.fun)) - len(start) * np.log(y.size)
    missing = bool(gain > 0)
    rest = [r.white for r in held]
    if missing:
        rest = [r.white - _predicted(found.x, x, y, (_inputs(r) - centre) / spread).T for r in held]
    return {"found": missing, "name": None, "rest": rest}


def _gathered(cases: Sequence[Record]) -> tuple[Array, Array]:
    """Inputs (n, d) and whitened residuals (n, channels): over ln f; in time over position and speed."""
    xs, ys = [], []
    for r in cases:
        good = np.all(np.isfinite(r.white), axis=0)
        xs.append(_inputs(r)[good])
        ys.append(r.white.T[good])
    return np.concatenate(xs), np.concatenate(ys)


def _inputs(r: Record) -> Array:
    if "f" in r.inputs:
        return np.log(r.inputs["f"])[:, None]
    t, z = r.inputs["t"], r.inputs["z"]
    return np.column_stack([z, np.gradient(z, t)])


def _kernel(theta: Array, a: Array, b: Array) -> Array:
    away = ((a[:, None] - b[None]) / np.exp(theta[1:])) ** 2
    return np.asarray(np.exp(2 * theta[0] - 0.5 * away.sum(axis=2)))


def _cost(theta: Array, x: Array, y: Array) -> float:
    """-ln of the marginal likelihood over unit noise, without constants; channels share the kernel."""
    try:
        factor = cho_factor(_kernel(theta, x, x) + np.eye(len(x)), lower=True)
    except LinAlgError:
        return 1e12
    whole = float(np.sum(y * cho_solve(factor, y)))
    return 0.5 * whole + y.shape[1] * float(np.sum(np.log(np.diag(factor[0]))))


def _predicted(theta: Array, x: Array, y: Array, new: Array) -> Array:
    weights = np.linalg.solve(_kernel(theta, x, x) + np.eye(len(x)), y)
    parts = np.array_split(new, max(1, len(new) // 2000))
    return np.concatenate([_kernel(theta, p, x) @ weights for p in parts])
