"""A tile of samples of a time model with scanned states: vector loops, and scans between them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from modelgen.codegen.affine import Recurrence, updates
from modelgen.codegen.algebra import FREE, SAMPLE, STATE
from modelgen.codegen.channels import Form, measured
from modelgen.codegen.ctext import BRANCHLESS, Printer, c_name
from modelgen.codegen.kernels import Region
from modelgen.codegen.loops import Stored, Stores, each, tile
from modelgen.codegen.real import Graph, work
from modelgen.codegen.tape import record

if TYPE_CHECKING:
    from modelgen.codegen.scan import Scan

DEAR = 4
"""Operations from which on a value is kept between two loops, not computed twice."""
LOOP = SAMPLE | STATE
SLOW = {"exp", "log", "sin", "cos", "tan", "div", "sqrt", "pow", "atan2", "tanh", "call"}


@dataclass(frozen=True)
class Loop:
    """One vector loop over a tile: what it computes and where that goes, and the states (by number) that are
    scanned after it."""

    region: Region
    stored: Stored
    scanned: tuple[int, ...]


class Tile:
    """The loops of one kernel: what they compute, load and keep for each other."""

    def __init__(self, scan: Scan, measure: str, jacobian: bool, form: Form) -> None:
        self.stages, self.sample = scan.stages, scan.sample
        self.graph: Graph = self.sample.graph
        self.states = scan.states(jacobian)
        self.chans = scan.channels(measure, form)
        self.roots = [c.value for c in self.chans]
        if jacobian:
            self.roots += [d for c in self.chans for d in c.jacobian if d is not None]
        self.masks = self.stages.masks_of(self.sample)
        staged = {scan.moved[at]: k for k, at in enumerate(self.stages.staged)}
        self.place = {at: f"work[{k} * stride + i]" for at, k in staged.items() if at not in self._fixed()}
        known = measured(2 * len(self.stages.program.outputs))
        self.place |= {self.graph.input(n): at for n, at in known.items()}
        new = updates(self.sample)
        for k, x in enumerate(self.states):
            self.place[self.graph.input(x.state)] = f"mg_x{k}[l]"
            self.place.setdefault(new[x.state], f"mg_x{k}[l + 1]")
            update = self.graph.nodes[new[x.state]]
            if update.op == "neg":  # a sign that factors take along
                self.place.setdefault(update.args[0], f"-mg_x{k}[l + 1]")
        self.kept = self._kept()
        names = {at: name for c in self.chans for at, name in c.called.items()}
        for x in self.states:  # what a state was at the sample before is told from what it becomes
            names[self.graph.input(x.state)] = c_name(f"{x.state}_before".replace(" ", "_"))
        self.printer = Printer(self.graph, functions=BRANCHLESS, called=names)
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
        lines = self.stages.parameters_in(self.printer, need, free=True)
        return lines + self.printer.lines(outside, roots, hoisted)

    def _region(
        self, roots: Iterable[int], given: dict[int, str], jacobian: Iterable[Sequence[int | None]] = ()
    ) -> Region:  # fmt: skip
        """What computes `roots`, and `jacobian`, from what is `given`."""
        values, rows = tuple(roots), tuple(map(tuple, jacobian))
        printer = copy(self.printer)
        printer.names, printer.taken = dict(self.printer.names), set(self.printer.taken)
        slopes = [d for row in rows for d in row if d is not None]
        need = self.graph.needed_until([*values, *slopes], set(given))
        needed = set(need)
        loads = {at: text for at, text in given.items() if at in needed}
        inside = tuple(a for a in need if self.masks[a] & LOOP and a not in given)
        return Region(printer, (), loads, inside, values, rows, (), (), work(self.graph, inside))

    @property
    def shape(self) -> tuple[Any, ...]:
        """What tiles must have in common to take turns: states in their order, derivatives that are 0."""
        columns = (tuple(k for k, _ in self.last.columns(c)) for c in range(len(self.last.jacobian)))
        return tuple(x.state for x in self.states), tuple(columns)

    def turns(self, strokes: Sequence[int]) -> list[str]:
        """Whether any of `strokes` is not 0 in this tile."""
        region = self._region(strokes, self._given(0))
        first = "unsigned mg_turns = 0U; /* whether the path turns inside of a step */"
        if not self.stages.taped:
            some = [*region.body]
            some += [f"mg_turns |= {region.text(at)} != 0.0 ? 1U : 0U;" for at in strokes]
            return [first, *each(some)]
        rows = range(len(strokes))
        return [
            first, f"double mg_stroke[{len(strokes)}][MG_TILE];",
            *record(region, [(f"mg_stroke[{k}][l]", strokes[k]) for k in rows]),
            *(f"mg_turns |= mg_tape_any(count, mg_stroke[{k}]);" for k in rows),
        ]  # fmt: skip

    def lines(self, finish: Stores) -> list[str]:
        """The loops of a tile and the scans between them."""
        lines: list[str] = []
        for loop in self.loops():
            lines += tile(self.stages, loop.region, loop.stored)
            lines += [f"mg_scan(count, mg_a{k}, mg_c{k}, mg_x{k});" for k in loop.scanned]
        return [*lines, *tile(self.stages, self.last, finish(self.last))]

    def loops(self) -> list[Loop]:
        """One loop a level: factors and rests of its states; the first keeps what others need."""
        made = []
        for level in self._levels():
            states, kept = self._level(level), self._keeps(level)
            results = [(f"mg_a{k}[l]", x.factor) for k, x in states]
            results += [(f"mg_c{k}[l]", x.rest) for k, x in states]
            results += [(f"mg_k{k}[l]", at) for k, at in enumerate(kept)]
            region = self._region([at for _, at in results], self._given(level))
            made.append(Loop(region, results, tuple(k for k, _ in states)))
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
        slopes = [c.jacobian for c in self.chans] if jacobian else []
        region = self._region([c.value for c in self.chans], self._given(len(self.states) + 1), slopes)
        before = {at for x in self.states for at in (x.factor, x.rest)} | set(self.kept)
        need = [a for a in self.graph.needed_until(before, set(self.place)) if self.masks[a] & SAMPLE]
        cost = work(self.graph, {*region.inside, *(a for a in need if a not in self.place)})
        return replace(region, work=cost.plus(2 * len(self.states)))
