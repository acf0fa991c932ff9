"""Values to try a model at: parameters near their defaults, inputs over a range, motions that turn."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from modelgen.errors import InputError, one_of
from modelgen.export.exact import stable_step
from modelgen.language import Input, Model, Parameter
from modelgen.language.derived import derived_scale
from modelgen.language.quantities import BACKWARD

POINTS = 16
SAMPLES = 64
CALM = 2.0
"""How far a step stays below that at which what is integrated would grow by itself."""
Range = tuple[float, float]


@dataclass(frozen=True)
class Trial:
    """Parameters by name, and samples to be taken in order (one alone where a model remembers nothing)."""

    parameters: dict[str, float]
    samples: tuple[dict[str, float], ...]


def default_of(p: Parameter) -> float:
    """A parameter's default, or a value between its bounds where there is none."""
    if p.default is not None:
        return float(p.default)
    low, high = p.bounds
    if math.isfinite(low) and math.isfinite(high):
        return math.sqrt(low * high) if low > 0 else 0.5 * (low + high)
    return max(low, min(high, 1.0))


def parse_fixed(model: Model, given: Sequence[str]) -> dict[str, float]:
    """NAME=VALUE texts as numbers. Raises InputError in one line."""
    found = {}
    for text in given:
        name, _, value = text.partition("=")
        known = model.parameter(name.strip()).name
        if known in found:
            raise InputError(f"--fix {text}: '{known}' is given twice")
        try:
            found[known] = float(value)
        except ValueError:
            raise InputError(f"--fix {text}: '{value}' is not a number; wanted NAME=VALUE") from None
        if not math.isfinite(found[known]):
            raise InputError(f"--fix {text}: a finite number is wanted")
        low, high = model.parameter(known).bounds
        if not low <= found[known] <= high:
            raise InputError(f"--fix {text}: outside the bounds of '{known}', [{low:g}, {high:g}]")
    return found


def parse_ranges(model: Model, given: Sequence[str]) -> dict[str, Range]:
    """NAME=LOW:HIGH texts. Raises InputError in one line."""
    names = [i.name for i in model.inputs if not i.derived]
    found = {}
    for text in given:
        name, _, ends = text.partition("=")
        name = name.strip()
        if name not in names:
            raise InputError(f"--range {text}: no input '{name}'{one_of(name, names)}")
        if name in found:
            raise InputError(f"--range {text}: '{name}' is given twice")
        try:
            low, high = (float(x) for x in ends.split(":"))
        except ValueError:
            raise InputError(f"--range {text}: wanted NAME=LOW:HIGH, two numbers") from None
        if not (math.isfinite(low) and math.isfinite(high)):
            raise InputError(f"--range {text}: finite numbers are wanted")
        if not low < high:
            raise InputError(f"--range {text}: {low:g} is not below {high:g}")
        found[name] = (low, high)
    return found


def default_range(i: Input) -> Range:
    """The range of its source; else 1 Hz to 10 kHz, one second, or −1 to 1 in the input's unit."""
    if i.range:
        return i.range
    return {"Hz": (1.0, 1e4), "kHz": (1e-3, 10.0), "s": (0.0, 1.0)}.get(i.unit, (-1.0, 1.0))


def trials(
    model: Model,
    fixed: Mapping[str, float],
    ranges: Mapping[str, Range],
    round_to: Callable[[float], float],
    steps: bool,
) -> tuple[Trial, ...]:
    """Values that cover `ranges`, the first at default parameters; the same each time, rounded to a type."""
    rng = np.random.default_rng(1)
    count = 2 if steps else 4
    sets = []
    for k in range(count):
        factors = rng.uniform(0.8, 1.25, len(model.scalar_parameters)) if k else None
        sets.append(_parameters(model, fixed, factors, round_to))
    spans = {i.name: ranges.get(i.name, default_range(i)) for i in model.inputs if not i.derived}
    samples = _motion(model, spans, round_to) if steps else _grid(model, spans, round_to)
    if steps:
        longest = min(stable_step(model, samples[0], **p) for p in sets)
        samples = _motion(model, spans, round_to, longest / CALM)
    return tuple(Trial(p, samples) for p in sets)


def _parameters(
    model: Model, fixed: Mapping[str, float], factors: np.ndarray | None, round_to: Callable[[float], float]
) -> dict[str, float]:
    values = {}
    for k, p in enumerate(model.scalar_parameters):
        value = default_of(p)
        if factors is not None:
            moved = float(f"{value * factors[k]:.4g}")
            narrow = p.bounds[1] - p.bounds[0] < 0.5 * abs(value)
            value = value if narrow or not p.bounds[0] <= moved <= p.bounds[1] else moved
        values[p.name] = fixed[p.name] if p.name in fixed else round_to(value)
    return values


def _grid(
    model: Model, spans: Mapping[str, Range], round_to: Callable[[float], float]
) -> tuple[dict[str, float], ...]:
    """Points along all inputs at once, evenly in the logarithm where an input is positive."""
    rows: list[dict[str, float]] = []
    for k in range(POINTS if model.inputs else 1):
        s = k / (POINTS - 1)
        row = {}
        for n, (name, (low, high)) in enumerate(spans.items()):
            at = s if n == 0 else (s * (2 * n + 1) + 0.37 * n) % 1.0
            row[name] = low * (high / low) ** at if low > 0 else low + (high - low) * at
        row |= {i.name: 0.5 + s for i in model.inputs if i.derived and i.derived[0] not in BACKWARD}
        rows.append({n: round_to(float(f"{v:.6g}")) for n, v in row.items()})
    return tuple(rows)


def _motion(
    model: Model, spans: Mapping[str, Range], round_to: Callable[[float], float], longest: float = math.inf
) -> tuple[dict[str, float], ...]:
    """Two tones that turn several times, and their derivatives; time in steps that any type holds exactly,
    none longer than `longest`."""
    low, high = spans[model.axis]
    step = 2.0 ** math.floor(math.log2(min((high - low) / SAMPLES, longest)))
    rows = []
    for k in range(SAMPLES):
        x = 4 * math.pi * k / SAMPLES
        rate = 4 * math.pi / (SAMPLES * step)
        row = {model.axis: low + k * step}
        for n, (name, (a, b)) in enumerate(list(spans.items())[1:]):
            half, y = 0.5 * (b - a), x + 0.7 * n
            values = {
                "": 0.5 * (a + b) - half * (0.75 * math.cos(y) + 0.25 * math.cos(2.6 * y)),
                "rate": half * rate * (0.75 * math.sin(y) + 0.65 * math.sin(2.6 * y)),
                "acceleration": half * rate**2 * (0.75 * math.cos(y) + 1.69 * math.cos(2.6 * y)),
                "amplitude": half,
                "quadrature": half * math.sin(y),
            }
            row[name] = values[""]
            row |= {
                i.name: values[i.derived[0]] * derived_scale(model, i)
                for i in model.inputs
                if i.derived and i.derived[1] == name and i.derived[0] in values
            }
        rows.append({n: round_to(v if n == model.axis else float(f"{v:.6g}")) for n, v in row.items()})
    return tuple(rows)
