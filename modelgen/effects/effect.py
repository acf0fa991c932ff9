"""What an effect is: a few lines of physics that change one kind of port, with parameters whose null value changes nothing."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import inf
from typing import Any

from modelgen.language import Model, Parameter, Port


@dataclass(frozen=True)
class Strength:
    """The parameter that says how much of the effect there is; at `null` the old model is back exactly.

    `unit` may hold {port} and the names of the port's variables in braces, e.g. "{port}/{z}**3".
    `of` scales the search: the strength at which the effect is of the size of the port's own quantity is near
    1 × the typical value of the named data scale expression, see `diagnose.scales`; "" leaves it to the data.
    """

    name: str
    unit: str
    null: float = 0.0
    bounds: tuple[float, float] = (0.0, inf)
    text: str = ""


@dataclass(frozen=True)
class Shape:
    """A parameter that says of which shape the effect is; it means nothing while the strength is null.

    It is searched from `low` × the smallest to `high` × the largest value of `scale` in the recordings. Scales:
    "omega" (angular frequency), "time" (1/omega up to the length of the record), "displacement" (deviation from mid-stroke),
    "speed", "1" (plain numbers: low and high as they are), "position" (the recorded range of the displacement).
    `points` values are tried first, evenly in the logarithm unless `log` is False.
    """

    name: str
    unit: str
    scale: str
    low: float
    high: float
    points: int = 8
    log: bool = True
    text: str = ""


@dataclass(frozen=True)
class Effect:
    """One piece of physics that a model may have left out.

    `apply(model, port, p)` returns the model with the effect at `port`; `p` maps the short names of `strengths` and
    `shapes` to the declared parameters (their full names carry the effect's id, so that effects compose).
    `secant` marks effects whose derivative by the strength vanishes at null: they are screened at a finite strength.
    `family` is what one kind of recording can often not tell apart; `common` > 1 says that practitioners meet it often.
    """

    id: str
    kinds: tuple[str, ...]
    says: str
    source: str
    strengths: tuple[Strength, ...]
    apply: Callable[[Model, Port, Mapping[str, Parameter]], Model]
    shapes: tuple[Shape, ...] = ()
    family: str = ""
    secant: bool = False
    common: float = 1.0

    def fits(self, model: Model) -> tuple[Port, ...]:
        """The ports of `model` that this effect can be added to (the first of a kind and name only)."""
        return tuple(p for p in model.ports if p.kind in self.kinds)

    def parameters(self, model: Model, port: Port) -> dict[str, Parameter]:
        """The effect's parameters as declared in a model: short name → Parameter with unit, bounds and source."""
        units = {"port": model[port.equation].unit, **{k: _unit_of(model, v) for k, v in port.variables}}
        declared: dict[str, Parameter] = {}
        for q in (*self.strengths, *self.shapes):
            unit = q.unit.format(**{k: f"({u})" for k, u in units.items()})
            null = q.null if isinstance(q, Strength) else None
            bounds = q.bounds if isinstance(q, Strength) else ((0.0, inf) if q.log else (-inf, inf))
            if isinstance(q, Shape) and q.scale == "1":
                bounds = (q.low, q.high)
            declared[q.name] = Parameter(
                f"{self.id}_{q.name}", _tidy(unit), null, bounds, text=q.text, source=self.source
            )
        return declared

    def extend(self, model: Model, port: Port) -> Model:
        """`model` with this effect at `port`. The effect's parameters are named `<id>_<short name>`."""
        p = self.parameters(model, port)
        new = self.apply(model, port, p)
        missing = [q for q in p.values() if q.name not in {x.name for x in new.scalar_parameters}]
        return new.with_parameters(*missing) if missing else new


def _unit_of(model: Model, variable: Any) -> str:
    """The unit of a port variable, which is an input, a parameter or an equation of the model."""
    name = getattr(variable, "name", str(variable))
    for q in (*model.inputs, *model.scalar_parameters, *model.statements):
        if q.name == name:
            return q.unit
    return "1"


def _tidy(unit: str) -> str:
    """A unit as people write it: "(N)/(mm)**3" → "N/mm³"."""
    from modelgen.units import tidy

    return tidy(unit)
