"""Units of recorded columns, where a plain factor would be silently wrong."""

from __future__ import annotations

import math
from typing import Any

from modelgen.errors import InputError
from modelgen.units import factor, parse, registry


def affine(found: str, wanted: str) -> tuple[float, float]:
    """(a, b) so that a value x in `found` is a·x + b in `wanted`.

    Beyond a plain factor: degC, degF have an offset; rad/s, rpm and deg/s are 2π, 60 and 360 per Hz, where
    Pint, which holds an angle to be a pure number, would read 1 rad/s as 1 Hz.
    Raises InputError for an unknown unit, another dimension, a logarithmic unit, a pure number for an angle,
    and for 1/s where the other counts radians.
    """
    from_unit, to_unit = parse(found), parse(wanted)
    if not from_unit.is_compatible_with(to_unit):
        if found.lower().startswith("db"):
            raise InputError(
                f"unit '{found}' is a level over a reference that it doesn't name; wanted '{wanted}', "
                "the reference times 10**(level/20)"
            )
        raise InputError(f"unit '{found}' can't be read as '{wanted}'")
    try:
        converted = (registry().Quantity(x, from_unit).to(to_unit) for x in (0.0, 1.0, 2.0))
        zero, one, two = (float(x.magnitude) for x in converted)
    except Exception as why:  # Pint refuses some products of offset units
        raise InputError(f"unit '{found}' can't be converted to '{wanted}' by a factor") from why
    if abs(two - 2 * one + zero) > 1e-9 * max(abs(zero), abs(one), abs(two)):
        raise InputError(f"unit '{found}' is logarithmic; wanted a linear unit such as '{wanted}'")
    if abs(zero) > 1e-12 * abs(one):
        return one - zero, zero
    return factor(found, wanted) * _turns(found, from_unit, wanted, to_unit), 0.0


def linear(unit: str) -> str:
    """The unit as it is. Raises InputError for one that is unknown or logarithmic."""
    base = registry().Quantity(1.0, parse(unit)).to_base_units().units
    affine(unit, "1" if base.dimensionless else str(base))
    return unit


def is_frequency(unit: str) -> bool:
    """Whether a unit counts events per time."""
    return bool(parse(unit).dimensionality == registry().Unit("Hz").dimensionality)


def is_time(unit: str) -> bool:
    """Whether a unit is one of time."""
    return bool(parse(unit).dimensionality == registry().Unit("s").dimensionality)


def _turns(found: str, from_unit: Any, wanted: str, to_unit: Any) -> float:
    """2π or its inverse where one unit counts radians and the other turns."""
    angles = _angle_power(from_unit) - _angle_power(to_unit)
    if angles == 0:
        return 1.0
    if is_frequency(wanted):
        for unit, plain in ((found, from_unit), (wanted, to_unit)):
            if all(is_time(name) for name in plain._units):
                other = wanted if unit == found else found
                raise InputError(
                    f"unit '{unit}' says neither radians nor turns, and '{other}' does: "
                    f"write 'rad/s' or 'Hz' for '{unit}'"
                )
        return float((2 * math.pi) ** -angles)
    if from_unit.dimensionless:  # tan δ is no angle
        raise InputError(f"unit '{found}' can't be read as '{wanted}'")
    return 1.0


def _angle_power(unit: Any) -> float:
    base: Any = registry().Quantity(1.0, unit).to_base_units().units
    return float(dict(base._units).get("radian", 0))
