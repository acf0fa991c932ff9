"""A second, slow reading of models: their statements by mpmath at 40 digits, without code generation.

What generated code is measured against, in exported self-tests and in the tests of this project.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from typing import Any

import mpmath as mp
import numpy as np
import sympy as sp
from mpmath.libmp import NoConvergence

from modelgen.codegen.integrate import Slopes, rosenbrock, runge_kutta
from modelgen.errors import InputError
from modelgen.language import Equation, Implicit, Model, State
from modelgen.language.derived import values_before
from modelgen.language.meant import expressions
from modelgen.language.quantities import BACKWARD

DIGITS = 40
FAILURES = (InputError, ArithmeticError, ValueError, TypeError, NoConvergence)
"""What `run` raises where a model has no value."""


def eddy_factor(p: Any) -> Any:
    if p == 0:
        return mp.mpf(1)
    x = mp.sqrt(-1j * p)
    return 2 * mp.besselj(1, x) / (x * mp.besselj(0, x))


def dahl_step(u: Any, x: Any, b: Any) -> Any:
    if b == 1:
        return u * mp.exp(-x)
    if u <= 0:
        return u
    base = u ** (1 - b) + (b - 1) * x
    return base ** (1 / (1 - b)) if base > 0 else mp.mpf(0)


def bouc_wen_step(q: Any, x: Any, n: Any, sigma: Any) -> Any:
    """The way from 0 to q is q 2F1(1, 1/n; 1 + 1/n; c|q|ⁿ); inverted by Newton steps, in s = −ln(1 − q) on
    loading."""

    def way(y: Any) -> Any:
        c = 1 if y > 0 else 1 - 2 * sigma
        if n == 1:
            return -mp.sign(y) * mp.log1p(-c * abs(y)) / c if c else y
        return y * mp.hyp2f1(1, 1 / n, 1 + 1 / n, c * abs(y) ** n)

    def rate(y: Any) -> Any:
        return 1 - (1 if y > 0 else 1 - 2 * sigma) * abs(y) ** n

    if x == 0 or q >= 1:
        return q
    wanted, tiny = way(q) + x, mp.mpf(10) ** (2 - mp.mp.dps)
    loading = wanted > 0
    at = max(-mp.log1p(-q), mp.mpf(0)) if loading else min(q + rate(q) * x, mp.mpf(0))
    for _ in range(100):
        end = -mp.expm1(-at) if loading else at
        if end == 1:  # to all digits
            return end
        miss = (wanted - way(end)) * rate(end) * (mp.exp(at) if loading else 1)
        at += miss
        if abs(miss) <= tiny:
            break
    return -mp.expm1(-at) if loading else at


FUNCTIONS = {
    "eddy_factor": eddy_factor,
    "eddy_deficit": lambda p: (1 - eddy_factor(p)) / (1j * p) if p else mp.mpf(1) / 8,
    "dahl_step": dahl_step,
    "bouc_wen_step": bouc_wen_step,
    "sinhc": lambda x: mp.sinh(x) / x if x else mp.mpf(1),
    "gamma": mp.gamma,
    "digamma": mp.digamma,
    "powj": lambda w, n: mp.power(1j * w, n),
    "cpow": mp.power,
    "clog": mp.log,
}
"""The language's functions that sympy has not, by name."""


def run(model: Model, samples: Sequence[Mapping[str, Any]], **values: Any) -> list[dict[str, Any]]:
    """Every quantity at each sample. Parameters not in `values` have their default.

    Derived inputs must be given, but for the value before and the turning point.
    """
    with mp.workdps(DIGITS):
        return _run(model, samples, values)


def _run(
    model: Model, samples: Sequence[Mapping[str, Any]], values: Mapping[str, Any]
) -> list[dict[str, Any]]:
    parameters = {p.name: mp.mpf(repr(p.default)) for p in model.scalar_parameters if p.name not in values}
    parameters |= {k: mp.mpmathify(v) for k, v in values.items()}
    for p in model.parameters:
        if p.name not in parameters:
            parameters[p.name] = mp.mpc(parameters[f"{p.name}_re"], parameters[f"{p.name}_im"])
    results: list[dict[str, Any]] = []
    for sample in samples:
        env = parameters | {k: mp.mpmathify(v) for k, v in sample.items()}
        before = results[-1] if results else None
        for i in model.inputs:
            if i.derived and i.derived[0] in BACKWARD and i.name not in env:
                env[i.name] = (before or env)[i.derived[1]]
        for state in model.states:
            env[state.name] = before[state.name] if before else _value(state.initial, env)
        if before:
            env |= _integrate(model, env)
        for s in model.statements:
            if isinstance(s, Equation):
                env[s.name] = _value(s.expr, env)
            elif isinstance(s, Implicit):
                env[s.name] = _root(s, env)
            elif before and s.update is not None:
                env[s.name] = _value(s.update, env)
        results.append(env)
    return results


def _integrate(model: Model, env: Mapping[str, Any]) -> dict[str, Any]:
    """States with a rate over one step, by the scheme that the language defines."""
    rated = [s for s in model.states if s.rate is not None]
    if not rated:
        return {}
    before = {of: n for n, of in values_before(model).items()}
    names, steps = [s.name for s in rated], max(s.substeps for s in rated)

    def rates(s: Any, x: list[Any]) -> list[Any]:
        inputs = {n: env[p] + s * (env[n] - env[p]) for n, p in before.items()}
        return _rates(model, rated, {**env, **inputs, **dict(zip(names, x, strict=True))})

    def slopes(s: Any, x: list[Any]) -> Slopes:
        def along(k: int) -> list[Any]:
            return _slope(lambda e: rates(s, [*x[:k], x[k] + e, *x[k + 1 :]]))

        columns = [along(k) for k in range(len(x))]
        return Slopes(rates(s, x), list(zip(*columns, strict=True)), _slope(lambda e: rates(s + e, x)))

    end, H = [env[n] for n in names], env[model.axis] - env[before[model.axis]]
    for k in range(steps):
        if any(s.stiff for s in rated):
            end = rosenbrock(rates, slopes, end, H, steps, k)
        else:
            end = runge_kutta(rates, end, H, steps, k)
    return dict(zip(names, end, strict=True))


STABLE = 2.785
"""|λ|h up to which the classical scheme of order 4 damps what decays, on the negative axis."""


def stable_step(model: Model, sample: Mapping[str, Any], **values: Any) -> float:
    """The longest step over which states with a rate are integrated stably, by their equations' slopes at a
    first sample; inf where an L-stable scheme is used, or nothing is integrated."""
    rated = [s for s in model.states if s.rate is not None]
    if not rated or any(s.stiff for s in rated):
        return float("inf")
    with mp.workdps(DIGITS):
        env = _run(model, [sample], values)[0]
        at = [env[s.name] for s in rated]

        def along(k: int, e: Any) -> list[Any]:
            moved = {s.name: v + e * (i == k) for i, (s, v) in enumerate(zip(rated, at, strict=True))}
            return _rates(model, rated, {**env, **moved})

        columns = [[complex(x) for x in _slope(partial(along, k))] for k in range(len(rated))]
    if not np.all(np.isfinite(columns)):
        return float("inf")
    fastest = float(np.max(np.abs(np.linalg.eigvals(columns))))
    return STABLE * max(s.substeps for s in rated) / fastest if fastest else float("inf")


def _slope(f: Callable[[Any], list[Any]]) -> list[Any]:
    """df/de at e = 0, right to twice the digits in use, by a difference in four times as many."""
    digits = mp.mp.dps
    with mp.workdps(4 * digits):
        e = mp.mpf(10) ** -digits
        return [(a - b) / (2 * e) for a, b in zip(f(e), f(-e), strict=True)]


def _rates(model: Model, rated: Sequence[State], env: dict[str, Any]) -> list[Any]:
    for s in model.statements:
        names = {x.name for e in expressions(s) for x in e.free_symbols}
        if isinstance(s, Equation) and names <= set(env):
            env[s.name] = _value(s.expr, env)
        elif isinstance(s, Implicit) and names - {s.name} <= set(env):
            env[s.name] = _root(s, env)
    return [_value(s.rate, env) for s in rated]


@cache
def _compiled(expr: Any) -> tuple[list[str], Any]:
    symbols = list(expr.free_symbols)
    return [s.name for s in symbols], sp.lambdify(symbols, expr, [FUNCTIONS, "mpmath"], dummify=True)


def _value(expr: Any, env: Mapping[str, Any]) -> Any:
    names, function = _compiled(expr)
    return mp.mpmathify(function(*(env[n] for n in names)))


def _root(s: Implicit, env: Mapping[str, Any]) -> Any:
    def residual(x: Any) -> Any:
        return _value(s.residual, {**env, s.name: x})

    low, high = (_value(b, env) for b in s.bracket)
    if not residual(low) * residual(high) <= 0:
        raise InputError(f"'{s.name}': no change of sign in its bracket")
    return mp.findroot(residual, (low, high), solver="anderson", tol=mp.mpf(10) ** -70, verify=False)
