"""A lowered model as a real program: values, Jacobian and states as nodes of a graph of real numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from modelgen.codegen.derive import Residual
from modelgen.codegen.lower import PART, Lowering, lower, parts_of, primary_outputs
from modelgen.codegen.reading import Reader
from modelgen.codegen.real import Graph
from modelgen.codegen.split import Complex, Pair
from modelgen.language import Model


@dataclass(frozen=True)
class Part:
    """One of `count` equal parts of the step to a sample, number PART: new states and sensitivities."""

    graph: Graph
    count: int
    states: dict[str, int]
    sensitivities: dict[tuple[str, int], int]

    def results(self, jacobian: bool) -> dict[str, int]:
        """New values by what they are called, in a graph, before."""
        slopes = {sensitivity(n, d): at for (n, d), at in self.sensitivities.items()} if jacobian else {}
        return {**self.states, **slopes}


@dataclass(frozen=True)
class Sample:
    """What is computed at one sample: every equation as written, the primary outputs (`fitted`) and their
    derivatives in the form that runs fastest, new states and sensitivities. Before that, states are taken
    through all parts of the step, if it has any."""

    graph: Graph
    equations: dict[str, Pair]
    fitted: dict[str, Pair]
    jacobian: dict[str, tuple[Pair, ...]]
    states: dict[str, int]
    sensitivities: dict[tuple[str, int], int]
    part: Part | None = None

    def moved(self, graph: Graph, to: Mapping[int, int]) -> Sample:
        """The same in another graph, where node n is to[n]; its part is left as it is."""

        def pair(p: Pair) -> Pair:
            return (None if p[0] is None else to[p[0]], None if p[1] is None else to[p[1]])

        return replace(
            self, graph=graph,
            equations={n: pair(p) for n, p in self.equations.items()},
            fitted={n: pair(p) for n, p in self.fitted.items()},
            jacobian={n: tuple(map(pair, row)) for n, row in self.jacobian.items()},
            states={n: to[at] for n, at in self.states.items()},
            sensitivities={key: to[at] for key, at in self.sensitivities.items()},
        )  # fmt: skip


@dataclass(frozen=True)
class Root:
    """The function that solves one implicit equation: residual and its derivative, of arguments and
    unknown."""

    name: str
    unknown: str
    arguments: tuple[str, ...]
    graph: Graph
    residual: int
    slope: int
    comment: str = ""


@dataclass(frozen=True)
class Program:
    """A model in real arithmetic. `first` differs from `step` in time models only (initial states)."""

    model: Model
    wrt: tuple[str, ...]
    outputs: tuple[str, ...]
    complex_outputs: tuple[bool, ...]
    step: Sample
    first: Sample | None
    roots: tuple[Root, ...]

    def copy(self) -> Program:
        """The same program, with graphs of its own."""
        part = self.step.part and replace(self.step.part, graph=self.step.part.graph.copy())
        step = replace(self.step, graph=self.step.graph.copy(), part=part)
        first = self.first and replace(self.first, graph=self.first.graph.copy())
        roots = tuple(replace(r, graph=r.graph.copy()) for r in self.roots)
        return replace(self, step=step, first=first, roots=roots)


def sensitivity(state: str, direction: int) -> str:
    """What the derivative of a state is called in a graph: by a name that no model can use."""
    return f"d {state} {direction}"


def build_program(model: Model, wrt: Sequence[str], brief: bool = False) -> Program:
    """Lower `model` with derivatives by the scalar parameters `wrt`.

    brief: as the equations are written, and only those that a fit needs: in half the time.
    Raises InputError when `wrt` names no parameter or an equation is outside the language.
    """
    wrt = tuple(model.parameter(n).name for n in wrt)
    low = lower(model, wrt, brief)
    step = _sample(low.step, low.pattern)
    first = None if low.first is None else _sample(low.first, low.pattern)
    if low.part is not None:
        step = replace(step, part=_part(low.part, low.pattern))
    outputs = primary_outputs(model)
    is_complex = tuple(step.equations[o][1] is not None for o in outputs)
    residuals = {c.function: c.residual for c in low.step.translator.calls if c.residual is not None}
    roots = tuple(map(_root, residuals.values()))
    return Program(model, wrt, outputs, is_complex, step, first, roots)


def _named(low: Lowering) -> dict[str, Any]:
    """What is given, by its name in a graph."""
    slopes = {sensitivity(n, d): x for (n, d), x in low.sensitivities.items()}
    part = {} if low.part is None else {PART: low.part}
    return {**low.inputs, **low.parameters, **low.old, **slopes, **part}


def _part(low: Lowering, pattern: dict[str, set[int]]) -> Part:
    graph = Graph()
    reader = Reader(graph, low.translator, _named(low), low.plain)
    names = list(low.values)
    entries = _entries(low.tangent(list(low.values.values())))
    pairs = reader.read([*low.values.values(), *entries.values()])
    new = dict(zip(entries, pairs[len(names) :], strict=True))
    states = {n: reader.c.re(pair) for n, pair in zip(names, pairs, strict=False)}
    slopes = {
        (n, d): reader.c.re(new.get((i, d), (None, None)))
        for i, n in enumerate(names)
        for d in sorted(pattern[n])
    }
    return Part(graph, parts_of(low.model), states, slopes)


def _sample(low: Lowering, pattern: dict[str, set[int]]) -> Sample:
    graph = Graph()
    reader = Reader(graph, low.translator, _named(low), low.plain)
    outputs = primary_outputs(low.model)
    values, tangent = low.fitted(outputs)
    states = [s.name for s in low.model.states]
    state_tangent = low.tangent([low.values[n] for n in states]) if states else None
    names = list(low.values)
    wanted = [*values, *(low.values[n] for n in names)]
    entries = _entries(tangent)
    wanted += list(entries.values())
    state_entries = _entries(state_tangent) if states else {}
    wanted += list(state_entries.values())
    pairs = reader.read(wanted)
    fitted = dict(zip(outputs, pairs, strict=False))
    n = len(outputs) + len(names)
    equations = dict(zip(names, pairs[len(outputs) : n], strict=True))
    _label(graph, low.model, fitted)
    _label(graph, low.model, equations)
    by_direction = dict(zip(entries, pairs[n:], strict=False))
    jacobian = {
        o: tuple(
            _column(reader.c, [(by_direction.get((i, d), (None, None)), j) for d, j in col.terms])
            for col in low.columns
        )
        for i, o in enumerate(outputs)
    }
    new = dict(zip(state_entries, pairs[n + len(entries) :], strict=True))
    sensitivities = {
        (name, d): reader.c.re(new.get((i, d), (None, None)))
        for i, name in enumerate(states)
        for d in sorted(pattern.get(name, ()))
    }
    updated = {n: reader.c.re(equations[n]) for n in states}
    return Sample(graph, equations, fitted, jacobian, updated, sensitivities)


def _entries(m: Any) -> dict[tuple[int, int], Any]:
    """Structural nonzeros of an SX matrix."""
    rows, cols = m.sparsity().get_triplet()
    return {(r, c): m[r, c] for r, c in zip(rows, cols, strict=True)}


def _column(c: Complex, terms: list[tuple[Pair, bool]]) -> Pair:
    total: Pair = (None, None)
    for pair, times_j in terms:
        total = c.add(total, c.times_j(pair) if times_j else pair)
    return total


def _label(graph: Graph, model: Model, equations: dict[str, Pair]) -> None:
    for s in model.statements:
        re, im = equations.get(s.name, (None, None))
        says = " ".join(x for x in (s.ref, s.text) if x)
        if re is not None:
            graph.label(re, f"{s.name}_re" if im is not None else s.name, says)
        if im is not None:
            graph.label(im, f"{s.name}_im", says if re is None else "")


def _root(residual: Residual) -> Root:
    s, graph = residual.statement, Graph()
    names = (*residual.arguments, s.name)
    reader = Reader(graph, residual.translator, dict(zip(names, residual.symbols, strict=True)), {})
    value, slope = reader.read([residual.value, residual.gradient[0, len(names) - 1]])
    re = reader.c.re
    return Root(
        f"solve_{s.name}",
        s.name,
        residual.arguments,
        graph,
        re(value),
        re(slope),
        f"{s.ref} {s.text}".strip(),
    )
