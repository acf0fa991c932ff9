"""C functions around a loop over samples: what all kernels share."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from modelgen.codegen.kernels import Region, Stages
from modelgen.codegen.parts import advance
from modelgen.codegen.real import Work
from modelgen.codegen.tape import is_tape, record

LANES = 8
"""Sums have this many parts, of every 8th sample, so that their order is the same on every machine."""
PADDED = 2 * LANES
"""Arrays are padded to a multiple of it: what the longest loop takes at once."""

Stored = Sequence[tuple[str, int | None]]
"""Where results go: place in an array, node (None: zero)."""
Stores = Callable[[Region], Stored]
"""Given a region, where its results go."""
Lines = Callable[[Region], list[str]]
"""Given a region, the C that stores or sums its results."""

MARCH = "for (size_t i = 1; i < n; ++i) {"
"""How a loop begins that takes one sample after the other."""
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
    lines = (line for line in code.split("\n") if not is_tape(line))
    found = (re.findall(r"\b(?:work|data|weight|out|jac|in)\[[^\n]*?\b[ik]\]", line) for line in lines)
    return len({place for places in found for place in places})


_VECTORISES = {
    "sqrt", "fabs", "floor", "mg_wrap", "mg_min", "mg_max", "mg_sign",
    "mg_exp", "mg_log", "mg_sin", "mg_cos", "mg_atan2",
}  # fmt: skip


def alone(body: Sequence[str]) -> list[str]:
    """The mark of a loop that compilers shall vectorise, if nothing in it keeps them from it."""
    called = set(re.findall(r"\b([A-Za-z_]\w*)\(", "\n".join(body)))
    return ["MG_ALONE"] if called <= _VECTORISES else []


def printed(region: Region, stored: Stored) -> list[str]:
    """The body and what it stores, in C."""
    return [*region.body, *assigned(region, stored)]


def assigned(region: Region, stored: Stored) -> list[str]:
    """What a body stores, in C, after it."""
    return [f"{place} = {region.text(at, alone=True)};" for place, at in stored]


def each(body: Sequence[str]) -> list[str]:
    """A vector loop over the `count` samples of a tile from `base` on."""
    used = ["const size_t i = base + l;"] if any("stride + i" in x for x in body) else []
    return [*alone(body), "for (size_t l = 0; l < count; ++l) {", indent([*used, *body], 1), "}"]


def tile(stages: Stages, region: Region, stored: Stored) -> list[str]:
    """What computes a region for a tile: a vector loop, or a tape."""
    return record(region, stored) if stages.taped else each(printed(region, stored))


def tiles(region: Region, stored: Stored, after: Sequence[str]) -> list[str]:
    """Taped: all tiles of samples that stand alone, `after` at the end of each."""
    return [
        "for (size_t base = 0; base < stride; base += MG_TILE) {",
        "    const size_t count = stride - base < MG_TILE ? stride - base : MG_TILE;",
        indent([*record(region, stored), *after], 1),
        "}",
    ]


def loop(stages: Stages, region: Region, stores: Stores) -> list[str]:
    """The loop over samples that stand alone, with `stores` at its end."""
    if stages.taped:
        return [*region.setup, *tiles(region, stores(region), ())]
    end, body = "n" if stages.batch else "stride", printed(region, stores(region))
    return [
        *region.setup, *alone(region.body), f"for (size_t i = 0; i < {end}; ++i) {{", indent(body, 1), "}",
    ]  # fmt: skip


def march(region: Region, first: Region, lines: Lines) -> list[str]:
    """First sample with the initial states, then one step a sample."""
    return [*opening(region, first, lines), *region.setup, *marching(region, lines)]


def opening(region: Region, first: Region, lines: Lines) -> list[str]:
    """States, and the first sample with their initial values."""
    body = [*first.setup, *first.body, *lines(first)]
    start = [f"{n} = {first.text(v)};" for n, v in zip(region.state_names, first.state_values, strict=True)]
    return [
        *(f"double {n} = 0.0;" for n in region.state_names),
        "{",
        "    const size_t i = 0;",
        indent([*body, *start], 1),
        "}",
    ]


def marching(region: Region, lines: Lines) -> list[str]:
    """All samples after the first, one step each."""
    body = [*region.body, *lines(region)]
    body += advance(region.state_names, [region.text(at) for at in region.state_values])
    return [MARCH, indent(body, 1), "}"]
