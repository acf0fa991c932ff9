"""C functions around a loop over samples: what all kernels share."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from modelgen.codegen.kernels import Region, Stages
from modelgen.codegen.parts import advance
from modelgen.codegen.real import Work

LANES = 8
"""Sums have this many parts, of every 8th sample, so that their order is the same on every machine."""
PADDED = 2 * LANES
"""Arrays are padded to a multiple of it: what the longest loop takes at once."""

Stores = Callable[[Region], list[str]]
"""Given a region, the lines that store or sum its results."""

SIZES = "const size_t n, const size_t stride"

SAYS = {"complex": "Re and Im", "modulus": "Modulus", "phase": "Phase in degrees", "real": "All real outputs"}


@dataclass(frozen=True)
class Kernel:
    """A C function: its name after the prefix, comment, signature and body; `work` of a sample, and the
    `words` of arrays that it loads and stores."""

    name: str
    comment: str
    signature: str
    code: str
    work: Work
    words: int


def indent(lines: Sequence[str], depth: int) -> str:
    return textwrap.indent("\n".join(lines), "    " * depth)


def join(lines: Sequence[str]) -> list[str]:
    return [line for block in lines for line in block.split("\n") if line.strip()]


def make_kernel(
    stages: Stages,
    prefix: str,
    name: str,
    says: str,
    first: str,
    ends: str,
    lines: list[str],
    work: Work,
    gives: str = "void",
) -> Kernel:
    data = (
        "const double *const *restrict in"
        if stages.batch
        else "const double *restrict work, const double *restrict p"
    )
    names = ("n", "stride", "in") if stages.batch else ("n", "stride", "work", "p")
    text = "\n".join(lines)
    unused = [f"(void){x};" for x in names if not re.search(rf"\b{x}\b", text)]
    code = indent(join([*unused, *lines]), 1)
    signature = f"{gives} {prefix}_{name}({first}{SIZES}, {data}{ends})"
    return Kernel(name, f"/* {says} */", signature, code, work, words(code))


def words(code: str) -> int:
    """How many numbers of arrays a sample takes and gives."""
    return len(set(re.findall(r"\b(?:work|data|weight|out|jac|in)\[[^\n]*?\b[ik]\]", code)))


_VECTORISES = {
    "sqrt", "fabs", "floor", "mg_wrap", "mg_min", "mg_max", "mg_sign",
    "mg_exp", "mg_log", "mg_sin", "mg_cos", "mg_atan2",
}  # fmt: skip


def alone(body: Sequence[str]) -> list[str]:
    """The mark of a loop that compilers shall vectorise, if nothing in it keeps them from it."""
    called = set(re.findall(r"\b([A-Za-z_]\w*)\(", "\n".join(body)))
    return ["MG_ALONE"] if called <= _VECTORISES else []


def loop(stages: Stages, region: Region, stores: Stores) -> list[str]:
    """The loop over samples that stand alone, with `stores` at its end."""
    end = "n" if stages.batch else "stride"
    body = indent([*region.body, *stores(region)], 1)
    return [*region.setup, *alone(region.body), f"for (size_t i = 0; i < {end}; ++i) {{", body, "}"]


def march(region: Region, first: Region, stores: Stores) -> list[str]:
    """First sample with the initial states, then one step a sample."""
    return [*opening(region, first, stores), *region.setup, *marching(region, stores)]


def opening(region: Region, first: Region, stores: Stores) -> list[str]:
    """States, and the first sample with their initial values."""
    start = [f"{n} = {v};" for n, v in zip(region.state_names, first.state_values, strict=True)]
    return [
        *(f"double {n} = 0.0;" for n in region.state_names),
        "{",
        "    const size_t i = 0;",
        indent([*first.setup, *first.body, *stores(first), *start], 1),
        "}",
    ]


def marching(region: Region, stores: Stores) -> list[str]:
    """All samples after the first, one step each."""
    body = indent([*region.body, *stores(region), *advance(region.state_names, region.state_values)], 1)
    return ["for (size_t i = 1; i < n; ++i) {", body, "}"]
