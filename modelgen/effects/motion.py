"""The recorded motion of a time model, as effects use it, and which ports share one."""

from typing import Any

from sympy import Symbol, sympify

from modelgen.errors import InputError
from modelgen.language import Abs, Input, Model, Port
from modelgen.language.meant import expressions

MOTION = ("z", "v", "z_prev", "z_turn")
"""What a port calls its displacement, its rate, and the displacement a sample before and at the turn."""


def moved_input(model: Model, port: Port) -> Input:
    """The recorded displacement that a port of a time model follows."""
    rate = moved_rate(model, port)
    return next(i for i in model.inputs if rate.derived and i.name == rate.derived[1])


def moved_rate(model: Model, port: Port) -> Input:
    """The rate of the recorded displacement that a port follows. Raises InputError where none is recorded."""
    rates = [i for i in model.inputs if i.derived and i.derived[0] == "rate"]
    if not rates:
        raise InputError(f"model '{model.id}' has no input that is the rate of another")
    if len(rates) == 1:
        return rates[0]
    own = _reached(model, [x for key, x in port.variables if key in MOTION] or _at(port))
    return next((i for i in rates if i.derived and i.derived[1] in own), rates[0])


def moved_inputs(model: Model) -> set[Input]:
    """All displacements that are recorded with a rate."""
    names = {i.derived[1] for i in model.inputs if i.derived and i.derived[0] == "rate"}
    return {i for i in model.inputs if i.name in names}


def partner(model: Model, port: Port, kind: str) -> Port:
    """The first of the `partners`. Raises InputError without any."""
    found = partners(model, port, kind)
    if not found:
        raise InputError(f"model '{model.id}' has no port of kind '{kind}' beside '{port.name}'")
    return found[0]


def partners(model: Model, port: Port, kind: str) -> list[Port]:
    """The ports of `kind` that act on the same part of a model as `port`: of several those that are nearest,
    as one is in what the other is made of, or they follow the same recordings."""
    found = [q for q in model.ports if q.kind == kind]
    if len(found) < 2:
        return found
    mine = _reached(model, _at(port))
    inputs = {i.name for i in model.inputs if i.name != model.axis}

    def apart(q: Port) -> tuple[bool, int]:
        theirs = _reached(model, _at(q))
        return q.equation not in mine and port.equation not in theirs, -len(mine & theirs & inputs)

    away = [apart(q) for q in found]
    return [q for q, x in zip(found, away, strict=True) if x == min(away)]


def nearest_port(model: Model, parameter: str) -> Port | None:
    """The port that says least besides what a parameter does; None where no port depends on it."""
    q = model.parameter(parameter.partition("[")[0])
    name = q.part[1] if q.part else q.name
    reached = [(len(found), p) for p in model.ports if name in (found := _reached(model, _at(p)))]
    return min(reached, key=lambda x: x[0], default=(0, None))[1]


def _at(port: Port) -> list[Any]:
    return [Symbol(port.equation), *(x for _, x in port.variables)]


def _reached(model: Model, of: list[Any]) -> set[str]:
    """Names of all that expressions are made of, however deep; of derived inputs, what they follow from."""
    made = {s.name: s for s in model.statements}
    follows = {i.name: i.derived[1] for i in model.inputs if i.derived}
    found: set[str] = set()
    left = [x.name for e in of for x in sympify(e).free_symbols]
    while left:
        name = left.pop()
        if name in found:
            continue
        found.add(name)
        left += [follows[name]] if name in follows else []
        left += [x.name for e in expressions(made[name]) for x in e.free_symbols] if name in made else []
    return found


def way(port: Port) -> Any:
    """The way there and back since the sample before."""
    return Abs(port["z_turn"] - port["z_prev"]) + Abs(port["z"] - port["z_turn"])
