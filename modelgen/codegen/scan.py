"""Time models whose states are linear recurrences: tiles of samples, in which all but a scan runs in vector
loops."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property

from modelgen.codegen.affine import Recurrence, recurrences, special, specialised, updates
from modelgen.codegen.algebra import FREE, SAMPLE, STATE
from modelgen.codegen.ctext import BRANCHLESS, Printer, c_name
from modelgen.codegen.kernels import Channel, Region, Stages, channels
from modelgen.codegen.loops import Stores, alone, indent, marching, opening
from modelgen.codegen.real import Graph, Work, work

TILE = 256
"""Samples whose intermediate values stay in the first cache."""
DEAR = 4
"""Operations from which on a value is kept between two loops, not computed twice."""
LOOP = SAMPLE | STATE
SLOW = {"exp", "log", "sin", "cos", "tan", "div", "sqrt", "pow", "atan2", "tanh", "call"}


@dataclass(frozen=True)
class Loop:
    """One vector loop over a tile: body, and the states (by number) that are scanned after it."""

    body: tuple[str, ...]
    scanned: tuple[int, ...]


class Scan:
    """How the states of a time model are scanned; `condition` in C, empty if always."""

    def __init__(self, stages: Stages) -> None:
        self.stages = stages
        step = stages.program.step
        values = special(step, stages.free)
        self.sample, self.moved = specialised(step, values)
        at = {n: stages.parameters.index(n) for n in values}
        self.condition = " && ".join(f"p[{at[n]}] == {v!r}" for n, v in values.items())

    @cached_property
    def order(self) -> tuple[Recurrence, ...] | None:
        """States with their sensitivities; None if one is no linear recurrence."""
        return recurrences(self.sample) if self.stages.state_names else None

    def channels(self, measure: str) -> tuple[Channel, ...]:
        return channels(self.stages.program, self.sample, measure)

    def shape(self, measure: str) -> Region:
        """What the last loop of a kernel with derivatives gives."""
        return _Tile(self, measure, True).last

    def states(self, jacobian: bool) -> tuple[Recurrence, ...]:
        """Those that are scanned: values alone need no sensitivities."""
        assert self.order is not None
        return tuple(x for x in self.order if jacobian or x.state in self.stages.state_names)

    def tile(
        self, measure: str, jacobian: bool, names: dict[str, str], finish: Stores, after: Sequence[str]
    ) -> tuple[list[str], Work]:
        """Lines after the first sample, and the work of a sample.

        names: what states are called in C. `finish` prints what the last loop does with its results at sample
        i = base + l; `after` follows in each tile of `count` samples.
        """
        plan = _Tile(self, measure, jacobian)
        states = self.states(jacobian)
        lines = list(plan.setup)
        lines += [f"double mg_x{k}[MG_TILE + 1];" for k in range(len(states))]
        lines += [f"double mg_{a}{k}[MG_TILE];" for k in range(len(states)) for a in "ac"]
        lines += [f"double mg_k{k}[MG_TILE];" for k in range(len(plan.kept))]
        lines += [f"mg_x{k}[0] = {names[x.state]};" for k, x in enumerate(states)]
        inner = ["const size_t count = n - base < MG_TILE ? n - base : MG_TILE;"]
        for loop in plan.loops():
            inner += _vector(loop.body)
            inner += [f"mg_scan(count, mg_a{k}, mg_c{k}, mg_x{k});" for k in loop.scanned]
        inner += _vector([*plan.last.body, *finish(plan.last)])
        inner += [*after, *(f"mg_x{k}[0] = mg_x{k}[count];" for k in range(len(states)))]
        lines += ["for (size_t base = 1; base < n; base += MG_TILE) {", indent(inner, 1), "}"]
        return lines, plan.last.work


class _Tile:
    """The loops of one kernel: what they compute, load and keep for each other."""

    def __init__(self, scan: Scan, measure: str, jacobian: bool) -> None:
        self.stages, self.sample = scan.stages, scan.sample
        self.graph: Graph = self.sample.graph
        self.states = scan.states(jacobian)
        self.chans = scan.channels(measure)
        self.roots = [c.value for c in self.chans]
        if jacobian:
            self.roots += [d for c in self.chans for d in c.jacobian if d is not None]
        self.masks = self.stages.masks_of(self.sample)
        staged = {scan.moved[at]: k for k, at in enumerate(self.stages.staged)}
        self.place = {at: f"work[{k} * stride + i]" for at, k in staged.items() if at not in self._fixed()}
        new = updates(self.sample)
        for k, x in enumerate(self.states):
            self.place[self.graph.input(x.state)] = f"mg_x{k}[l]"
            self.place.setdefault(new[x.state], f"mg_x{k}[l + 1]")
            update = self.graph.nodes[new[x.state]]
            if update.op == "neg":  # a sign that factors take along
                self.place.setdefault(update.args[0], f"-mg_x{k}[l + 1]")
        self.kept = self._kept()
        self.printer = Printer(self.graph, functions=BRANCHLESS)
        for name in (*self.stages.state_names, *self.stages.sensitivity_names):
            self.printer.taken.add(c_name(name.replace(" ", "_")))  # what the first sample leaves
        self.setup = self._setup()
        self.last = self._last(jacobian)

    def _fixed(self) -> set[int]:
        return {at for at, node in enumerate(self.graph.nodes) if node.op == "const"}

    def _level(self, level: int) -> list[tuple[int, Recurrence]]:
        return [(k, x) for k, x in enumerate(self.states) if x.level == level]

    def _keeps(self, level: int) -> tuple[int, ...]:
        return self.kept if level == 0 else ()

    def _levels(self) -> range:
        return range(1 + max(x.level for x in self.states))

    def _later(self) -> list[int]:
        """What is computed after the first loop."""
        return [*self.roots, *(at for x in self.states if x.level for at in (x.factor, x.rest))]

    def _kept(self) -> tuple[int, ...]:
        """Dear values without a part of any state, which the first loop keeps for later ones."""
        found: set[int] = set()
        seen: set[int] = set()
        stack = self._later()
        while stack:
            at = stack.pop()
            if at in seen or at in self.place:
                continue
            seen.add(at)
            if self.masks[at] == SAMPLE | FREE and self._dear(at):
                found.add(at)
            else:
                stack.extend(self.graph.nodes[at].args)
        return tuple(sorted(found))

    def _dear(self, at: int) -> bool:
        need = [a for a in self.graph.needed_until([at], set(self.place)) if self.masks[a] == SAMPLE | FREE]
        ops = [self.graph.nodes[a].op for a in need if a not in self.place]
        return len(ops) >= DEAR or bool(SLOW & set(ops))

    def _setup(self) -> list[str]:
        """Parameters, and what depends on them alone."""
        graph, masks = self.graph, self.masks
        rows = [at for x in self.states for at in (x.factor, x.rest)]
        roots = [*self.roots, *rows]
        found = set(graph.needed_until(self.roots, set(self._given(len(self.states) + 1))))
        for level in self._levels():
            now = [at for _, x in self._level(level) for at in (x.factor, x.rest)]
            found.update(graph.needed_until([*now, *self._keeps(level)], set(self._given(level))))
        need = sorted(found)
        inside = [a for a in need if masks[a] & LOOP and a not in self.place]
        hoisted = {a for at in inside for a in graph.nodes[at].args if not masks[a] & LOOP}
        outside = [a for a in need if not masks[a] & LOOP and a not in self.place]
        lines = self.stages.parameters_in(self.printer, need, masks, free=True)
        return lines + self.printer.lines(outside, roots, hoisted)

    def _body(self, roots: Iterable[int], given: dict[int, str]) -> tuple[list[str], Printer, list[int]]:
        """Loads and lines that compute `roots` from what is `given`, and the nodes of these lines."""
        roots = list(roots)
        printer = copy(self.printer)
        printer.names, printer.taken = dict(self.printer.names), set(self.printer.taken)
        need = self.graph.needed_until(roots, set(given))
        loads = []
        for at, text in given.items():
            if at in need and self.graph.nodes[at].op != "const":
                loads.append(f"const double {self._name(printer, at)} = {text};")
        inside = [a for a in need if self.masks[a] & LOOP and a not in given]
        lines = [*loads, *printer.lines(inside, roots)]
        return lines, printer, inside

    def _name(self, printer: Printer, at: int) -> str:
        """Of a loaded value; what a state was at the sample before is told from what it becomes."""
        if not self.masks[at] & STATE or self.graph.nodes[at].op != "in":
            return self.stages.place_name(printer, self.graph, at)
        state = str(self.graph.nodes[at].data).replace(" ", "_")
        printer.names[at] = printer.fresh(c_name(f"{state}_before"))
        return printer.names[at]

    def loops(self) -> list[Loop]:
        """One loop a level: factors and rests of its states; the first keeps what others need."""
        made = []
        for level in self._levels():
            states = self._level(level)
            kept = self._keeps(level)
            roots = [at for _, x in states for at in (x.factor, x.rest)]
            given = self._given(level)
            lines, printer, _ = self._body([*roots, *kept], given)
            for k, x in states:
                lines += [
                    f"mg_a{k}[l] = {printer.value(x.factor)};",
                    f"mg_c{k}[l] = {printer.value(x.rest)};",
                ]
            lines += [f"mg_k{k}[l] = {printer.value(at)};" for k, at in enumerate(kept)]
            made.append(Loop(tuple(lines), tuple(k for k, _ in states)))
        return made

    def _given(self, level: int) -> dict[int, str]:
        """What a loop can load: staged values, states scanned before it, what the first loop has kept."""
        later = [k for k, x in enumerate(self.states) if x.level >= level]
        hidden = {f"{sign}mg_x{k}[{at}]" for k in later for at in ("l", "l + 1") for sign in ("", "-")}
        given = {at: text for at, text in self.place.items() if text not in hidden}
        if level:
            given |= {at: f"mg_k{k}[l]" for k, at in enumerate(self.kept)}
        return given

    def _last(self, jacobian: bool) -> Region:
        lines, printer, inside = self._body(self.roots, self._given(len(self.states) + 1))
        before = {at for x in self.states for at in (x.factor, x.rest)} | set(self.kept)
        need = [a for a in self.graph.needed_until(before, set(self.place)) if self.masks[a] & SAMPLE]
        cost = work(self.graph, {*inside, *(a for a in need if a not in self.place)})
        cost = cost.plus(2 * len(self.states))
        jac = tuple(
            tuple("0.0" if d is None else printer.value(d) for d in c.jacobian)
            for c in self.chans
            if jacobian
        )
        values = tuple(printer.value(c.value) for c in self.chans)
        return Region((), tuple(lines), values, jac, (), (), cost)


def _vector(body: Iterable[str]) -> list[str]:
    lines = list(body)
    used = ["const size_t i = base + l;"] if any("stride + i" in x for x in lines) else []
    return [
        *alone(lines), "for (size_t l = 0; l < count; ++l) {", indent([*used, *lines], 1), "}",
    ]  # fmt: skip


def scan_of(stages: Stages) -> Scan | None:
    """The scan of a time model, if its states are linear recurrences."""
    if not stages.program.model.states:
        return None
    scan = Scan(stages)
    return scan if scan.order is not None else None


def over_time(
    stages: Stages, measure: str, jacobian: bool, stores: Stores, finish: Stores, after: Sequence[str] = ()
) -> tuple[list[str], Work]:
    """The first sample, then all others: by scans where the states allow it, else one after the other.

    stores: what is done with a sample's results in a march, finish: in a tile, after: at its end.
    """
    region = stages.kernel(measure, jacobian)
    start = opening(region, stages.initial(measure, jacobian), stores)
    one_by_one = [*region.setup, *marching(region, stores)]
    scan = scan_of(stages)
    if scan is None:
        return [*start, *one_by_one], region.work
    known = (*stages.state_names, *stages.sensitivity_names)
    names = dict(zip(known, region.state_names, strict=False))
    tile, cost = scan.tile(measure, jacobian, names, finish, after)
    if scan.condition:
        tile = [f"if ({scan.condition}) {{", indent(tile, 1), "} else {", indent(one_by_one, 1), "}"]
    return [*start, *tile], cost
