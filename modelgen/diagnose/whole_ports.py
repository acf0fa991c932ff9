"""What a model leaves unsaid of its ports, though its recordings tell it: how a motion goes on beside where
it is, that an output was recorded through a sensor, the angular frequency. Without it few effects would find
a place.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from sympy import Symbol

from modelgen.effects.motion import MOTION
from modelgen.language import (
    Equation,
    Input,
    Model,
    Port,
    State,
    Statement,
    acceleration_of,
    j,
    pi,
    previous,
    rate_of,
    turning_point_of,
)
from modelgen.language.model import substituted
from modelgen.language.write import free
from modelgen.recordings.convert import is_time
from modelgen.units import converts

OSCILLATING = (
    "terminals", "electrical_impedance", "inductance", "capacitance", "mechanical_impedance", "stiffness",
    "transduction",
)  # fmt: skip
"""Kinds of ports over frequency."""
PER_OMEGA = {"inductance": ("L", "H"), "capacitance": ("C", "F")}
"""Kinds of ports that may be told by their impedance."""


def whole(model: Model) -> Model:
    """`model` with what its ports lack.

    Over frequency that is ω, of an inductance or a capacitance told by its impedance what it is itself, and
    that what an impedance has in series lies within its terminals. Over time, force and sensor ports get the
    time and that of the sample before; a force port that names a recorded motion z gets its rate v,
    acceleration a, and the values before and at the turn; the linkage through which that motion comes gets a
    port for play, and the sensor of each output one of its own, where they have none; and a model
    without memory becomes one whose samples follow each other.
    """
    axis = model.inputs[0] if model.inputs else None
    if axis is None:
        return model
    if not (model.is_time_model or is_time(axis.unit)):
        model = _oscillating(model, axis)
        for port in model.ports:
            if port.kind in PER_OMEGA and converts(model[port.equation].unit, "ohm"):
                model = _per_omega(model, port)
        return _in_series(model)
    if not model.is_time_model:
        model = model.with_inputs(previous(axis))
    for port in model.ports if is_time(axis.unit) else ():
        if port.kind in ("force", "sensor"):
            model = _timed(model, port, axis)
    for port in model.ports:
        if port.kind == "force" and is_time(axis.unit):
            model = _moving(model, port, axis)
    if is_time(axis.unit):
        model = _linked(model)
    if is_time(axis.unit) and not any(p.kind == "sensor" for p in model.ports):
        for output in model.outputs:
            model = _sensed(model, output.name, axis)
    return model


def _oscillating(model: Model, axis: Input) -> Model:
    """`model` over frequency whose ports know the angular frequency."""
    lacking = [p for p in model.ports if p.kind in OSCILLATING and "omega" not in dict(p.variables)]
    if not lacking or not converts(axis.unit, "Hz"):
        return model
    omega = next((s for s in model.statements if isinstance(s, Equation) and s.expr == 2 * pi * axis), None)
    if omega is None:
        taken = {q.name for q in (*model.inputs, *model.parameters, *model.statements)}
        omega = Equation(free("omega", taken), 2 * pi * axis, "rad/s", text="angular frequency")
        model = replace(model, statements=(omega, *model.statements))
    at = ("omega", omega.symbol)
    ports = (replace(p, variables=(*p.variables, at)) if p in lacking else p for p in model.ports)
    return replace(model, ports=tuple(ports))


def _per_omega(model: Model, port: Port) -> Model:
    """`model` in which the inductance, or the capacitance, of a `port` that shows its impedance is an
    equation of its own."""
    s = j * port["omega"]
    kind, unit = PER_OMEGA[port.kind]
    taken = {q.name for q in (*model.inputs, *model.parameters, *model.statements)}
    name = free(f"{kind}_{port.name}", taken)
    own = Symbol(name)

    def inner(Z: Any) -> tuple[Equation]:
        return (Equation(name, Z / s if kind == "L" else 1 / (s * Z), unit, text=f"by {port.equation}"),)

    model = model.extend(port.equation, lambda _: s * own if kind == "L" else 1 / (s * own), statements=inner)
    moved = (replace(p, equation=name) if p is port else p for p in model.ports)
    return replace(model, ports=tuple(moved))


def _in_series(model: Model) -> Model:
    """`model` with a port for what is in series within its terminals, if it says of neither a winding nor a
    capacitance where it is."""
    outside = [p for p in model.ports if p.kind == "terminals"]
    if len(outside) != 1 or {"electrical_impedance", "capacitance"} & {p.kind for p in model.ports}:
        return model
    (port,) = outside
    model, inside = _within(model, port.equation)
    return replace(model, ports=(replace(port, kind="electrical_impedance", equation=inside), *model.ports))


def _within(model: Model, equation: str) -> tuple[Model, str]:
    """`model` in which `equation` shows what another one is, and the name of that: what acts there acts
    before what acts at `equation`."""
    known = {s.name for s in model.statements}
    model = model.extend(equation, lambda x: x)
    return model, next(s.name for s in model.statements if s.name not in known)


def _timed(model: Model, port: Port, axis: Input) -> Model:
    """`model` whose `port` knows the time and that of the sample before."""
    have = dict(port.variables)
    before = _known(model, previous(axis))
    more = tuple((n, i.symbol) for n, i in (("t", axis), ("t_prev", before)) if n not in have)
    fuller = replace(port, variables=(*port.variables, *more))
    model = model.with_inputs(before)
    return replace(model, ports=tuple(fuller if p is port else p for p in model.ports))


def _moving(model: Model, port: Port, axis: Input) -> Model:
    """`model` whose `port` knows all of the motion that it is a force of, if that is recorded. Its rate is
    there at any rate: by it one sees what moves, and how far and fast."""
    z = next((i for i in model.inputs if ("z", i.symbol) in port.variables and not i.derived), None)
    have = dict(port.variables)
    if z is None or z.name == axis.name:
        return model
    speed, time = f"({z.unit})/({axis.unit})", axis.unit
    wanted = {
        "v": rate_of(z, f"{z.name}_rate", speed),
        "a": acceleration_of(z, f"{z.name}_acceleration", f"{speed}/({time})"),
        "z_prev": previous(z),
        "z_turn": turning_point_of(z),
    }
    added = {n: _known(model, i) for n, i in wanted.items() if n not in have or n == "v"}
    more = tuple((n, i.symbol) for n, i in added.items() if n not in have)
    fuller = replace(port, variables=(*port.variables, *more))
    model = model.with_inputs(*added.values())
    return replace(model, ports=tuple(fuller if p is port else p for p in model.ports))


def _linked(model: Model) -> Model:
    """`model` with a port for the linkage that the recorded motion of its force comes through, if none is
    declared: there play is. Not where states are integrated along the motion.

    It doesn't know the time, so that a joint that gives is not asked for: in series with a spring and a
    dashpot that is what a material's relaxation is.
    """
    inputs = {i.symbol: i for i in model.inputs}
    force = next((p for p in model.ports if p.kind == "force" and _recorded(p, inputs)), None)
    rates = any(isinstance(s, State) and s.rate is not None for s in model.statements)
    if force is None or rates or any(p.kind == "displacement" for p in model.ports):
        return model
    taken = {q.name for q in (*model.inputs, *model.parameters, *model.statements)}
    inside = {}
    for key in MOTION:
        i = inputs[force[key]]
        inside[key] = Equation(
            free(f"{i.name}_inside", taken), i, i.unit, text=f"{i.name} behind the linkage"
        )
    swaps = {force[key]: e.symbol for key, e in inside.items()}
    moved = [_behind(s, swaps) for s in model.statements]
    ports = [replace(p, variables=tuple((n, swaps.get(x, x)) for n, x in p.variables)) for p in model.ports]
    at = tuple((n, e.symbol) for n, e in inside.items())
    linkage = Port("displacement", "displacement", inside["z"].name, at)
    return replace(model, statements=(*inside.values(), *moved), ports=(*ports, linkage))


def _recorded(port: Port, inputs: Mapping[Any, Input]) -> bool:
    """Whether all of a port's motion follows from one recorded displacement."""
    have = dict(port.variables)
    if not all(key in have and have[key] in inputs for key in MOTION):
        return False
    z, *others = (inputs[have[key]] for key in MOTION)
    return z.derived is None and all(i.derived is not None and i.derived[1] == z.name for i in others)


def _behind(s: Statement, swaps: Mapping[Any, Any]) -> Statement:
    """A statement of the motion behind the linkage; a state begins with what is recorded."""
    new = substituted(s, swaps)
    return replace(new, initial=s.initial) if isinstance(s, State) and isinstance(new, State) else new


def _known(model: Model, wanted: Input) -> Input:
    """The model's own input that is derived as `wanted` is, or `wanted` under a name that is free."""
    own = next((i for i in model.inputs if i.derived and i.derived == wanted.derived), None)
    if own is not None:
        return own
    if wanted in model.inputs:
        return wanted
    taken = {q.name for q in (*model.inputs, *model.parameters, *model.statements)}
    return replace(wanted, name=free(wanted.name, taken))


def _sensed(model: Model, output: str, axis: Input) -> Model:
    """`model` with a port for the sensor that `output` was recorded with."""
    if not any(isinstance(s, Equation) and s.name == output for s in model.statements):
        return model
    before = _known(model, previous(axis))
    model = model.with_inputs(before)
    if any(p.equation == output for p in model.ports):  # what acts there acts before the sensor
        model, inside = _within(model, output)
        moved = (replace(p, equation=inside) if p.equation == output else p for p in model.ports)
        model = replace(model, ports=tuple(moved))
    at: tuple[tuple[str, Any], ...] = (("t", axis.symbol), ("t_prev", before.symbol))
    name = "sensor" if len(model.outputs) == 1 else f"sensor_{output}"
    name = free(name, {p.name for p in model.ports})
    return replace(model, ports=(*model.ports, Port(name, "sensor", output, at)))
