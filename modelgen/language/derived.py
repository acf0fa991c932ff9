"""Units of inputs that follow from a recorded one: a speed may be in mm/s where the displacement is in µm."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

from modelgen.errors import InputError, did_you_mean
from modelgen.language.quantities import Input

if TYPE_CHECKING:
    from modelgen.language.model import Model

PER_TIME = {"rate": 1, "acceleration": 2}
"""Kinds of derived input that are divided by the axis, and how often."""
KINDS = (*PER_TIME, "previous", "turning", "amplitude", "quadrature")


def derived_scale(model: Model, i: Input) -> float:
    """By what a derived input is multiplied, once it is formed in the units of what it follows from, to be in
    its own: 1e-3 for a rate in mm/s of µm over s. Raises InputError where no number does it."""
    units = {x.name: x.unit for x in model.inputs}
    kind, of = i.derived or ("", i.name)
    return per(units[of], units[model.axis], PER_TIME.get(kind, 0), i.unit)


@lru_cache(maxsize=4096)
def per(unit: str, time: str, times: int, wanted: str) -> float:
    """How many `wanted` one `unit` is, divided so many `times` by `time`. Raises InputError for none."""
    formed = (unit, f"{unit}/{time}", f"{unit}/{time}**2")[times]
    if wanted == formed:
        return 1.0  # Pint need not be loaded for that
    from modelgen.units import change, unit_text

    try:
        return float((change(unit) / change(time) ** times).to(change(wanted).units).magnitude)
    except Exception as why:  # Pint raises half a dozen kinds: another dimension, a logarithmic unit, …
        text = f"it is in {unit_text(wanted)}, wanted a unit of {unit_text(formed)}"
        raise InputError(text) from why


def values_before(model: Model) -> dict[str, str]:
    """Inputs that hold the value at the sample before, and of which."""
    return {i.name: i.derived[1] for i in model.inputs if i.derived and i.derived[0] == "previous"}


def check_derived(model: Model) -> None:
    """Raise InputError for a derived input of an unknown kind, of no input, or in a wrong unit."""
    names = [i.name for i in model.inputs]
    for i in model.inputs:
        if i.derived is None:
            continue
        where, (kind, of) = f"model '{model.id}', input '{i.name}'", i.derived
        if kind not in KINDS:
            hint = did_you_mean(kind, KINDS) or f", wanted one of {', '.join(KINDS)}"
            raise InputError(f"{where}: unknown kind '{kind}' of derived input{hint}")
        if of not in names:
            raise InputError(f"{where}: '{of}', whose {kind} it is, is no input{did_you_mean(of, names)}")
        try:
            scale = derived_scale(model, i)
        except InputError as why:
            raise InputError(f"{where}, {kind} of '{of}': {why}") from None
        if kind not in PER_TIME and abs(scale - 1) > 1e-9:
            unit = next(x.unit for x in model.inputs if x.name == of)
            raise InputError(f"{where}, {kind} of '{of}': it is in {i.unit}, wanted {unit} as '{of}' is")
