"""A stage with two axes: what is done at one leaves the other alone, in whichever order they are declared."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
import sympy as sp

from modelgen.effects import CATALOGUE, Effect
from modelgen.language import (
    Equation,
    Input,
    Model,
    Output,
    Parameter,
    Piecewise,
    Port,
    State,
    acceleration_of,
    dahl_step,
    previous,
    rate_of,
    turning_point_of,
)
from modelgen.language.meant import expressions

t = Input("t", "s")
t_prev = previous(t)


def axis(n: str, unit: str, force: str) -> tuple[Any, ...]:
    """Inputs, parameters, statements and ports of a spring with Dahl's friction along one axis."""
    z = Input(n, unit)
    before, turn = previous(z), turning_point_of(z)
    v, a = rate_of(z, f"v_{n}", f"{unit}/s"), acceleration_of(z, f"a_{n}", f"{unit}/s**2")
    k, h = Parameter(f"k_{n}", f"{force}/{unit}", 1.0, (0, 10)), Parameter(f"h_{n}", force, 1.0, (0, 10))
    rho = Parameter(f"rho_{n}", f"1/{unit}", 1.0, (0, 10))
    stiffness, level = Equation(f"K_{n}", k, k.unit), Equation(f"H_{n}", h, force)
    slip, b = Equation(f"slip_{n}", rho, rho.unit), Equation(f"b_{n}", 1)

    def stroke(r: Any, dz: Any) -> Any:
        up = Piecewise((1, dz >= 0), (-1, True))
        return up * (1 - dahl_step(1 - up * r, slip * up * dz, b.symbol))

    r = sp.Symbol(f"r_{n}", real=True)
    turned = Equation(f"turned_{n}", stroke(r, turn - before))
    state = State(r.name, -1, stroke(turned.symbol, z - turn))
    F = Equation(f"F_{n}", level * state.symbol + stiffness * z, force)
    at = {"z": z, "v": v, "a": a, "z_prev": before, "z_turn": turn, "t": t, "t_prev": t_prev}
    names = tuple((key, x.symbol) for key, x in at.items())
    ports = (
        Port(n, "force", F.name, names),
        Port(n, "friction", level.name, (*names, ("r", r))),
        Port(n, "slip", slip.name, names),
        Port(n, "dahl", b.name, names),
        Port(n, "spring", stiffness.name, names),
    )
    return (z, before, turn, v, a), (k, h, rho), (stiffness, level, slip, b, turned, state, F), ports


X, Y = axis("x", "mm", "N"), axis("y", "um", "kN")


def stage(*axes: tuple[Any, ...]) -> Model:
    inputs, parameters, statements, ports = (tuple(q for a in axes for q in a[k]) for k in range(4))
    outputs = tuple(Output(s.name) for s in statements if s.name.startswith("F_"))
    return Model("stage", (t, t_prev, *inputs), parameters, statements, outputs, ports)


def made_of(model: Model, name: str) -> set[str]:
    """All that an equation is made of."""
    known = {s.name: s for s in model.statements}
    found, left = set(), [name]
    while left:
        if (n := left.pop()) not in found:
            found.add(n)
            left += [x.name for e in expressions(known[n]) for x in e.free_symbols] if n in known else []
    return found


STAGE = stage(X, Y)
AT_Y = [
    pytest.param(e, p, id=f"{e.id}-{e.strengths[0].name}-{p.kind}")
    for e in CATALOGUE
    for p in e.fits(STAGE)
    if p.name == "y"
]


def test_there_is_much_to_look_at() -> None:
    assert len(AT_Y) > 60


@pytest.mark.parametrize(("effect", "port"), AT_Y)
def test_an_effect_at_one_axis_leaves_the_other_alone(effect: Effect, port: Port) -> None:
    model = effect.extend(STAGE, port)
    assert made_of(model, "F_x") == made_of(STAGE, "F_x")
    assert not {n for n in made_of(model, "F_y") if n in made_of(STAGE, "F_x")} - {"t", "t_prev"}
    assert any(n.startswith(effect.id) for n in made_of(model, "F_y"))


@pytest.mark.parametrize(("effect", "port"), AT_Y[::6])
def test_the_order_of_axes_does_not_matter(effect: Effect, port: Port) -> None:
    model = effect.extend(STAGE, port)
    turned = effect.extend(replace(stage(Y, X), outputs=STAGE.outputs), port)
    assert str(turned["F_y"]) == str(model["F_y"])


@pytest.mark.parametrize("kind", ["force", "spring", "friction"])
def test_units_are_those_of_the_axis(kind: str) -> None:
    """Laws whose numbers are in the units of a partner: a joint gives so many µm per kN."""
    for effect, port in (p.values for p in AT_Y):
        if port.kind == kind:
            units = " ".join(q.unit for q in effect.parameters(STAGE, port).values())
            assert "mm" not in units.replace("µm", "um") and "N" not in units.replace("kN", "")
