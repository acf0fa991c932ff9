"""Parameters that vary with a condition of a recording: field on or off, amplitude, temperature."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from modelgen.errors import InputError, did_you_mean
from modelgen.language.model import Model, check_option, substituted
from modelgen.language.quantities import Equation, Parameter, State, Statement

LAWS = ("linear", "power")


def varying(model: Model, names: Sequence[str], condition: Parameter, law: str = "linear") -> Model:
    """The model with each parameter in `names` a function of `condition`, which each recording states.

    "linear": p + p_c c, where c is the condition and p the value at c = 0; with c = 0 and 1 the two levels of
    a switch. "power": p (c/c_ref)^p_c, p the value at c = c_ref, the condition's own default. p_c is called
    after both: k_D_M for k_D with a condition M. A case gives the condition as a constant of each recording,
    and one fit finds p and p_c from all of them. Applied again with another condition it multiplies or adds.
    Raises InputError for an unknown parameter or law, or a power of a condition without a default above 0.
    """
    check_option("law", law, LAWS)
    if law == "power" and not (condition.default or 0) > 0:
        raise InputError(f"condition '{condition.name}': a power law wants a default above 0, its reference")
    have = {p.name for p in model.parameters}
    parts = {p.name for p in model.scalar_parameters}
    for name in names:
        if name in parts - have:
            raise InputError(f"'{name}' is a part of a complex parameter: it cannot vary with a condition")
        if name not in have:
            raise InputError(f"model '{model.id}' has no parameter '{name}'{did_you_mean(name, have)}")
    new = model.with_parameters(*((condition,) if condition.name not in have else ()))
    for name in names:
        new = _one(new, name, condition, law)
    return replace(new, id=f"{model.id}_by_{condition.name}")


def _one(model: Model, name: str, condition: Parameter, law: str) -> Model:
    p = model.parameter(name)
    slope, *reference = _added(p, condition, law)
    value = (
        p.symbol + slope.symbol * condition.symbol
        if law == "linear"
        else p.symbol * (condition.symbol / reference[0].symbol) ** slope.symbol
    )
    at = Equation(f"{name}_at_{condition.name}", value, p.unit, text=f"{name} in this recording")
    statements = (at, *(_changed(s, p, at) for s in model.statements))
    have = {q.name for q in model.parameters}
    added = tuple(q for q in (slope, *reference) if q.name not in have)
    return replace(model, parameters=(*model.parameters, *added), statements=statements)


def _changed(statement: Statement, p: Parameter, at: Equation) -> Statement:
    """`at` in place of p; an initial value stands before all equations and takes its expression."""
    new = substituted(statement, {p.symbol: at.symbol})
    if isinstance(new, State):
        new = replace(new, initial=substituted(statement, {p.symbol: at.expr}).initial)  # type: ignore[union-attr]
    return new


def _added(p: Parameter, condition: Parameter, law: str) -> tuple[Parameter, ...]:
    """The parameter that says how p changes, and the reference of a power law."""
    name = f"{p.name}_{condition.name}"
    if law == "linear":
        unit = p.unit if condition.unit == "1" else f"{p.unit}/({condition.unit})"
        return (Parameter(name, unit, 0.0, text=f"change of {p.name} with {condition.name}"),)
    return (
        Parameter(name, "1", 0.0, text=f"power of {condition.name} in {p.name}"),
        Parameter(
            f"{condition.name}_ref", condition.unit, condition.default, condition.bounds,
            f"where parameters that vary with {condition.name} have their values", known=True,
        ),
    )  # fmt: skip
