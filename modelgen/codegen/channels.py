"""What a model's outputs are compared with: parts of complex numbers, modulus, phase, with derivatives."""

from __future__ import annotations

from dataclasses import dataclass

from modelgen.codegen.program import Program, Sample
from modelgen.codegen.split import Complex, Pair


@dataclass(frozen=True)
class Channel:
    """A real measured quantity: its node, and its derivative by each column (None where it is zero)."""

    name: str
    value: int
    jacobian: tuple[int | None, ...]


def channels(program: Program, sample: Sample, measure: str) -> tuple[Channel, ...]:
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
    return tuple(found)


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
