"""From a recording's sample to a controller's: what looks back or is fixed is replaced, and the rest gets
simpler."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import sympy as sp

from modelgen.codegen.lower import PART
from modelgen.codegen.program import Part, Program, Root, Sample
from modelgen.codegen.real import Graph, Node
from modelgen.language import Model
from modelgen.language.derived import values_before
from modelgen.language.quantities import BACKWARD
from modelgen.language.write import free


@dataclass(frozen=True)
class Places:
    """What stands for an input or a parameter: another input's name, or a number; `clock` is (t, t_prev).

    `kept` says which arguments the function of an implicit equation still has; `step` is what t − t_prev is
    called.
    """

    names: Mapping[str, str | float]
    clock: tuple[str, str] | None = None
    kept: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    step: str = ""


def step_name(model: Model) -> str:
    """The input that a model's clock becomes when all that counts is the time since the sample before: "dt",
    but for a model where that is something else."""
    before = {of: n for n, of in values_before(model).items()}
    t, last = (sp.Symbol(n, real=True) for n in (model.axis, before.get(model.axis, "")))
    quantities = (*model.inputs, *model.parameters, *model.scalar_parameters, *model.statements)
    return free("dt", {q.name for q in quantities if getattr(q, "expr", None) != t - last})


def at_step(model: Model, fixed: Mapping[str, float], kept: Mapping[str, tuple[int, ...]]) -> Places:
    """At a later sample the turning point is the value before: who knows one steps to it, then from it."""
    before = {of: n for n, of in values_before(model).items()}
    turns = {
        i.name: before[i.derived[1]]
        for i in model.inputs
        if i.derived and i.derived[0] == "turning" and i.derived[1] in before
    }
    clock = (model.axis, before[model.axis]) if model.axis in before else None
    return Places({**fixed, **turns}, clock, kept, step_name(model))


def at_start(model: Model, fixed: Mapping[str, float], kept: Mapping[str, tuple[int, ...]]) -> Places:
    """At the first sample, what looks back sees the sample itself."""
    own = {i.name: i.derived[1] for i in model.inputs if i.derived and i.derived[0] in BACKWARD}
    return Places({**fixed, **own}, None, kept)


def rewrite(sample: Sample, places: Places) -> Sample:
    """`sample` in a new graph with `places` filled in; the clock stays where its difference is not enough."""
    if places.clock:
        new = _rewrite(sample, places)
        if places.clock[1] not in inputs_of(new):
            return new
    return _rewrite(sample, Places(places.names, None, places.kept))


def rewrite_root(root: Root, fixed: Mapping[str, float]) -> tuple[Root, tuple[int, ...]]:
    """An implicit equation with numbers in the place of parameters, and which of its arguments are left."""
    graph, new = Graph(), dict[int, int]()
    for at in root.graph.needed([root.residual, root.slope]):
        new[at] = _node(graph, root.graph, at, new, Places(fixed))
    residual, slope = new[root.residual], new[root.slope]
    used = {str(graph.nodes[at].data) for at in graph.needed([residual, slope]) if graph.nodes[at].op == "in"}
    left = [k for k, n in enumerate(root.arguments) if n in used]
    names = tuple(root.arguments[k] for k in left)
    count = len(root.arguments)
    made = Root(root.name, root.unknown, names, graph, residual, slope, root.comment)
    return made, (*left, count, count + 1)


def roots_of(sample: Sample) -> list[int]:
    """All nodes that a sample gives."""
    pairs = [*sample.equations.values(), *sample.fitted.values()]
    pairs += [d for row in sample.jacobian.values() for d in row]
    parts = [x for pair in pairs for x in pair if x is not None]
    return [*parts, *sample.states.values(), *sample.sensitivities.values()]


def inputs_of(sample: Sample, roots: list[int] | None = None) -> set[str]:
    """Names of the inputs, parameters and states that `roots` (by default all results) need."""
    found = sample.graph.inputs(roots_of(sample) if roots is None else roots)
    if roots is None and sample.part is not None:
        found |= sample.part.graph.inputs(sample.part.results(True).values()) - {PART}
    return found


def only(program: Program, sample: Sample, equations: tuple[str, ...]) -> Sample:
    """`sample` without the equations that nobody asked for."""
    return replace(
        sample,
        equations={n: sample.equations[n] for n in equations},
        jacobian={n: sample.jacobian[n] for n in program.outputs},
    )


def _copied(old: Graph, roots: Iterable[int], places: Places) -> tuple[Graph, dict[int, int]]:
    """A new graph with `places` filled in, and where the nodes of the old one are in it."""
    graph, new = Graph(), dict[int, int]()
    for at in old.needed(roots):
        new[at] = _node(graph, old, at, new, places)
        if at in old.labels:
            graph.label(new[at], *old.labels[at])
    return graph, new


def _rewrite(sample: Sample, places: Places) -> Sample:
    graph, new = _copied(sample.graph, roots_of(sample), places)
    part = None if sample.part is None else _rewrite_part(sample.part, places)
    return replace(sample.moved(graph, new), part=part)


def _rewrite_part(part: Part, places: Places) -> Part:
    graph, new = _copied(part.graph, part.results(True).values(), places)
    states = {n: new[at] for n, at in part.states.items()}
    return Part(graph, part.count, states, {key: new[at] for key, at in part.sensitivities.items()})


def _node(graph: Graph, old: Graph, at: int, new: dict[int, int], places: Places) -> int:
    node = old.nodes[at]
    args = [new[a] for a in node.args]
    if node.op == "const":
        return graph.const(float(node.data))
    if node.op == "in":
        place = places.names.get(str(node.data), str(node.data))
        return graph.input(place) if isinstance(place, str) else graph.const(place)
    if node.op == "call":
        kept = places.kept.get(str(node.data))
        return _call(graph, str(node.data), args if kept is None else [args[k] for k in kept])
    if len(args) == 1:
        return graph.unary(node.op, args[0])
    if node.op == "sub":
        return _difference(graph, args[0], args[1], places)
    if node.op == "add":
        return _choice(graph, *args)
    return graph.binary(node.op, *args)


def _difference(graph: Graph, a: int, b: int, places: Places) -> int:
    """a − b; of the clock's two readings, the step; 1 − (1 − x) is x."""
    clock = places.clock
    names = tuple(str(graph.nodes[x].data) if graph.nodes[x].op == "in" else "" for x in (a, b))
    if clock and names == clock:
        return graph.input(places.step)
    if clock and names == clock[::-1]:
        return graph.unary("neg", graph.input(places.step))
    inner = graph.nodes[b]
    if inner.op == "sub" and inner.args[0] == a and graph.value(a) is not None:
        return inner.args[1]
    return graph.binary("sub", a, b)


def _choice(graph: Graph, a: int, b: int) -> int:
    """a + b; (c ? x : 0) + (!c ? y : 0) is c ? x : y."""
    na, nb = graph.nodes[a], graph.nodes[b]
    if na.op == nb.op == "ifz":
        for this, other in ((na, nb), (nb, na)):
            condition = graph.nodes[other.args[0]]
            if condition.op == "not" and condition.args[0] == this.args[0]:
                return graph._put(Node("sel", (this.args[0], this.args[1], other.args[1])))
    return graph.binary("add", a, b)


def _call(graph: Graph, function: str, args: list[int]) -> int:
    """A call; the Dahl step over no displacement, and of exponent 1, needs none (MRE paper, eq. 8 and 9)."""
    if not function.startswith("mg_dahl_step"):
        return graph.call(function, *args)
    u, x, b = args
    kind = function.removeprefix("mg_dahl_step")
    if graph.value(x) == 0.0 and kind in ("", "_u", "_b"):
        return {"": u, "_u": graph.const(1.0), "_b": graph.const(0.0)}[kind]
    if graph.value(b) == 1.0 and kind in ("", "_u", "_x"):
        decay = graph.unary("exp", graph.unary("neg", x))
        if kind == "_u":
            return decay
        end = graph.binary("mul", u, decay)
        return end if kind == "" else graph.unary("neg", end)
    return graph.call(function, *args)
