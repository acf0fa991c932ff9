"""A model with other values as its defaults."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from modelgen.language.model import Model
from modelgen.language.quantities import ComplexParameter, Parameter


def with_defaults(model: Model, values: Mapping[str, float]) -> Model:
    """`model` with `values`, by name, as defaults, and bounds that hold them."""
    new: list[Parameter | ComplexParameter] = []
    for p in model.parameters:
        if isinstance(p, ComplexParameter):
            new.append(replace(p, re=_with(p.re, values), im=_with(p.im, values)))
        else:
            new.append(_with(p, values))
    return replace(model, parameters=tuple(new))


def _with(p: Parameter, values: Mapping[str, float]) -> Parameter:
    value = values.get(p.name, p.default)
    if value is None:
        return p
    return replace(p, default=value, bounds=(min(p.bounds[0], value), max(p.bounds[1], value)))
