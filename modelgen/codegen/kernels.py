"""From a real program to the pieces of its C kernels: what is staged per recording, per parameter set, per
sample."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from modelgen.codegen.algebra import FREE, SAMPLE, STATE
from modelgen.codegen.channels import Channel, channels
from modelgen.codegen.ctext import BRANCHLESS, FUNCTION, Printer, c_name
from modelgen.codegen.parts import part_loop
from modelgen.codegen.program import Part, Program, Root, Sample, sensitivity
from modelgen.codegen.real import Work, work
from modelgen.codegen.split import Complex, Pair


@dataclass(frozen=True)
class Region:
    """Lines of C for one loop body, and where its results are."""

    setup: tuple[str, ...]
    body: tuple[str, ...]
    values: tuple[str, ...]
    jacobian: tuple[tuple[str, ...], ...]
    state_names: tuple[str, ...]
    state_values: tuple[str, ...]
    work: Work


class Stages:
    """Which nodes are computed when, for one program; makes the regions that templates print."""

    def __init__(self, program: Program, measures: Sequence[str] | None = None) -> None:
        self.program = program
        self.batch = not program.model.inputs
        self.free = set(program.wrt)
        self.inputs = [i.name for i in program.model.inputs]
        self.parameters = [p.name for p in program.model.scalar_parameters]
        self.state_names = [s.name for s in program.model.states]
        self.sensitivity_names = [sensitivity(n, d) for n, d in program.step.sensitivities]
        possible = ("complex", "modulus", "phase") if any(program.complex_outputs) else ("real",)
        self.measures = tuple(m for m in possible if measures is None or m in measures)
        self.channels = {m: channels(program, program.step, m) for m in self.measures}
        self.first_channels = (
            {m: channels(program, program.first, m) for m in self.measures} if program.first else {}
        )

    @cached_property
    def masks(self) -> list[int]:
        return self.masks_of(self.program.step)

    def masks_of(self, sample: Sample) -> list[int]:
        """What each node depends on."""
        bits: list[int] = []
        states = {*self.state_names, *self.sensitivity_names}
        for node in sample.graph.nodes:
            if node.op == "in":
                name = str(node.data)
                sampled = name in self.inputs or self.batch
                bits.append(
                    SAMPLE
                    if sampled
                    else STATE | FREE
                    if name in states
                    else FREE
                    if name in self.free
                    else 0
                )
            else:
                bit = 0
                for a in node.args:
                    bit |= bits[a]
                bits.append(bit)
        return bits

    def _roots(self, chans: Iterable[Channel], jacobian: bool, sample: Sample) -> list[int]:
        roots = [c.value for c in chans]
        if jacobian:
            roots += [d for c in chans for d in c.jacobian if d is not None]
        roots += list(sample.states.values())
        if jacobian:
            roots += list(sample.sensitivities.values())
        return roots

    @cached_property
    def staged(self) -> tuple[int, ...]:
        """Nodes of the sample alone (and of fixed parameters) that a loop needs: computed once per
        recording."""
        if self.batch:
            return ()
        sample, graph = self.program.step, self.program.step.graph
        found: set[int] = set()
        for m in self.measures:
            roots = self._roots(self.channels[m], True, sample)
            for at in graph.needed(roots):
                if self.masks[at] & (FREE | STATE):
                    found |= {a for a in graph.nodes[at].args if self.masks[a] == SAMPLE}
            found |= {r for r in roots if self.masks[r] == SAMPLE}
        if self.program.first is not None:
            part = self.program.step.part
            nodes = (*self.program.first.graph.nodes, *(part.graph.nodes if part else ()), *graph.nodes)
            raw = {str(n.data) for n in nodes if n.op == "in"} & set(self.inputs)
            found |= {graph.input(n) for n in raw}
        return tuple(sorted(found))

    def prepare(self) -> Region:
        """Loop that fills the staged arrays: body lines, and values = the staged quantities."""
        graph = self.program.step.graph
        masks = self.masks_of(self.program.step)
        need = graph.needed(self.staged)
        printer = Printer(self.program.step.graph)
        setup = self.parameters_in(printer, need, free=False)
        setup += printer.lines([a for a in need if masks[a] == 0], self.staged)
        body = self._inputs(printer, need) + printer.lines(
            [a for a in need if masks[a] == SAMPLE], self.staged
        )
        return Region(
            tuple(setup),
            tuple(body),
            tuple(printer.value(a) for a in self.staged),
            (),
            (),
            (),
            work(graph, need),
        )

    def kernel(self, measure: str, jacobian: bool) -> Region:
        """Loop body of the values (and Jacobian) of one measure, from staged arrays."""
        sample = self.program.step
        roots = self._roots(self.channels[measure], jacobian, sample)
        place = {at: f"work[{k} * stride + i]" for k, at in enumerate(self.staged)}
        raw = {n: f"work[{k} * stride + i]" for n, k in self._raw().items()}
        return self._region(sample, self.channels[measure], roots, jacobian, place, raw)

    def _raw(self) -> dict[str, int]:
        """Row of each input that is staged as it is."""
        nodes = self.program.step.graph.nodes
        return {str(nodes[a].data): k for k, a in enumerate(self.staged) if nodes[a].op == "in"}

    def initial(self, measure: str, jacobian: bool) -> Region:
        """The first sample of a time model, from the staged raw inputs at index 0."""
        sample = self.program.first
        assert sample is not None
        graph = sample.graph
        raw = self._raw()
        place = {graph.input(n): f"work[{raw[n]} * stride]" for n in self.inputs if n in raw}
        roots = self._roots(self.first_channels[measure], jacobian, sample)
        return self._region(sample, self.first_channels[measure], roots, jacobian, place)

    def _region(
        self,
        sample: Sample,
        chans: tuple[Channel, ...],
        roots: list[int],
        jacobian: bool,
        place: dict[int, str],
        raw: Mapping[str, str] | None = None,
    ) -> Region:
        graph, masks = sample.graph, self.masks_of(sample)
        need = [a for a in graph.needed_until(roots, set(place))]
        printer = Printer(sample.graph, functions=FUNCTION if self.state_names else BRANCHLESS)
        for n in (*self.state_names, *self.sensitivity_names):
            printer.names[graph.input(n)] = printer.fresh(c_name(n.replace(" ", "_")))
        setup = self.parameters_in(printer, need, free=True)
        inside = [a for a in need if masks[a] & (SAMPLE | STATE) and a not in place]
        hoisted = {a for at in inside for a in graph.nodes[at].args if not masks[a] & (SAMPLE | STATE)}
        outside = [a for a in need if not masks[a] & (SAMPLE | STATE) and a not in place]
        setup += printer.lines(outside, roots, hoisted)
        loads = []
        for at, text in place.items():
            if at in need:
                name = self.place_name(printer, at)
                loads.append(f"const double {name} = {text};")
        if self.batch:
            loads = self._inputs(printer, need)
        body = loads + printer.lines(inside, roots)
        used = [
            printer.names[graph.input(n)]
            for n in (*self.state_names, *(self.sensitivity_names if jacobian else ()))
        ]
        state_values = [printer.value(a) for a in sample.states.values()]
        if jacobian:
            state_values += [printer.value(a) for a in sample.sensitivities.values()]
        cost = work(graph, inside)
        if sample.part is not None:
            before, more = self._parts(sample.part, printer, raw or {}, jacobian)
            body, cost = [*before, *body], cost.with_loop(more, sample.part.count)
        return Region(
            tuple(setup), tuple(body),
            tuple(printer.value(c.value) for c in chans),
            tuple(
                tuple("0.0" if d is None else printer.value(d) for d in c.jacobian) for c in chans if jacobian
            ),
            tuple(used), tuple(state_values),
            cost,
        )  # fmt: skip

    def _parts(
        self, part: Part, outer: Printer, raw: Mapping[str, str], jacobian: bool
    ) -> tuple[list[str], Work]:
        """The loop that takes the states through all parts of a step, and the work of one part.

        outer: names of the states; raw: where inputs are.
        """
        graph, names = part.graph, tuple(part.results(jacobian))
        printer = Printer(graph, taken=set(outer.taken))
        need = graph.needed(part.results(jacobian).values())
        for n in (*self.state_names, *names):
            printer.names[graph.input(n)] = outer.names[outer.graph.input(n)]
        lines = self.parameters_in(printer, need, free=True)
        for name, text in raw.items():
            at = graph.input(name)
            if at in need:
                printer.names[at] = printer.fresh(c_name(name))
                lines.append(f"const double {printer.names[at]} = {text};")
        loop, cost = part_loop(part, printer, jacobian)
        return ["{", *(f"    {x}" for x in (*lines, *loop)), "}"], cost

    def everything(self, first: bool = False) -> Region:
        """Every equation, straight from inputs and parameters (nothing staged): what a reader of the paper
        wants."""
        sample = self.program.first if first and self.program.first else self.program.step
        graph = sample.graph
        c = Complex(graph)
        roots = [n for s in self.program.model.statements for n in _both(c, sample.equations[s.name])]
        masks = self.masks_of(sample)  # of the roots, too: a constant may be a new one
        need = graph.needed([*roots, *sample.states.values()])
        printer = Printer(sample.graph)
        for n in self.state_names:
            printer.names[graph.input(n)] = printer.fresh(c_name(n))
        setup = self.parameters_in(printer, need, free=True)
        setup += printer.lines([a for a in need if not masks[a] & (SAMPLE | STATE)], roots)
        body = self._inputs(printer, need) + printer.lines(
            [a for a in need if masks[a] & (SAMPLE | STATE)], roots
        )
        used = [printer.names[graph.input(n)] for n in self.state_names]
        values, states = (tuple(map(printer.value, ids)) for ids in (roots, sample.states.values()))
        cost = work(graph, need)
        if sample.part is not None:
            raw = {n: f"in[{k}][i]" for k, n in enumerate(self.inputs)}
            before, more = self._parts(sample.part, printer, raw, False)
            body, cost = [*before, *body], cost.with_loop(more, sample.part.count)
        return Region(tuple(setup), tuple(body), values, (), tuple(used), states, cost)

    def root(self, r: Root) -> Region:
        """Residual and slope of an implicit equation, as a function of its arguments and the unknown."""
        printer = Printer(r.graph)
        for n in (*r.arguments, r.unknown):
            printer.names[r.graph.input(n)] = printer.fresh(c_name(n))
        need = r.graph.needed([r.residual, r.slope])
        body = printer.lines(need, [r.residual, r.slope])
        return Region(
            (),
            tuple(body),
            (printer.value(r.residual), printer.value(r.slope)),
            (),
            (),
            (),
            work(r.graph, need),
        )

    def place_name(self, printer: Printer, at: int) -> str:
        """Give node `at` a name in C: the input's, that of the model's equation, or else its number."""
        label = printer.graph.labels.get(at)
        node = printer.graph.nodes[at]
        known = str(node.data) if node.op == "in" else label[0] if label else ""
        name = printer.fresh(c_name(known.replace(" ", "_")) if known else f"s{at}")
        printer.names[at] = name
        return name

    def parameters_in(self, printer: Printer, need: list[int], free: bool) -> list[str]:
        """Parameters that the nodes `need` use, as local constants; those that are fitted only if `free`."""
        if self.batch:
            return []
        lines = []
        for k, name in enumerate(self.parameters):
            at = printer.graph.input(name)
            if at in need and at not in printer.names and (free or name not in self.free):
                printer.names[at] = printer.fresh(c_name(name))
                lines.append(f"const double {printer.names[at]} = p[{k}];")
        return lines

    def _inputs(self, printer: Printer, need: list[int]) -> list[str]:
        lines = []
        for k, name in enumerate(self.parameters if self.batch else self.inputs):
            at = printer.graph.input(name)
            if at in need and at not in printer.names:
                printer.names[at] = printer.fresh(c_name(name))
                lines.append(f"const double {printer.names[at]} = in[{k}][i];")
        return lines


def _both(c: Complex, pair: Pair) -> list[int]:
    return [c.re(pair)] if pair[1] is None else [c.re(pair), c.im(pair)]
