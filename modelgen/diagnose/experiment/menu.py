"""Recordings that could be made next: other bands, loads, amplitudes, rates, and quieter or longer ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from modelgen.errors import InputError
from modelgen.fit.series import Array, Series
from modelgen.language import Model, Parameter
from modelgen.units import factor

FAST, SLOW = {5.0: 1.0, 25.0: 2.0, 100.0: 3.0}, {5.0: 1.5, 25.0: 5.0}
"""How much further up, or down, than now a band, a rate may reach, and what that costs: what is slow takes
long."""
HARD = 100.0
"""How much faster no motion of the present amplitude can be."""
LOADS = {1.5: 1.0, 4.0: 1.5, 0.5: 2.0, 0.1: 2.5}
"""Moving masses over the present one, and what they cost. Less is offered where there are loads to take
off."""
BLOCKED = 1e6
"""A moving mass so many times its value lets nothing move."""
TIMES = (16, 100)
"""How often a recording may be repeated and averaged."""
SAMPLES = 1500
"""Samples of a planned record in time; its noise is reduced to make up for those that a full one has more."""
DEAREST = 8.0
"""Cost up to which plans are thought of: each change of the present recording costs about one."""


@dataclass(frozen=True, eq=False)
class Plan:
    """A recording: what is done, in words; recorded inputs (n,); values known there; noise over today's.

    cost: roughly the trouble of making it. averaged: how often it is repeated. same: nothing else than the
    noise differs from the present recording; again: nothing else than its order, too.
    """

    says: str
    inputs: Mapping[str, Array]
    constants: Mapping[str, float] = field(default_factory=dict)
    quiet: float = 1.0
    cost: float = 1.0
    averaged: int = 1
    same: bool = False
    again: bool = False

    def repeated(self, times: int) -> Plan:
        """This, averaged over so many repetitions."""
        comma = "" if self.same else ","
        cost = self.cost + (1.0 if times < 50 else 2.0)
        says = f"{self.says}{comma} averaged {times} times"
        return replace(self, says=says, quiet=self.quiet / times**0.5, cost=cost, averaged=times)


def plans(model: Model, series: Sequence[Series], k: int, known: Mapping[str, float]) -> tuple[Plan, ...]:
    """What could be recorded next in the manner of recording `k`, each once, the least trouble first.

    known: values of all parameters there, fitted or not; those that a fit can't change are in its constants.
    """
    if not model.axis:
        return ()
    made = list(_motions(model, series[k]) if model.is_time_model else _sweeps(model, series, k, known))
    return tuple(sorted((p for p in made if p.cost <= DEAREST), key=lambda p: p.cost))


def often(plan: Plan) -> list[Plan]:
    """The plan made once, where that is more than the present recording, and averaged ones."""
    return [p for p in (plan, *map(plan.repeated, TIMES)) if 0 < p.cost <= DEAREST]


# -- along frequency -----------------------------------------------------------------------------------------


def _sweeps(model: Model, series: Sequence[Series], k: int, known: Mapping[str, float]) -> Iterator[Plan]:
    """Every band with every load, and at other amplitudes; the first is the sweep as it is."""
    here = {i.name: series[k].inputs[i.name] for i in model.inputs if i.derived is None}
    bands = [("the same sweep", here, 0.0), *_bands(model, series, k, here)]
    sizes = sorted({v.name for p in model.ports for key, v in p.variables if key == "amplitude"})
    back = {n: x[::-1] for n, x in here.items()}
    yield Plan("the same sweep in the other direction", back, cost=0.5, again=True)
    for says, inputs, cost in bands:
        yield Plan(says, inputs, cost=cost, same=cost == 0)
        for words, constants, more in _loads(model, series, k, known):
            sweep = says if "same" in says and "blocked" in words else says.replace("the same", "a second")
            yield Plan(f"{sweep} {words}", inputs, constants, cost=cost + more)
        for name, ratio in ((n, r) for n in sizes for r in (3.0, 1 / 3)):
            value = ratio * known[name]
            words = f"at {name} = {_value(value, model.parameter(name).unit)}"
            yield Plan(f"{says} {words}", inputs, {name: value}, cost=cost + 1.0)


def _bands(
    model: Model, series: Sequence[Series], k: int, here: Mapping[str, Array]
) -> Iterator[tuple[str, dict[str, Array], float]]:
    """(words, inputs, cost) of bands that reach further up, further down, and both."""
    axis = model.axis
    low = min(float(s.inputs[axis].min()) for s in series)
    high = max(float(s.inputs[axis].max()) for s in series)
    unit = next(i.unit for i in model.inputs if i.name == axis)
    count = int(np.clip(series[k].n, 100, 400))
    level = {name: np.full(count, np.median(x)) for name, x in here.items()}
    reaches = [(1.0, up, cost) for up, cost in FAST.items()]
    reaches += [(down, up, cost + (up > 1)) for down, cost in SLOW.items() for up in (1.0, down)]
    reaches.append((5.0, 100.0, 4.0))
    for down, up, cost in reaches:
        says = f"a sweep from {_value(low / down, unit)} to {_value(up * high, unit)}"
        yield says, {**level, axis: np.geomspace(low / down, up * high, count)}, cost


def _loads(
    model: Model, series: Sequence[Series], k: int, known: Mapping[str, float]
) -> Iterator[tuple[str, dict[str, float], float]]:
    """(words, values known, cost) of other moving masses, and of a moving side that is held."""
    mass = next((p for p in model.scalar_parameters if _has_unit(p, "kg")), None)
    if mass is None:
        return
    loaded = len({s.constants.get(mass.name) for s in series}) > 1
    for load, cost in LOADS.items() if mass.name in series[k].constants else ():
        if load > 1 or loaded:
            value, how = load * known[mass.name], "more" if load > 1 else "less"
            words = f"with {abs(load - 1):.0%} {how} mass ({mass.name} = {_value(value, mass.unit)})"
            yield words, {mass.name: value}, cost
    if any(p.name == "electrical" for p in model.ports):
        yield "with the moving side blocked", {mass.name: BLOCKED * known[mass.name]}, 1.5


def _has_unit(p: Parameter, unit: str) -> bool:
    try:
        factor(p.unit, unit)
    except InputError:
        return False
    return True


# -- along time ----------------------------------------------------------------------------------------------


def _motions(model: Model, s: Series) -> Iterator[Plan]:
    """The motion as it is, at other rates and amplitudes, about another mean, held, and repeated."""
    axis = model.axis
    driven = [i for i in model.inputs if i.derived is None and i.name != axis]
    t, x = _short(s.inputs[axis], {i.name: s.inputs[i.name] for i in driven})
    quiet = float(np.sqrt(min(1.0, len(t) / s.n)))
    middle = {n: 0.5 * (v.max() + v.min()) for n, v in x.items()}
    half = {n: 0.5 * float(np.ptp(v)) for n, v in x.items()}
    at = ", ".join(_value(half[i.name], i.unit) for i in driven)

    def motion(says: str, t: Array, x: Mapping[str, Array], cost: float = 1.0) -> Plan:
        return Plan(says, {axis: t, **x}, quiet=quiet, cost=cost, same=cost == 0)

    unit = model.inputs[0].unit
    length = float(t[-1] - t[0])
    sizes = {
        "": (x, 0.0),
        f" at 1.5 times the amplitude (± {at} now)": (
            {n: middle[n] + 1.5 * (v - middle[n]) for n, v in x.items()},
            1.0,
        ),
        f" at a third of the amplitude (± {at} now)": (
            {n: middle[n] + (v - middle[n]) / 3 for n, v in x.items()},
            1.0,
        ),
    }
    for words, (path, cost) in sizes.items():
        yield motion(f"the same motion{words}", t, path, cost)
        for way, how in ((FAST, "fast"), (SLOW, "slow")):
            for reach, more in way.items():
                if how == "fast" and reach >= HARD and "third" not in words:
                    continue
                says = f"the same motion {reach:g} times as {how}{words}"
                by = 1 / reach if how == "fast" else reach
                yield motion(says, t[0] + (t - t[0]) * by, path, cost + more)
    higher = {n: v + half[n] for n, v in x.items()}
    yield motion(f"the same motion about a mean that is higher by {at}", t, higher)
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
    """A number with three digits and its unit, in kHz, MHz or GHz where that is shorter."""
    for prefix, size in (("G", 1e9), ("M", 1e6), ("k", 1e3)):
        if unit == "Hz" and x >= size:
            return f"{x / size:.3g} {prefix}Hz"
    return f"{x:.3g} {unit}" if unit != "1" else f"{x:.3g}"
