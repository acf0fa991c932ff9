"""A model and its recordings with the clock in seconds and frequency in hertz, as effects, ladders and lines
count them, and speeds in what they are of per second: a model's own may run in milliseconds, kilohertz or
radians per second, and its speeds in millimetres per minute."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from sympy import Symbol

from modelgen.language import Equation, Input, Model, Parameter, State, Statement
from modelgen.language.derived import PER_TIME, per
from modelgen.language.model import substituted
from modelgen.language.write import free
from modelgen.recordings import Case, Noise, Recording
from modelgen.recordings.convert import affine, is_frequency, is_time


def in_seconds(model: Model, case: Case) -> tuple[Model, Case]:
    """Both over seconds, or hertz; as they are where they already run so, or over something else."""
    axis = next((i for i in model.inputs if i.name == model.axis), None)
    wanted = "" if axis is None else "s" if is_time(axis.unit) else "Hz" if is_frequency(axis.unit) else ""
    if axis is None or not wanted:
        return model, case
    by = affine(axis.unit, wanted)[0]
    if by != 1.0:
        taken = {q.name for q in (*model.inputs, *model.parameters, *model.statements)}
        clock = _ratio(free("clock", taken), axis.unit, wanted, 1 / by)
        clocks = {i.name for i in model.inputs if i is axis or (i.derived and i.derived[1] == axis.name)}
        rerun = _read_as(model, dict.fromkeys(clocks, wanted), clock, slower=clock)
        model = _angular(rerun, axis, clock, free("omega", taken)) if wanted == "Hz" else rerun
        records = tuple(_rescaled(r, axis.name, by) for r in case.recordings)
        case = replace(case, recordings=records, noise=_noise(case.noise, axis.name, by))
    return _per_second(model) if wanted == "s" else model, case


def _per_second(model: Model) -> Model:
    """`model` whose speeds and accelerations are in units of what they are of per second."""
    units = {i.name: i.unit for i in model.inputs}
    for i in model.inputs:
        kind, of = i.derived or ("", "")
        if kind not in PER_TIME:
            continue
        wanted = f"({units[of]})" + "/s" * PER_TIME[kind]
        by = per(units[of], "s", PER_TIME[kind], i.unit)
        if abs(by - 1) < 1e-12:
            continue
        taken = {q.name for q in (*model.inputs, *model.parameters, *model.statements)}
        model = _read_as(model, {i.name: wanted}, _ratio(free(f"per_{i.name}", taken), i.unit, wanted, by))
    return model


def _ratio(name: str, old: str, new: str, count: float) -> Parameter:
    return Parameter(name, f"({old})/({new})", count, known=True, text=f"{old} in one {new}")


def _read_as(
    model: Model, units: Mapping[str, str], scale: Parameter, slower: Parameter | None = None
) -> Model:
    """`model` with inputs in other `units`, of which one is `scale` old ones, that says what it said before;
    `slower`: its rates are per a time that is so many times as long."""
    old = {x: x * scale.symbol for n in units for x in (Symbol(n), Symbol(n, real=True))}
    statements = tuple(_rerun(s, old, slower) for s in model.statements)
    known = model if statements == model.statements else model.with_parameters(scale)
    inputs = tuple(replace(i, unit=units.get(i.name, i.unit)) for i in model.inputs)
    return replace(known, inputs=inputs, statements=statements)


def _angular(model: Model, axis: Input, per: Parameter, name: str) -> Model:
    """`model` whose ports, where they take the axis itself for ω, have it as it was, called `name`."""
    if not any(str(x) == axis.name for p in model.ports for _, x in p.variables):
        return model
    omega = Equation(name, axis.symbol * per, axis.unit, text="angular frequency")
    ports = (
        replace(p, variables=tuple((k, omega.symbol if str(x) == axis.name else x) for k, x in p.variables))
        for p in model.ports
    )
    known = model.with_parameters(per)
    return replace(known, statements=(omega, *model.statements), ports=tuple(ports))


def _rerun(s: Statement, old: Mapping[Any, Any], slower: Parameter | None) -> Statement:
    """A statement that reads new inputs as it read the `old` ones."""
    new = substituted(s, old)
    if slower is None or not isinstance(new, State) or new.rate is None:
        return new
    return replace(new, rate=new.rate * slower.symbol)


def _rescaled(r: Recording, axis: str, by: float) -> Recording:
    inputs = {n: x * by if n == axis else x for n, x in r.inputs.items()}
    return replace(r, inputs=inputs, noise=_noise(r.noise, axis, by))


def _noise(noise: Noise, axis: str, by: float) -> Noise:
    return replace(noise, sigma={n: x * by if n == axis else x for n, x in noise.sigma.items()})
