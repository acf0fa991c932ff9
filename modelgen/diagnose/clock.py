"""A model and its recordings with the clock in seconds and frequency in hertz, as effects, ladders and lines
count them: a model's own may run in milliseconds, kilohertz or radians per second."""

from __future__ import annotations

from dataclasses import replace

from sympy import Symbol

from modelgen.language import Equation, Implicit, Input, Model, Parameter, Statement
from modelgen.language.write import free
from modelgen.recordings import Case, Noise, Recording
from modelgen.recordings.convert import affine, is_frequency, is_time


def in_seconds(model: Model, case: Case) -> tuple[Model, Case]:
    """Both over seconds, or hertz; as they are where they already run so, or over something else."""
    axis = next((i for i in model.inputs if i.name == model.axis), None)
    wanted = "" if axis is None else "s" if is_time(axis.unit) else "Hz" if is_frequency(axis.unit) else ""
    if axis is None or not wanted or (by := affine(axis.unit, wanted)[0]) == 1.0:
        return model, case
    taken = {q.name for q in (*model.inputs, *model.parameters, *model.statements)}
    units = f"{axis.unit} in one {wanted}"
    per = Parameter(free("clock", taken), f"({axis.unit})/{wanted}", 1 / by, known=True, text=units)
    clocks = {i.name for i in model.inputs if i is axis or (i.derived and i.derived[1] == axis.name)}
    rerun = replace(
        model,
        inputs=tuple(replace(i, unit=wanted) if i.name in clocks else i for i in model.inputs),
        parameters=(*model.parameters, per),
        statements=tuple(_rerun(s, clocks, per) for s in model.statements),
    )
    if rerun.statements == model.statements:  # the clock is in none of them
        rerun = replace(rerun, parameters=model.parameters)
    if wanted == "Hz":
        rerun = _angular(rerun, axis, per, free("omega", taken))
    records = tuple(_rescaled(r, axis.name, by) for r in case.recordings)
    return rerun, replace(case, recordings=records, noise=_noise(case.noise, axis.name, by))


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


def _rerun(s: Statement, clocks: set[str], per: Parameter) -> Statement:
    """A statement that reads the new clock as it read the old one; rates are per second."""
    old = {x: x * per.symbol for n in clocks for x in (Symbol(n), Symbol(n, real=True))}
    if isinstance(s, Equation):
        return replace(s, expr=s.expr.xreplace(old))
    if isinstance(s, Implicit):
        low, high = (x.xreplace(old) for x in s.bracket)
        return replace(s, residual=s.residual.xreplace(old), bracket=(low, high))
    update = None if s.update is None else s.update.xreplace(old)
    rate = None if s.rate is None else s.rate.xreplace(old) * per.symbol
    return replace(s, initial=s.initial.xreplace(old), update=update, rate=rate)


def _rescaled(r: Recording, axis: str, by: float) -> Recording:
    inputs = {n: x * by if n == axis else x for n, x in r.inputs.items()}
    return replace(r, inputs=inputs, noise=_noise(r.noise, axis, by))


def _noise(noise: Noise, axis: str, by: float) -> Noise:
    return replace(noise, sigma={n: x * by if n == axis else x for n, x in noise.sigma.items()})
