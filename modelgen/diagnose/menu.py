"""Recordings that could be made next: other bands, loads, amplitudes, rates, and quieter or longer ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from modelgen.errors import InputError
from modelgen.fit.series import Array, Series
from modelgen.language import Model, Parameter
from modelgen.units import factor

REACH = 5.0
"""How much further than now a band, a rate may reach."""
LOAD = 1.5
BLOCKED = 1e6
"""A moving mass so many times its value lets nothing move."""
SAMPLES = 1500
"""Samples of a planned record in time; its noise is reduced to make up for those that a full one has more."""


@dataclass(frozen=True, eq=False)
class Plan:
    """A recording: what is done, in words; recorded inputs (n,); values known there; noise over today's.

    averaged: nothing but the noise is other than now.
    """

    says: str
    inputs: Mapping[str, Array]
    constants: Mapping[str, float] = field(default_factory=dict)
    quiet: float = 1.0
    averaged: bool = False


def plans(model: Model, series: Sequence[Series], k: int, known: Mapping[str, float]) -> tuple[Plan, ...]:
    """What could be recorded next in the manner of recording `k`.

    known: values of all parameters there, fitted or not; those that a fit can't change are in its constants.
    """
    if not model.axis:
        return ()
    made = _motions(model, series[k]) if model.is_time_model else _sweeps(model, series, k, known)
    return tuple(made)


# -- along frequency -----------------------------------------------------------------------------------------


def _sweeps(model: Model, series: Sequence[Series], k: int, known: Mapping[str, float]) -> Iterator[Plan]:
    axis = model.axis
    f = series[k].inputs[axis]
    low = min(float(s.inputs[axis].min()) for s in series)
    high = max(float(s.inputs[axis].max()) for s in series)
    same = {i.name: series[k].inputs[i.name] for i in model.inputs if i.derived is None}
    unit = next(i.unit for i in model.inputs if i.name == axis)
    count = int(np.clip(len(f), 100, 400))
    level = {name: np.full(count, np.median(x)) for name, x in same.items()}

    def band(a: float, b: float) -> Plan:
        says = f"a sweep from {_value(a, unit)} to {_value(b, unit)}"
        return Plan(says, {**level, axis: np.geomspace(a, b, count)})

    yield band(low, REACH * high)
    yield band(low / REACH, high)
    yield band(low / REACH, REACH * high)
    yield Plan("the same sweep averaged 16 times", same, quiet=0.25, averaged=True)
    mass = next((p for p in model.scalar_parameters if _has_unit(p, "kg")), None)
    if mass is not None and mass.name in series[k].constants:
        more = LOAD * known[mass.name]
        says = f"a second sweep with {LOAD - 1:.0%} more mass ({mass.name} = {_value(more, mass.unit)})"
        yield Plan(says, same, {mass.name: more})
    if mass is not None and any(p.name == "electrical" for p in model.ports):
        yield Plan(
            "the same sweep with the moving side blocked", same, {mass.name: BLOCKED * known[mass.name]}
        )
    for name in {v.name for p in model.ports for key, v in p.variables if key == "amplitude"}:
        for ratio in (3.0, 1 / 3):
            value = ratio * known[name]
            yield Plan(
                f"the same sweep at {name} = {_value(value, model.parameter(name).unit)}", same, {name: value}
            )


def _has_unit(p: Parameter, unit: str) -> bool:
    try:
        factor(p.unit, unit)
    except InputError:
        return False
    return True


# -- along time ----------------------------------------------------------------------------------------------


def _motions(model: Model, s: Series) -> Iterator[Plan]:
    axis = model.axis
    driven = [i for i in model.inputs if i.derived is None and i.name != axis]
    t, x = _short(s.inputs[axis], {i.name: s.inputs[i.name] for i in driven})
    quiet = float(np.sqrt(min(1.0, len(t) / s.n)))
    middle = {n: 0.5 * (v.max() + v.min()) for n, v in x.items()}
    half = {n: 0.5 * float(np.ptp(v)) for n, v in x.items()}
    at = ", ".join(_value(half[i.name], i.unit) for i in driven)

    def motion(says: str, t: Array, x: Mapping[str, Array]) -> Plan:
        return Plan(says, {axis: t, **x}, quiet=quiet)

    def scaled(by: float) -> dict[str, Array]:
        return {n: middle[n] + by * (v - middle[n]) for n, v in x.items()}

    unit = model.inputs[0].unit
    length = float(t[-1] - t[0])
    yield motion(f"the same motion {REACH:g} times as fast", t[0] + (t - t[0]) / REACH, x)
    yield motion(f"the same motion {REACH:g} times as slow", t[0] + (t - t[0]) * REACH, x)
    yield motion(f"the same motion at twice the amplitude (± {at} now)", t, scaled(2.0))
    yield motion(f"the same motion at a third of the amplitude (± {at} now)", t, scaled(1 / 3))
    yield motion(
        f"the same motion about a mean that is higher by {at}", t, {n: v + half[n] for n, v in x.items()}
    )
    yield Plan("the same motion averaged 16 times", {axis: t, **x}, quiet=quiet / 4, averaged=True)
    rise = 0.5 - 0.5 * np.cos(np.pi * np.clip((t - t[0] - 0.05 * length) / (0.03 * length), 0.0, 1.0))
    step = {n: middle[n] + half[n] * (2 * rise - 1) for n in x}
    yield motion(f"a step from end to end of the stroke, held for {_value(0.92 * length, unit)}", t, step)
    long, again = _thrice(t, x)
    yield motion(f"the same motion three times over, {_value(3 * length, unit)} in one record", long, again)


def _short(t: Array, x: Mapping[str, Array]) -> tuple[Array, dict[str, Array]]:
    """At most SAMPLES samples of a record: the first half or more of it, thinned."""
    keep = slice(None, None, max(1, len(t) // (2 * SAMPLES)))
    return t[keep][:SAMPLES], {n: v[keep][:SAMPLES] for n, v in x.items()}


def _thrice(t: Array, x: Mapping[str, Array]) -> tuple[Array, dict[str, Array]]:
    """Forth, back and forth again, without a jump, in three times the time."""
    after = np.cumsum(np.concatenate([np.diff(t)[::-1], np.diff(t)]))
    ways = {n: np.concatenate([v, v[-2::-1], v[1:]]) for n, v in x.items()}
    return np.concatenate([t, t[-1] + after]), ways


def _value(x: float, unit: str) -> str:
    """A number with three digits and its unit, in kHz and MHz where that is shorter."""
    for prefix, size in (("M", 1e6), ("k", 1e3)):
        if unit == "Hz" and x >= size:
            return f"{x / size:.3g} {prefix}Hz"
    return f"{x:.3g} {unit}" if unit != "1" else f"{x:.3g}"
