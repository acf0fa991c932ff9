"""Stops: contacts that close at an end of the stroke."""

from dataclasses import replace
from typing import Any

from modelgen.effects.effect import Effect, Shape, Strength, Values, add, at_most, unit_of
from modelgen.language import Abs, Max, Model, Parameter, Port, exp


def _stop(side: int) -> Effect:
    """Contact at an end: in the outer half of the stroke. What acts on more of it is a spring that isn't
    even."""
    end, last = ("upper", "max") if side > 0 else ("lower", "min")
    place = Shape(
        f"z_{end}", "{z}", f"(position + {last}(position))/2", 1.0, 1.0, 12, log=False,
        text="where the contact begins", within=True,
    )  # fmt: skip
    return Effect(
        "end_stop",
        ("force",),
        f"beyond a certain displacement a stop at the {end} end comes into contact: another spring acts, "
        f"on one side only",
        "S. W. Shaw, P. J. Holmes, J. Sound Vib. 90 (1983) 129",
        (Strength(f"k_{end}", "{port}/{z}", text="stiffness of the contact"),),
        add(lambda at, p: side * p[f"k_{end}"] * Max(0, side * (at["z"] - p[f"z_{end}"]))),
        (place,),
        needs=("z",),
    )


def _positive(x: Any) -> Any:
    """x where it is positive, else 0; sympy's Max takes long over what composed effects make of x."""
    return (x + Abs(x)) / 2


def _power_stop(side: int, damped: bool = False) -> Effect:
    """F = ±P (x/1 unit)^m, x the way beyond the contact; damped: P (1 ± λ v) in the place of P."""
    where = "upper" if side > 0 else "lower"
    end, stop = where + ("_damped" if damped else ""), _stop(side)

    def apply(model: Model, port: Port, p: Values) -> Model:
        unit = Parameter(
            "unit_way", unit_of(model, port["z"]), 1.0, (0.5, 2.0), "the unit of way", known=True
        )
        beyond = _positive(side * (port["z"] - p[f"c_{end}"])) / unit
        force = side * p[f"P_{end}"] * (1 + side * p[f"loss_{end}"] * port["v"] if damped else 1)
        return model.with_parameters(unit).extend(
            port.equation, lambda F: F + force * (beyond + 1e-12) ** p[f"m_{end}"]
        )

    loss = Shape(
        f"loss_{end}", "1/({v})", "1/speed", 0.1, 3.0, 3, text="by how much the force grows with speed, λ"
    )
    return replace(
        stop,
        says=stop.says.split(" a stop ")[0] + f" a round or soft stop at the {where} "
        "end comes into contact: its force grows with a power of the way beyond"
        + (", and with speed" if damped else ""),
        source="K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440"
        if damped
        else "H. Hertz, J. reine angew. Math. 92 (1882) 156: 3/2 for round bodies; K. L. Johnson, Contact "
        "Mechanics (1985), ch. 4: other powers for other forms",
        strengths=(Strength(f"P_{end}", "{port}", text="force at unit way beyond the contact"),),
        apply=apply,
        shapes=(
            replace(stop.shapes[0], name=f"c_{end}"),
            Shape(f"m_{end}", "1", "1", 1.05, 2.5, 2, log=False, text="power of the way beyond the contact"),
            *([loss] if damped else []),
        ),
        needs=("z", "v") if damped else ("z",),
        common=0.5 if damped else 1.0,
    )


STEEP = 60.0
"""The largest exponent: a search may ask for a stop that is beyond all motion."""


def _soft_stop(side: int) -> Effect:
    """F = ±G e^(x − 1), x = ±z/l: a stiffness that grows e-fold over a small part of the stroke is a stop."""
    end = "upper" if side > 0 else "lower"

    def law(at: Port, p: Values) -> Any:
        return side * p[f"G_{end}"] * exp(at_most(side * at["z"] / p[f"l_{end}"] - 1, STEEP))

    return replace(
        _stop(side),
        says=f"beyond a certain displacement a soft stop at the {end} end comes into contact: its force "
        "grows exponentially with the way, as of a rubber bumper",
        source="A. N. Gent, Engineering with Rubber (2012), ch. 3: pads and bumpers in compression",
        strengths=(Strength(f"G_{end}", "{port}", text="force at z = ± l"),),
        apply=add(law),
        shapes=(Shape(f"l_{end}", "{z}", "displacement", 0.05, 0.13, 2, text="way of e-fold growth"),),
        common=0.5,
    )


EFFECTS = (
    _stop(1), _stop(-1), _power_stop(1), _power_stop(-1), _power_stop(1, True), _power_stop(-1, True),
    _soft_stop(1), _soft_stop(-1),
)  # fmt: skip
