"""A step of a time model in parts: the loop that takes the states through them, in C."""

from __future__ import annotations

import re
from collections.abc import Sequence

from modelgen.codegen.ctext import Printer
from modelgen.codegen.lower import PART
from modelgen.codegen.program import Part
from modelgen.codegen.real import Work, work


def part_loop(part: Part, printer: Printer, jacobian: bool) -> tuple[list[str], Work]:
    """The loop over the parts of a step, what stays the same in it before it; and the work of one part.

    printer: of the part's graph, with names for all that is given; states and sensitivities are variables.
    """
    graph, results = part.graph, part.results(jacobian)
    printer.names[graph.input(PART)] = "(double)k"
    need = graph.needed(results.values())
    moving: set[int] = {graph.input(n) for n in (*results, PART)}
    for at in need:
        if not moving.isdisjoint(graph.nodes[at].args):
            moving.add(at)
    inside = [at for at in need if at in moving]
    hoisted = {a for at in inside for a in graph.nodes[at].args if a not in moving}
    before = printer.lines([at for at in need if at not in moving], results.values(), hoisted)
    body = printer.lines(inside, results.values())
    body += advance([printer.names[graph.input(n)] for n in results], [*map(printer.value, results.values())])
    loop = [f"for (unsigned long k = 0UL; k < {part.count}UL; ++k) {{", *(f"    {x}" for x in body), "}"]
    return [*before, *loop], work(graph, inside)


def advance(names: Sequence[str], values: Sequence[str]) -> list[str]:
    """Assign new values, all computed before any is overwritten."""
    pairs = [(n, v) for n, v in zip(names, values, strict=True) if n != v]
    olds = {n for n, _ in pairs}
    if not any(set(re.findall(r"\w+", v)) & olds for _, v in pairs):
        return [f"{n} = {v};" for n, v in pairs]
    return [*(f"const double {n}_next = {v};" for n, v in pairs), *(f"{n} = {n}_next;" for n, _ in pairs)]
