"""A plain reading of models: their statements one after the other, in Python. Shares no code with code
generation."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import jv

from modelgen.language import Equation, Implicit, Model
from modelgen.recordings.envelope import amplitude, quadrature


def _powj(w: Any, n: Any) -> Any:
    return (1j * w) ** n


def _eddy_factor(p: Any) -> Any:
    x = np.sqrt(-1j * np.where(p == 0, 1e-16, p))
    return 2 * jv(1, x) / (x * jv(0, x))


def _dahl_step(u: Any, x: Any, b: float) -> Any:
    if np.ndim(u) or np.ndim(x):
        return np.vectorize(_dahl_step)(u, x, b)
    if b == 1 or u <= 0:
        return u * math.exp(-x)
    base = u ** (1 - b) + (b - 1) * x
    return base ** (1 / (1 - b)) if base > 0 else 0.0


def _bouc_wen_step(q: float, x: float, n: float, sigma: float) -> float:
    done = solve_ivp(
        lambda _, q: 1 - (1 if q[0] > 0 else 1 - 2 * sigma) * abs(q[0]) ** n,
        (0, x),
        [q],
        rtol=1e-12,
        atol=1e-14,
    )
    return float(done.y[0][-1])


def _sinhc(x: Any) -> Any:
    return np.where(x == 0, 1.0, np.sinh(x) / np.where(x == 0, 1.0, x))


OWN = {
    "powj": _powj,
    "eddy_factor": _eddy_factor,
    "dahl_step": _dahl_step,
    "bouc_wen_step": _bouc_wen_step,
    "sinhc": _sinhc,
    "sign": np.sign,
    "re": np.real,
    "im": np.imag,
}


class Reading:
    """A model made ready to be evaluated."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.library = [OWN, "math" if model.axis == "t" else "numpy"]
        self.compiled: dict[Any, Any] = {}

    def value(self, expr: Any, env: dict[str, Any]) -> Any:
        if expr not in self.compiled:
            symbols = sorted(expr.free_symbols, key=lambda s: s.name)
            names = [s.name for s in symbols]
            self.compiled[expr] = (names, sp.lambdify(symbols, expr, self.library, cse=True))
        names, f = self.compiled[expr]
        return f(*(env[n] for n in names))

    def __call__(self, inputs: dict[str, Any], **parameters: float) -> dict[str, Any]:
        """Every quantity of the model at all samples."""
        p = {q.name: q.default for q in self.model.scalar_parameters} | parameters
        for q in self.model.parameters:
            if q.name not in p:
                p[q.name] = p[f"{q.name}_re"] + 1j * p[f"{q.name}_im"]
        inputs = inputs | {
            i.name: {"amplitude": amplitude, "quadrature": quadrature}[i.derived[0]](inputs[i.derived[1]])
            for i in self.model.inputs
            if i.name not in inputs and i.derived
        }
        if not self.model.states and self.model.axis != "t":
            return self._run(p | inputs, None)
        rows: list[dict[str, Any]] = []
        for k in range(len(next(iter(inputs.values())))):
            sample = {n: float(x[k]) for n, x in inputs.items()}
            rows.append(self._run(p | sample, rows[-1] if rows else None))
        return {n: np.array([r[n] for r in rows]) for n in rows[0]}

    def _run(self, env: dict[str, Any], before: dict[str, Any] | None) -> dict[str, Any]:
        for s in self.model.states:
            env[s.name] = before[s.name] if before else self.value(s.initial, env)
        for s in self.model.statements:
            if isinstance(s, Equation):
                try:
                    env[s.name] = self.value(s.expr, env)
                except ZeroDivisionError:  # no time has passed before the first sample
                    env[s.name] = math.nan
            elif isinstance(s, Implicit):
                env[s.name] = self._root(s, env)
            elif before:
                env[s.name] = self.value(s.update, env)
        return env

    def _root(self, s: Implicit, env: dict[str, Any]) -> Any:
        shape = np.shape(env[self.model.axis])
        ends = [np.broadcast_to(self.value(b, env), shape).ravel() for b in s.bracket]
        roots = []
        for k, (a, b) in enumerate(zip(*ends, strict=True)):
            here = {n: x[k] if np.ndim(x) else x for n, x in env.items()}
            roots.append(
                brentq(lambda u, e=here: float(self.value(s.residual, e | {s.name: u})), a, b, xtol=1e-15)
            )
        return np.reshape(roots, shape)
