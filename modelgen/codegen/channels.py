"""What a model's outputs are compared with: parts of complex numbers, modulus, phase, with derivatives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from modelgen.codegen.program import Program, Sample
from modelgen.codegen.real import Graph
from modelgen.codegen.split import Complex, Pair

Form = Literal["values", "residuals", "squares"]
"""What a kernel gives: outputs, weighted differences from data, or the sum of their squares."""

MEASURED = ("data", "weight")


@dataclass(frozen=True)
class Channel:
    """A real quantity: its node, and its derivative by each column (None where it is zero)."""

    name: str
    value: int
    jacobian: tuple[int | None, ...] = ()
    called: Mapping[int, str] = field(default_factory=dict)  # names of nodes in C


def is_measured(name: str) -> bool:
    """Whether an input of the graph is one of `measured`."""
    what, _, channel = name.partition(" ")
    return what in MEASURED and channel.isdecimal()


def measured(many: int) -> dict[str, str]:
    """Data and weights of so many channels: inputs of the graph, and where they are."""
    return {f"{what} {c}": f"{what}[{c} * stride + i]" for c in range(many) for what in MEASURED}


def channels(
    program: Program, sample: Sample, measure: str, form: Form = "values"
) -> tuple[Channel, ...]:  # fmt: skip
    """What is compared with data: "complex" (Re and Im), "modulus", "phase" [deg], or "real" (all real
    outputs)."""
    c = Complex(sample.graph)
    found: list[Channel] = []
    for o in program.outputs:
        z, dz = sample.fitted[o], sample.jacobian[o]
        if measure == "real":
            found.append(Channel(o, c.re(z), tuple(d[0] for d in dz)))
        elif measure == "complex":
            found.append(Channel(f"{o}_re", c.re(z), tuple(d[0] for d in dz)))
            found.append(Channel(f"{o}_im", c.im(z), tuple(d[1] for d in dz)))
        else:
            found.append(_polar(c, o, z, dz, measure))
    if form != "values":
        found = [_residual(sample.graph, k, x, measure) for k, x in enumerate(found)]
    return (_squares(sample.graph, found),) if form == "squares" else tuple(found)


def _residual(g: Graph, number: int, x: Channel, measure: str) -> Channel:
    """weight (model − data), and the weighted derivatives. A difference of angles is brought to ±180°."""
    data, weight = (g.input(f"{what} {number}") for what in MEASURED)
    miss = g.binary("sub", x.value, data)
    miss = g.call("mg_wrap", miss) if measure == "phase" else miss
    slopes = tuple(None if d is None else g.binary("mul", weight, d) for d in x.jacobian)
    e, name = g.binary("mul", weight, miss), f"e{number}"
    names = {d: f"j{number}_{k}" for k, d in enumerate(slopes) if d is not None and g.nodes[d].args}
    return Channel(name, e, slopes, {**names, e: name})


def _squares(g: Graph, residuals: list[Channel]) -> Channel:
    total = None
    for x in residuals:
        square = g.binary("mul", x.value, x.value)
        total = square if total is None else g.binary("add", total, square)
    assert total is not None
    return Channel("squares", total, (), {x.value: x.name for x in residuals})


def _polar(c: Complex, name: str, z: Pair, dz: tuple[Pair, ...], measure: str) -> Channel:
    """|Z| with Re(Z̄ dZ)/|Z|, or arg Z in degrees with Im(Z̄ dZ)/|Z|²."""
    conjugate = (z[0], c.neg((None, z[1]))[1])
    if measure == "modulus":
        size = c.modulus(z)
        turned = c.mul(conjugate, c.inv(size))
        return Channel(f"abs_{name}", c.re(size), tuple(c.mul(turned, d)[0] for d in dz))
    degrees = c.const(57.29577951308232)
    angle = c.mul(c.argument(z), degrees)
    turned = c.mul(conjugate, c.div(degrees, (c.norm(z), None)))
    return Channel(f"phase_{name}", c.re(angle), tuple(c.mul(turned, d)[1] for d in dz))
