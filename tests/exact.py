"""A second, slow reading of models: their statements by mpmath at 40 digits, without code generation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import mpmath as mp
import pytest
import sympy as sp

from modelgen.language import Equation, Implicit, Model, Output

mp.mp.dps = 40
REFERENCE = Path(__file__).parents[2] / "shared" / "reference" / "reference_values.txt"


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


def sinhc(x: Any) -> Any:
    return mp.sinh(x) / x if x else mp.mpf(1)


FUNCTIONS = {"eddy_factor": eddy_factor, "dahl_step": dahl_step, "sinhc": sinhc, "gamma": mp.gamma}


def evaluate(model: Model, upto: str = "", **values: Any) -> dict[str, Any]:
    """Quantities of a model without memory (those after `upto` are left out); parameters as in `run`."""
    if upto:
        at = [s.name for s in model.statements].index(upto) + 1
        model = replace(model, statements=model.statements[:at], outputs=(Output(upto),))
    inputs = {i.name for i in model.inputs}
    return run(model, [{k: v for k, v in values.items() if k in inputs}], **values)[0]


def run(model: Model, samples: Sequence[Mapping[str, Any]], **values: Any) -> list[dict[str, Any]]:
    """Every quantity at each sample. Parameters not in `values` have their default.

    Derived inputs must be given, but for the value before and the turning point.
    """
    parameters = {p.name: mp.mpf(repr(p.default)) for p in model.scalar_parameters}
    parameters |= {k: mp.mpmathify(v) for k, v in values.items()}
    for p in model.parameters:
        if p.name not in parameters:
            parameters[p.name] = mp.mpc(parameters[f"{p.name}_re"], parameters[f"{p.name}_im"])
    results: list[dict[str, Any]] = []
    for sample in samples:
        env = parameters | {k: mp.mpmathify(v) for k, v in sample.items()}
        before = results[-1] if results else None
        for i in model.inputs:
            if i.derived and i.derived[0] in ("previous", "turning") and i.name not in env:
                env[i.name] = (before or env)[i.derived[1]]
        for s in model.states:
            env[s.name] = before[s.name] if before else _value(s.initial, env)
        for s in model.statements:
            if isinstance(s, Equation):
                env[s.name] = _value(s.expr, env)
            elif isinstance(s, Implicit):
                env[s.name] = _root(s, env)
            elif before:
                env[s.name] = _value(s.update, env)
        results.append(env)
    return results


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
    assert residual(low) * residual(high) < 0, f"{s.name}: no change of sign in its bracket"
    return mp.findroot(residual, (low, high), solver="anderson", tol=mp.mpf(10) ** -70, verify=False)


def close(found: Any, wanted: Any, digits: int = 18) -> bool:
    """Whether two numbers (or their decimal texts) agree to that many digits."""
    found, wanted = mp.mpmathify(found), mp.mpmathify(wanted)
    return bool(abs(found - wanted) <= abs(wanted) * mp.mpf(10) ** -digits)


def reference_table() -> dict[str, Any]:
    """The 20-digit reference values by their names; skips the test where there are none."""
    if not REFERENCE.exists():
        pytest.skip("no ../shared/reference/reference_values.txt beside the repository")
    values: dict[str, Any] = {}
    for line in REFERENCE.read_text().splitlines():
        words = line.split()
        if len(words) < 2 or line.startswith("#"):
            continue
        if words[-1].endswith("j"):
            values[" ".join(words[:-2])] = mp.mpc(words[-2], words[-1][:-1])
        else:
            values[" ".join(words[:-1])] = mp.mpf(words[-1])
    return values
