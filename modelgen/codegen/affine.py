"""Recurrences x ← a x + c, found in a time model's step: such a state needs no march, but one scan.

A state that is affine in itself, with factors that no state has a part in, is a composition of affine maps,
which may be taken in any grouping. Others may have a part in c if they can be scanned before it.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

from modelgen.codegen.algebra import FREE, SAMPLE
from modelgen.codegen.program import Sample, sensitivity
from modelgen.codegen.real import COMMUTATIVE, Graph, Node

Part = tuple[int | None, int | None]  # factor and rest; None is zero


@dataclass(frozen=True)
class Recurrence:
    """`state` ← factor · state + rest; `level` 0 needs no other state's values, level k those below."""

    state: str
    factor: int
    rest: int
    level: int


def updates(sample: Sample) -> dict[str, int]:
    """The new value of each state and sensitivity, by the name of its old one."""
    return {**sample.states, **{sensitivity(n, d): at for (n, d), at in sample.sensitivities.items()}}


def recurrences(sample: Sample) -> tuple[Recurrence, ...] | None:
    """How each state can be scanned, in an order in which they can be; None if one cannot."""
    graph, wanted = sample.graph, updates(sample)
    inputs = {name: graph.input(name) for name in wanted}
    found: list[Recurrence] = []
    level = 0
    while len(found) < len(wanted):
        scanned = {x.state for x in found}
        depends = _below(graph, {inputs[n] for n in wanted if n not in scanned})
        now = []
        for name in wanted:
            if name not in scanned:
                part = _split(graph, wanted[name], inputs[name], depends, {})
                if part is not None:
                    zero = graph.const(0.0)
                    factor, rest = (zero if x is None else x for x in part)
                    now.append(Recurrence(name, factor, rest, level))
        if not now:
            return None
        found += now
        level += 1
    return tuple(found)


def _below(graph: Graph, sources: set[int]) -> Callable[[int], bool]:
    """Whether a node depends on any of `sources`."""
    memo: dict[int, bool] = {}

    def depends(at: int) -> bool:
        if at not in memo:
            memo[at] = at in sources or any(map(depends, graph.nodes[at].args))
        return memo[at]

    return depends


def _split(
    graph: Graph, at: int, x: int, depends: Callable[[int], bool], memo: dict[int, Part | None]
) -> Part | None:  # fmt: skip
    """(factor, rest) of node `at` as factor · x + rest, neither with a part of a blocked state; None if not
    so."""
    if at == x:
        return graph.const(1.0), None
    if not depends(at):
        return None, at
    if at not in memo:
        node, parts = graph.nodes[at], list[Part]()
        for a in node.args:
            part = _split(graph, a, x, depends, memo)
            if part is None:
                break
            parts.append(part)
        memo[at] = _combine(graph, node, parts) if len(parts) == len(node.args) else None
    return memo[at]


def _combine(graph: Graph, node: Node, parts: list[Part]) -> Part | None:
    def over(name: str, a: int | None, b: int | None) -> int | None:
        if a is None or b is None:
            return None
        return graph.binary(name, a, b)

    if node.op in ("add", "sub"):
        (f, c), (g, d) = parts
        return _sum(graph, node.op, f, g), _sum(graph, node.op, c, d)
    if node.op == "neg":
        f, c = parts[0]
        return (None if f is None else graph.unary("neg", f), None if c is None else graph.unary("neg", c))
    if node.op in ("mul", "div", "ifz"):
        (f, c), (g, d) = parts
        if g is None and node.op in ("mul", "div"):
            return over(node.op, f, d), over(node.op, c, d)
        if f is None and node.op in ("mul", "ifz"):
            return over(node.op, c, g), over(node.op, c, d)
    return None


def _sum(graph: Graph, op: str, a: int | None, b: int | None) -> int | None:
    if b is None:
        return a
    if a is None:
        return graph.unary("neg", b) if op == "sub" else b
    return graph.binary(op, a, b)


SIMPLER: dict[str, tuple[int, float]] = {f"mg_dahl_step{end}": (2, 1.0) for end in ("", "_u", "_x")}
"""Functions that are elementary at one value of one argument: MRE (9) is (8) at b = 1."""


def special(sample: Sample, free: set[str]) -> dict[str, float]:
    """Held parameters, and their values, at which the functions of a step become elementary."""
    found: dict[str, float] = {}
    for node in sample.graph.nodes:
        if node.op == "call" and node.data in SIMPLER:
            index, value = SIMPLER[str(node.data)]
            argument = sample.graph.nodes[node.args[index]]
            if argument.op == "in" and str(argument.data) not in free:
                found[str(argument.data)] = value
    return found


def earlier(sample: Sample, masks: list[int]) -> list[int]:
    """Strokes, differences of inputs that exponentials of a step decay with: of all but the last one, which
    is there in every step, while those before end where the path turns."""
    nodes, found = sample.graph.nodes, list[int]()
    for node, mask in zip(nodes, masks, strict=True):
        stack = list(node.args) if node.op == "exp" and mask == SAMPLE | FREE else []
        while stack:
            at = stack.pop()
            if nodes[at].op in ("mul", "neg"):
                stack += nodes[at].args
            elif nodes[at].op == "sub" and masks[at] == SAMPLE and at not in found:
                found.append(at)
    return found[:-1]


def specialised(
    sample: Sample, values: Mapping[str, float], zero: Collection[int] = ()
) -> tuple[Sample, dict[int, int]]:
    """The sample with parameters at `values` and the nodes `zero` at 0, and where its nodes went."""
    graph, new = Graph(), dict[int, int]()
    for at, node in enumerate(sample.graph.nodes):
        args = [new[a] for a in node.args]
        new[at] = graph.const(0.0) if at in zero else _again(graph, node, args, values)
        if at in sample.graph.labels:
            graph.label(new[at], *sample.graph.labels[at])
    return sample.moved(graph, new), new


def _again(graph: Graph, node: Node, args: list[int], values: Mapping[str, float]) -> int:
    if node.op == "const":
        return graph.const(float(node.data))
    if node.op == "in":
        name = str(node.data)
        return graph.const(values[name]) if name in values else graph.input(name)
    if node.op == "call":
        return _call(graph, str(node.data), args)
    if len(args) == 1:
        return graph.unary(node.op, *args)
    a, b = args
    return graph.binary(node.op, *((b, a) if node.op in COMMUTATIVE and a > b else (a, b)))


def _call(graph: Graph, name: str, args: list[int]) -> int:
    if name in SIMPLER and graph.value(args[SIMPLER[name][0]]) == SIMPLER[name][1]:
        u, x = args[:2]
        decay = graph.unary("exp", graph.unary("neg", x))
        if name == "mg_dahl_step_u":
            return decay
        step = graph.binary("mul", u, decay)
        return step if name == "mg_dahl_step" else graph.unary("neg", step)
    return graph.call(name, *args)
