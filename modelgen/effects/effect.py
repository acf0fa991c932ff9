"""What an effect is: a few lines of physics that change one kind of port, with parameters whose null value
changes nothing."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from math import inf
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from modelgen.effects.motion import partners
from modelgen.errors import InputError
from modelgen.language import Abs, Model, Parameter, Port, j
from modelgen.units import converts, electrical, factor, tidy

Values = Mapping[str, Parameter]
Apply = Callable[[Model, Port, Values], Model]

ANY = (-inf, inf)
"""Bounds of a strength of either sign."""

FIRST, BESIDE, AROUND, BEFORE, UPON = range(-1, 4)
"""Turns of effects: what acts on the base alone; a term of its own; what all of a material does (waves run in
it), or a shunt around it; what is in series with all behind it; what depends on how far the whole moves."""

TURNS = {FIRST: "FIRST", BESIDE: "BESIDE", AROUND: "AROUND", BEFORE: "BEFORE", UPON: "UPON"}

RARER = 0.1
"""`Effect.common` of a further law of an id, which is the first one over again where an effect is faint or
sharp: without clear evidence for what is its own the first serves, and it is no more reason for the name."""


@dataclass(frozen=True)
class Strength:
    """The parameter that says how much of the effect there is; at `null` the old model is back exactly.

    `unit` may hold {port}, the names of the port's variables in braces, e.g. "{port}/{z}**3", and at
    mechanical ports in the frequency domain {impedance} and {stiffness} (force over velocity and over
    displacement in the port's units); {force} is the unit of the model's force. `scale`, `low`, `high`,
    `points` are as in `Shape`, for effects that are screened at a finite strength; elsewhere the range ends
    the strength's own `bounds`.
    """

    name: str
    unit: str
    null: float = 0.0
    bounds: tuple[float, float] = (0.0, inf)
    text: str = ""
    scale: str = ""
    low: float = 0.1
    high: float = 10.0
    points: int = 4
    log: bool = True


@dataclass(frozen=True)
class Shape:
    """A parameter that says of which shape the effect is; it means nothing while the strength is null.

    It is searched from `low` × the smallest to `high` × the largest value of `scale` in the recordings.
    Scales: "omega" (angular frequency), "time" (1/omega up to the length of the record), "duration" (length
    of each record), "cycles" (length of those whose motion comes back a few times), "samples" (their number
    in each), "displacement" (half the stroke of each record), "speed" (the greatest of each record),
    "position" (the recorded range of the displacement), "port" (modulus of the port's quantity, by the base
    fit), "mass" (of a mechanical port, that quantity as a mass), "1" (plain numbers: low and high as they
    are), or an expression in these such as "port/max(omega)**2". `points` values are tried first, evenly in
    the logarithm unless `log` is False. `within`: no fit leaves that range, where the motion is recorded.
    """

    name: str
    unit: str
    scale: str
    low: float
    high: float
    points: int = 8
    log: bool = True
    text: str = ""
    within: bool = False


def search_range(q: Strength | Shape, scales: Mapping[str, ArrayLike]) -> tuple[float, float]:
    """From where to where `q` is searched; `scales` maps the names that `Shape` lists to values in the
    recordings.

    Raises KeyError when a scale is missing.
    """
    if q.scale == "1":
        return q.low, q.high
    known = {n: np.asarray(x, dtype=float) for n, x in scales.items()}
    code = compile(q.scale, q.name, "eval")
    tools: dict[str, Any] = {"__builtins__": {}, "max": np.max, "min": np.min, "median": np.median}
    missing = set(code.co_names) - set(known) - set(tools)
    if missing:
        raise KeyError(f"no scale {', '.join(sorted(missing))} for '{q.name}'")
    values = eval(code, tools, known)
    return q.low * float(np.min(values)), q.high * float(np.max(values))


@dataclass(frozen=True)
class Effect:
    """One piece of physics that a model may have left out.

    `apply(model, port, p)` returns the model with the effect at `port`; `p` maps the short names of
    `strengths` and `shapes` to the declared parameters (their full names carry the effect's id, so that
    effects compose), which the model has by then. `kinds` are in order of preference: a model with ports of
    several gets the effect at the first. `needs` names the port variables that the effect uses; a port
    without them is none for it; `lacks` those of ports that other laws of the id are for; `also` the kinds
    of other ports that the model must have, `unless` those that it must not; `amid` the units of which it
    must have a parameter, `without` those of which it must have none. Several effects may share one id: laws
    of the same physics, none of which is a special case of another in disguise. `secant` marks effects whose
    derivative at null vanishes, or knows nothing of what they do at a finite strength: they are screened
    there. `family` is what one kind of recording can often not tell apart; `common` > 1 says that
    practitioners meet it often. `alike` are ids of other physics whose law is the same function of the
    motion: no recording of this kind tells them apart. `instead`: ids that this law is an account instead
    of, and never beside: free as it is, it would take up what their laws are not quite right about. `each`:
    strengths have a value of their own in each repeat of a sweep, null in the first one unless `first`; with
    `levels`, in each recording, repeat or not. `units`: the port's quantity must be in one of these, or a
    plain number: a magnet pulls with a force.
    `acts`: at which turn, where several effects are composed: on what those of lower turns have made of the
    port.
    """

    id: str
    kinds: tuple[str, ...]
    says: str
    source: str
    strengths: tuple[Strength, ...]
    apply: Apply
    shapes: tuple[Shape, ...] = ()
    needs: tuple[str, ...] = ()
    lacks: tuple[str, ...] = ()
    also: tuple[str, ...] = ()
    unless: tuple[str, ...] = ()
    amid: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    family: str = ""
    secant: bool = False
    common: float = 1.0
    alike: tuple[str, ...] = ()
    instead: tuple[str, ...] = ()
    each: bool = False
    first: bool = False
    levels: bool = False
    units: tuple[str, ...] = ()
    acts: int = BESIDE

    def fits(self, model: Model) -> tuple[Port, ...]:
        """The ports of `model` that this effect can be added to: those of the first of its kinds that there
        is."""
        present = {p.kind for p in model.ports}
        if not set(self.also) <= present or present & set(self.unless) or not self._at_home(model):
            return ()
        for kind in self.kinds:
            there = tuple(
                p
                for p in model.ports
                if p.kind == kind
                and set(self.needs) <= {n for n, _ in p.variables}
                and not set(self.lacks) & {n for n, _ in p.variables}
                and self._is_of(model[p.equation].unit)
            )
            if there:
                return there
        return ()

    def _at_home(self, model: Model) -> bool:
        """Whether the model has parameters in the units that it must, and none in those that it must not."""
        units = [p.unit for p in model.scalar_parameters]

        def has(unit: str) -> bool:
            return any(converts(u, unit) for u in units)

        return all(map(has, self.amid)) and not any(map(has, self.without))

    def _is_of(self, unit: str) -> bool:
        """Whether a quantity in this unit may have the effect."""
        return not self.units or any(converts(unit, u) for u in (*self.units, "1"))

    def parameters(self, model: Model, port: Port) -> dict[str, Parameter]:
        """The effect's parameters as declared in a model: short name → Parameter with unit, bounds and
        source."""
        units = {k: unit_of(model, v) for k, v in port.variables}
        units |= _port_units(port, model[port.equation].unit)
        units["force"] = next((model[q.equation].unit for q in partners(model, port, "force")), "N")
        declared: dict[str, Parameter] = {}
        quantities: tuple[Strength | Shape, ...] = (*self.strengths, *self.shapes)
        for q in quantities:
            unit = q.unit.format(**{k: f"({u})" for k, u in units.items()})
            null = q.null if isinstance(q, Strength) else None
            bounds = q.bounds if isinstance(q, Strength) else ((0.0, inf) if q.log else (-inf, inf))
            if isinstance(q, Strength) and null == 0 and bounds[0] == 0 and _answers(model, port):
                bounds = (-bounds[1], bounds[1])
            if isinstance(q, Shape) and q.scale == "1":
                bounds = (q.low, q.high)
            declared[q.name] = Parameter(
                f"{self.id}_{q.name}", _tidy(unit), null, bounds, text=q.text, source=self.source
            )
        return declared

    def extend(self, model: Model, port: Port) -> Model:
        """`model` with this effect at `port`. The effect's parameters are named `<id>_<short name>`."""
        p = self.parameters(model, port)
        return self.apply(model.with_parameters(*p.values()), port, p)


def change(how: Callable[[Any, Port, Values], Any]) -> Apply:
    """An `apply` which turns the port's quantity x into how(x, port, p)."""
    return lambda model, port, p: model.extend(port.equation, lambda x: how(x, port, p))


def add(what: Callable[[Port, Values], Any]) -> Apply:
    """An `apply` which adds what(port, p) to the port's quantity."""
    return change(lambda x, port, p: x + what(port, p))


def add_impedance(what: Callable[[Port, Values], Any]) -> Apply:
    """Add a mechanical impedance, force over velocity, at a port of kind mechanical_impedance or
    stiffness."""
    return add(lambda at, p: what(at, p) * (j * at["omega"] if at.kind == "stiffness" else 1))


def add_stiffness(what: Callable[[Port, Values], Any]) -> Apply:
    """Add a complex stiffness, force over displacement, at a port of kind stiffness or
    mechanical_impedance."""
    return add(lambda at, p: what(at, p) / (1 if at.kind == "stiffness" else j * at["omega"]))


def at_most(x: Any, most: float) -> Any:
    """The smaller of both; sympy's Min takes long over what composed effects make of x."""
    return (x + most - Abs(x - most)) / 2


def unit_omega(model: Model) -> Model:
    """`model` with the constant `unit_omega` = 1 rad/s, by which powers of frequency are made numbers."""
    return model.with_parameters(UNIT_OMEGA)


UNIT_OMEGA = Parameter("unit_omega", "rad/s", 1.0, (0.5, 2.0), "the unit 1 rad/s", "SI", known=True)


ANSWERS = ("m", "1", "C", "C/m**2", "T")
"""Displacement, strain, charge, polarisation, flux density: what gives way to a drive."""


def _answers(model: Model, port: Port) -> bool:
    """Whether a port of kind "force" is one of what answers to a drive, as a displacement to a voltage or the
    force of a piezo to it.

    Memory and loss make a force go before the displacement; what answers to a drive lags behind it: strengths
    that can have one sign in a force have the other one there.
    """
    if port.kind != "force":
        return False
    unit = model[port.equation].unit
    drive = next((unit_of(model, x) for n, x in port.variables if n == "z"), unit)
    return any(converts(unit, u) for u in ANSWERS) or (electrical(drive) and not electrical(unit))


def _port_units(port: Port, unit: str) -> dict[str, str]:
    stiff = port.kind == "stiffness"
    return {
        "port": unit,
        "stiffness": unit if stiff else f"{unit}/s",
        "impedance": f"{unit}*s" if stiff else unit,
    }


def unit_of(model: Model, variable: Any) -> str:
    """The unit of a port variable, which is an input, a parameter or an equation of the model."""
    name = getattr(variable, "name", str(variable))
    for q in (*model.inputs, *model.scalar_parameters, *model.statements):
        if q.name == name:
            return q.unit
    return "1"


NAMED = ("1", "kg", "H", "F", "ohm", "1/ohm", "N/m", "m/N", "N", "N·m", "s")


@lru_cache(maxsize=1024)
def _tidy(unit: str) -> str:
    """A unit as people write it: "(N)/(mm)**3" → "N/mm³", "(N·s/m)*s" → "kg"."""
    for name in NAMED:
        try:
            if abs(factor(unit, name) - 1) < 1e-12:
                return name
        except InputError:
            continue
    return tidy(unit)
