"""Time models whose states are linear recurrences: tiles of samples, in which all but a scan runs in vector
loops."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import cached_property

from modelgen.codegen.affine import Recurrence, earlier, recurrences, special, specialised
from modelgen.codegen.channels import Channel, Form, channels
from modelgen.codegen.kernels import Region, Stages
from modelgen.codegen.loops import Lines, Stores, indent, marching, opening
from modelgen.codegen.real import Work
from modelgen.codegen.tile import Tile

TILE = 256
"""Samples whose intermediate values stay in the first cache."""


class Scan:
    """How the states of a time model are scanned; `condition` in C, empty if always.

    zero: nodes of the step that are 0 in the tiles meant.
    """

    def __init__(self, stages: Stages, zero: Collection[int] = ()) -> None:
        self.stages = stages
        step = stages.program.step
        values = special(step, stages.free)
        self.sample, self.moved = specialised(step, values, zero)
        at = {n: stages.parameters.index(n) for n in values}
        self.condition = " && ".join(f"p[{at[n]}] == {v!r}" for n, v in values.items())

    @cached_property
    def order(self) -> tuple[Recurrence, ...] | None:
        """States with their sensitivities; None if one is no linear recurrence."""
        return recurrences(self.sample) if self.stages.state_names else None

    @cached_property
    def lean(self) -> Scan | None:
        """The same in tiles of steps that are one stroke; None if they always are."""
        strokes = {self.sample.graph.nodes[at].args for at in self.strokes}
        both = strokes | {(b, a) for a, b in strokes}
        nodes = self.sample.graph.nodes
        zero = {at for at, to in self.moved.items() if nodes[to].op == "sub" and nodes[to].args in both}
        return Scan(self.stages, zero) if zero else None

    @cached_property
    def strokes(self) -> list[int]:
        """Differences of inputs that are 0 where a step is one stroke."""
        return earlier(self.sample, self.stages.masks_of(self.sample))

    def channels(self, measure: str, form: Form) -> tuple[Channel, ...]:
        return channels(self.stages.program, self.sample, measure, form)

    def shape(self, measure: str) -> Region:
        """What the last loop of a kernel with derivatives gives."""
        return Tile(self, measure, True, "residuals").last

    def states(self, jacobian: bool) -> tuple[Recurrence, ...]:
        """Those that are scanned: values alone need no sensitivities."""
        assert self.order is not None
        return tuple(x for x in self.order if jacobian or x.state in self.stages.state_names)

    def tile(
        self,
        measure: str,
        jacobian: bool,
        form: Form,
        names: dict[str, str],
        finish: Stores,
        after: Sequence[str],
    ) -> tuple[list[str], Work]:
        """Lines after the first sample, and the work of a sample.

        names: what states are called in C. finish: where the results of the last loop go; `after` follows in
        each tile of `count` samples.
        """
        plan = Tile(self, measure, jacobian, form)
        lean = None if self.lean is None else Tile(self.lean, measure, jacobian, form)
        lean = lean if lean is not None and lean.shape == plan.shape else None
        states = self.states(jacobian)
        lines = [] if lean else list(plan.setup)
        lines += [f"double mg_x{k}[MG_TILE + 1];" for k in range(len(states))]
        lines += [f"double mg_{a}{k}[MG_TILE];" for k in range(len(states)) for a in "ac"]
        kept = max(len(plan.kept), len(lean.kept) if lean else 0)
        lines += [f"double mg_k{k}[MG_TILE];" for k in range(kept)]
        lines += [f"mg_x{k}[0] = {names[x.state]};" for k, x in enumerate(states)]
        inner = ["const size_t count = n - base < MG_TILE ? n - base : MG_TILE;"]
        if lean:
            one, two = ([*x.setup, *x.lines(finish)] for x in (lean, plan))
            inner += [*plan.turns(self.strokes), "if (mg_turns == 0U) {", indent(one, 1)]
            inner += ["} else {", indent(two, 1), "}"]
        else:
            inner += plan.lines(finish)
        inner += [*after, *(f"mg_x{k}[0] = mg_x{k}[count];" for k in range(len(states)))]
        lines += ["for (size_t base = 1; base < n; base += MG_TILE) {", indent(inner, 1), "}"]
        return lines, plan.last.work


def scan_of(stages: Stages) -> Scan | None:
    """The scan of a time model, if its states are linear recurrences."""
    if not stages.program.model.states or stages.program.step.part:
        return None
    scan = Scan(stages)
    return scan if scan.order is not None else None


def over_time(
    stages: Stages, measure: str, jacobian: bool, form: Form, one: Lines, finish: Stores,
    after: Sequence[str] = (),
) -> tuple[list[str], Work]:  # fmt: skip
    """The first sample, then all others: by scans where the states allow it, else one after the other.

    one: what is done with a sample's results in a march, finish: in a tile, after: at its end.
    """
    region = stages.kernel(measure, jacobian, form)
    start = opening(region, stages.initial(measure, jacobian, form), one)
    scan = scan_of(stages)
    if scan is None:
        return [*start, *region.setup, *marching(region, one)], region.work
    known = (*stages.state_names, *stages.sensitivity_names)
    names = dict(zip(known, region.state_names, strict=False))
    tile, cost = scan.tile(measure, jacobian, form, names, finish, after)
    if scan.condition:
        one_by_one = [*region.setup, *marching(region, one)]
        tile = [f"if ({scan.condition}) {{", indent(tile, 1), "} else {", indent(one_by_one, 1), "}"]
    return [*start, *tile], cost
