"""From a real program to the pieces of its C kernels: what is staged per recording, per parameter set, per
sample."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from modelgen.codegen.algebra import FREE, SAMPLE, STATE
from modelgen.codegen.channels import Channel, Form, channels, is_measured, measured
from modelgen.codegen.ctext import BRANCHLESS, FUNCTION, Printer, c_name
from modelgen.codegen.parts import part_loop
from modelgen.codegen.program import Part, Program, Root, Sample, sensitivity
from modelgen.codegen.real import Work, work
from modelgen.codegen.split import Complex, Pair


@dataclass(frozen=True, eq=False)
class Region:
    """What one loop body loads, computes and gives.

    setup: C before the loop; given: where nodes are loaded from; inside: nodes computed; results are nodes,
    which `text` prints (None: a derivative that is zero). before: C at the body's begin.
    """

    printer: Printer
    setup: tuple[str, ...]
    given: Mapping[int, str]
    inside: tuple[int, ...]
    values: tuple[int, ...]
    jacobian: tuple[tuple[int | None, ...], ...]
    state_names: tuple[str, ...]
    state_values: tuple[int, ...]
    work: Work
    before: tuple[str, ...] = ()

    @cached_property
    def body(self) -> tuple[str, ...]:
        """The lines of C."""
        graph, printer = self.printer.graph, self.printer
        loads = []
        for at, place in self.given.items():
            if graph.nodes[at].op != "const":
                loads.append(f"const double {place_name(printer, at)} = {place};")
        roots = [
            *self.values,
            *(d for row in self.jacobian for d in row if d is not None),
            *self.state_values,
        ]
        return (*self.before, *loads, *printer.lines(self.inside, roots))

    def text(self, at: int | None, alone: bool = False) -> str:
        """A result in C, after `body`: an atom or in parentheses, unless it stands alone."""
        if at is None:
            return "0.0"
        return self.printer.whole(at) if alone else self.printer.value(at)

    def columns(self, channel: int) -> list[tuple[int, int]]:
        """Derivatives of a channel that are not zero everywhere: column, node."""
        value = self.printer.graph.value
        return [(k, d) for k, d in enumerate(self.jacobian[channel]) if d is not None and value(d) != 0]


class Stages:
    """Which nodes are computed when, for one program; makes the regions that templates print."""

    def __init__(
        self, program: Program, measures: Sequence[str] | None = None, taped: bool = False
    ) -> None:  # fmt: skip
        self.program = program
        self.batch = not program.model.inputs
        self.taped = taped and not self.batch
        self.free = set(program.wrt)
        self.inputs = [i.name for i in program.model.inputs]
        self.parameters = [p.name for p in program.model.scalar_parameters]
        self.state_names = [s.name for s in program.model.states]
        self.sensitivity_names = [sensitivity(n, d) for n, d in program.step.sensitivities]
        possible = ("complex", "modulus", "phase") if any(program.complex_outputs) else ("real",)
        self.measures = tuple(m for m in possible if measures is None or m in measures)
        self.channels = {m: channels(program, program.step, m) for m in self.measures}

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
                sampled = name in self.inputs or self.batch or is_measured(name)
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
        return roots + self._states(jacobian, sample)

    def _states(self, jacobian: bool, sample: Sample) -> list[int]:
        return [*sample.states.values(), *(sample.sensitivities.values() if jacobian else ())]

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
        """Loop that fills the staged arrays; values = the staged quantities."""
        graph = self.program.step.graph
        masks = self.masks_of(self.program.step)
        need = graph.needed(self.staged)
        printer = Printer(graph)
        setup = self.parameters_in(printer, need, free=False)
        setup += printer.lines([a for a in need if masks[a] == 0], self.staged)
        given = self._inputs(printer, need)
        inside = tuple(a for a in need if masks[a] == SAMPLE and a not in given)
        return Region(
            printer, tuple(setup), given, inside, self.staged, (), (), (), work(graph, need)
        )  # fmt: skip

    def kernel(self, measure: str, jacobian: bool, form: Form = "values") -> Region:
        """Loop body of the values (and Jacobian) of one measure, from staged arrays."""
        sample = self.program.step
        chans = channels(self.program, sample, measure, form)
        raw = {n: f"work[{k} * stride + i]" for n, k in self._raw().items()}
        place = {at: f"work[{k} * stride + i]" for k, at in enumerate(self.staged)}
        return self._region(sample, chans, jacobian, place, raw)

    def _raw(self) -> dict[str, int]:
        """Row of each input that is staged as it is."""
        nodes = self.program.step.graph.nodes
        return {str(nodes[a].data): k for k, a in enumerate(self.staged) if nodes[a].op == "in"}

    def initial(self, measure: str, jacobian: bool, form: Form = "values") -> Region:
        """The first sample of a time model, from the staged raw inputs at index 0."""
        sample = self.program.first
        assert sample is not None
        chans, graph, raw = channels(self.program, sample, measure, form), sample.graph, self._raw()
        place = {graph.input(n): f"work[{raw[n]} * stride]" for n in self.inputs if n in raw}
        return self._region(sample, chans, jacobian, place)

    def _region(
        self,
        sample: Sample,
        chans: tuple[Channel, ...],
        jacobian: bool,
        place: Mapping[int, str],
        raw: Mapping[str, str] | None = None,
    ) -> Region:
        graph = sample.graph
        place = {**place, **{graph.input(n): at for n, at in measured(2 * len(self.program.outputs)).items()}}
        masks = self.masks_of(sample)
        roots = self._roots(chans, jacobian, sample)
        need = graph.needed_until(roots, set(place))
        names = {at: name for c in chans for at, name in c.called.items()}
        printer = Printer(graph, functions=FUNCTION if self.state_names else BRANCHLESS, called=names)
        for n in (*self.state_names, *self.sensitivity_names):
            printer.names[graph.input(n)] = printer.fresh(c_name(n.replace(" ", "_")))
        setup = self.parameters_in(printer, need, free=True)
        needed = set(need)
        given = {at: text for at, text in place.items() if at in needed}
        if self.batch:
            given = self._inputs(printer, need)
        inside = [a for a in need if masks[a] & (SAMPLE | STATE) and a not in given]
        hoisted = {a for at in inside for a in graph.nodes[at].args if not masks[a] & (SAMPLE | STATE)}
        outside = [a for a in need if not masks[a] & (SAMPLE | STATE) and a not in place]
        setup += printer.lines(outside, roots, hoisted)
        used = [
            printer.names[graph.input(n)]
            for n in (*self.state_names, *(self.sensitivity_names if jacobian else ()))
        ]
        cost, before = work(graph, inside), list[str]()
        if sample.part is not None:
            before, more = self._parts(sample.part, printer, raw or {}, jacobian)
            cost = cost.with_loop(more, sample.part.count)
        return Region(
            printer, tuple(setup), given, tuple(inside), tuple(c.value for c in chans),
            tuple(c.jacobian for c in chans if jacobian), tuple(used), tuple(self._states(jacobian, sample)),
            cost, tuple(before),
        )  # fmt: skip

    def _parts(
        self, part: Part, outer: Printer, raw: Mapping[str, str], jacobian: bool
    ) -> tuple[list[str], Work]:
        """The loop that takes the states through all parts of a step, and the work of one part.

        outer: names of the states, of which some stay as they are; raw: where inputs are.
        """
        graph = part.graph
        printer = Printer(graph, taken=set(outer.taken))
        need = graph.needed(part.results(jacobian).values())
        for n in (*self.state_names, *(self.sensitivity_names if jacobian else ())):
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
        given = self._inputs(printer, need)
        inside = [a for a in need if masks[a] & (SAMPLE | STATE) and a not in given]
        used = [printer.names[graph.input(n)] for n in self.state_names]
        cost, before = work(graph, need), list[str]()
        if sample.part is not None:
            raw = {n: f"in[{k}][i]" for k, n in enumerate(self.inputs)}
            before, more = self._parts(sample.part, printer, raw, False)
            cost = cost.with_loop(more, sample.part.count)
        return Region(
            printer, tuple(setup), given, tuple(inside), tuple(roots), (), tuple(used),
            tuple(sample.states.values()), cost, tuple(before),
        )  # fmt: skip

    def root(self, r: Root) -> Region:
        """Residual and slope of an implicit equation, as a function of its arguments and the unknown."""
        printer = Printer(r.graph)
        for n in (*r.arguments, r.unknown):
            printer.names[r.graph.input(n)] = printer.fresh(c_name(n))
        need = r.graph.needed([r.residual, r.slope])
        return Region(
            printer, (), {}, tuple(need), (r.residual, r.slope), (), (), (), work(r.graph, need)
        )  # fmt: skip

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

    def _inputs(self, printer: Printer, need: list[int]) -> dict[int, str]:
        """Where the inputs are that the nodes `need` use."""
        names = self.parameters if self.batch else self.inputs
        places = {printer.graph.input(name): f"in[{k}][i]" for k, name in enumerate(names)}
        return {at: text for at, text in places.items() if at in need and at not in printer.names}


def place_name(printer: Printer, at: int) -> str:
    """Give node `at` a name in C: what it is called, the input's, the equation's, or its number."""
    label = printer.graph.labels.get(at)
    node = printer.graph.nodes[at]
    known = str(node.data).replace(" ", "_") if node.op == "in" else label[0] if label else ""
    name = printer.fresh(printer.called.get(at) or (c_name(known) if known else f"s{at}"))
    printer.names[at] = name
    return name


def _both(c: Complex, pair: Pair) -> list[int]:
    return [c.re(pair)] if pair[1] is None else [c.re(pair), c.im(pair)]
