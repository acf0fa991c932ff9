"""C in single precision: the double program, token by token, so that the two cannot drift apart."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

MATH = frozenset((
    "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "ceil", "cos", "cosh", "erf", "exp", "expm1",
    "fabs", "floor", "fmax", "fmin", "fmod", "hypot", "lgamma", "log", "log1p", "pow", "sin", "sinh", "sqrt",
    "tan", "tanh", "tgamma",
))  # fmt: skip
_TOKEN = re.compile(
    r"(?P<skip>/\*.*?\*/|\(double\)(?=worst)|\"(?:\\.|[^\"\\])*\"|^\#include.*?$)"
    r"|(?P<number>(?<![\w.])(?:\d+\.\d*|\.\d+|\d+(?=[eE]))(?:[eE][+-]?\d+)?)"
    r"|(?P<word>\b[A-Za-z_]\w*\b)",
    re.S | re.M,
)


def single(text: str) -> str:
    """`text` with float for double, expf for exp, 1.0f for 1.0; comments stay as they are.

    A constant that no float can hold becomes infinity or zero, as its conversion at run time would.
    """
    return _TOKEN.sub(_token, text)


def literal(value: float, real: str) -> str:
    """A number as a C literal of that type that reads back exactly."""
    from modelgen.codegen.ctext import number

    return single(number(value)) if real == "float" else number(value)


def rounder(real: str) -> Callable[[float], float]:
    """The nearest number that the type holds, or infinity."""

    def nearest(x: float) -> float:
        with np.errstate(over="ignore"):
            return float(np.float32(x))

    return nearest if real == "float" else float


def _token(match: re.Match[str]) -> str:
    kind, text = match.lastgroup, match.group()
    if kind == "word":
        if text in MATH:
            return f"{text}f"
        return {"double": "float", "DBL_MAX": "FLT_MAX", "DBL_EPSILON": "FLT_EPSILON"}.get(text, text)
    if kind == "number":
        with np.errstate(over="ignore", under="ignore"):
            value = np.float32(text)
        if np.isinf(value):
            return "INFINITY"
        shortest = repr(float(str(value)))
        return f"{shortest}f" if any(ch in shortest for ch in ".e") else f"{shortest}.0f"
    return text
