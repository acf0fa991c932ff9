"""The recorded motion of a time model, as effects use it."""

from typing import Any

from modelgen.errors import InputError
from modelgen.language import Abs, Input, Model, Port

MOTION = ("z", "v", "z_prev", "z_turn")
"""What a port calls its displacement, its rate, and the displacement a sample before and at the turn."""


def moved_input(model: Model) -> Input:
    """The recorded displacement of a time model."""
    rate = moved_rate(model)
    return next(i for i in model.inputs if rate.derived and i.name == rate.derived[1])


def moved_rate(model: Model) -> Input:
    """The rate of the recorded displacement of a time model. Raises InputError where none is recorded."""
    rates = [i for i in model.inputs if i.derived and i.derived[0] == "rate"]
    if not rates:
        raise InputError(f"model '{model.id}' has no input that is the rate of another")
    return rates[0]


def way(port: Port) -> Any:
    """The way there and back since the sample before."""
    return Abs(port["z_turn"] - port["z_prev"]) + Abs(port["z"] - port["z_turn"])
