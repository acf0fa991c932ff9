"""A model's structs and functions for a controller, made from its program."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from modelgen.codegen.build import default_wrt
from modelgen.codegen.ctext import Printer, c_name, comment
from modelgen.codegen.parts import part_loop
from modelgen.codegen.program import Part, Program, Sample, build_program, sensitivity
from modelgen.codegen.real import Work, work
from modelgen.codegen.split import Pair
from modelgen.errors import InputError
from modelgen.export.rewrite import at_start, at_step, inputs_of, only, rewrite, rewrite_root, step_name
from modelgen.export.stores import bare, broken, guarded
from modelgen.export.unit import Routine, Slot, Unit, member
from modelgen.language import Model
from modelgen.language.derived import values_before
from modelgen.language.model import check_name


def make_unit(
    model: Model,
    fixed: Mapping[str, float] | None = None,
    wrt: Sequence[str] | None = None,
    prefix: str = "",
) -> Unit:
    """Lower `model` for a controller; parameters in `fixed` become numbers in the code.

    Raises InputError when a name in `fixed` is no parameter, or no file can have the name of `prefix`.
    """
    fixed = dict(fixed or {})
    for name in fixed:
        model.parameter(name)
    columns = tuple(n for n in (default_wrt(model) if wrt is None else wrt) if n not in fixed)
    columns = columns or tuple(p.name for p in model.scalar_parameters if p.name not in fixed)
    program = build_program(model, columns)
    outputs = tuple(o.name for o in model.outputs)
    roots = [rewrite_root(r, fixed) for r in program.roots]
    kept = {r.name: arguments for r, arguments in roots}
    program = replace(program, roots=tuple(r for r, _ in roots))
    step = rewrite(only(program, program.step, outputs), at_step(model, fixed, kept))
    first = rewrite(only(program, program.first or program.step, outputs), at_start(model, fixed, kept))
    return _Maker(model, program, step, first, _prefix(model, prefix), fixed).unit()


HEADERS = (
    *("assert", "complex", "ctype", "errno", "fenv", "float", "inttypes", "iso646", "limits", "locale"),
    *("math", "setjmp", "signal", "stdarg", "stdbool", "stddef", "stdint", "stdio", "stdlib", "string"),
    *("tgmath", "time", "wchar", "wctype"),
)
"""Of C99: a file of that name beside the C hides them."""


def _prefix(model: Model, name: str) -> str:
    """What files and functions begin with."""
    found = check_name(name, "--name") if name else c_name(model.id)
    if found.lower() in HEADERS:
        raise InputError(f"'{found}.h' is a header of C: another --name is wanted, such as '{found}_model'")
    return found


class _Maker:
    """Collects the slots of a unit, then prints its functions."""

    def __init__(
        self,
        model: Model,
        program: Program,
        step: Sample,
        first: Sample,
        prefix: str,
        fixed: dict[str, float],
    ) -> None:
        self.model, self.program, self.step, self.first = model, program, step, first
        self.prefix, self.fixed, self.since = prefix, fixed, step_name(model)
        needed = inputs_of(step)
        self.previous = {n: of for n, of in values_before(model).items() if n in needed}
        self.steps = bool(model.states or self.previous)
        if self.steps:
            needed |= inputs_of(first)
        self.needed = needed | set(self.previous.values())

    def unit(self) -> Unit:
        parameters = tuple(
            Slot(p.name, member(p.name), comment(p.unit), comment(p.text))
            for p in self.model.scalar_parameters
            if p.name not in self.fixed and p.name in self.needed
        )
        self.parameters = parameters
        self.inputs = self._inputs()
        self.states = tuple(
            Slot(s.name, member(s.name), comment(s.unit), comment(f"{s.ref} {s.text}".strip()))
            for s in self.model.states
        ) + tuple(
            Slot(n, member(n), comment(i.unit), comment(i.text))
            for i in self.model.inputs
            for n in [i.name]
            if n in self.previous
        )
        self.tangents = tuple(
            Slot(sensitivity(n, d), f"d_{n}_{self._direction(d)}", text=f"d{n}/d({self._direction(d)})")
            for n, d in self.step.sensitivities
        )
        self.outputs = tuple(s for o in self.model.outputs for s in self._output(o.name))
        rows = tuple(s.name for o in self.program.outputs for s in self._output(o))
        return Unit(
            self.model, self.program, self.prefix, self.since, tuple(self.fixed.items()), parameters,
            self.inputs, self.states, self.tangents, self.outputs, rows, self.program.wrt, self._routines(),
        )  # fmt: skip

    def _direction(self, d: int) -> str:
        """Sensitivities go by directions, which the program numbers as its columns, complex ones after."""
        wrt = self.program.wrt
        return wrt[d] if d < len(wrt) else f"direction_{d}"

    def _inputs(self) -> tuple[Slot, ...]:
        found = [
            Slot(i.name, member(i.name), comment(i.unit), comment(i.text))
            for i in self.model.inputs
            if i.name in self.needed and i.name not in self.previous
        ]
        if self.since in self.needed:
            clock = self.model.inputs[0]
            found.insert(0, Slot(self.since, self.since, comment(clock.unit), "time since the sample before"))
        return tuple(found)

    def _output(self, name: str) -> list[Slot]:
        statement, pair = self.model[name], self.step.equations[name]
        unit, says = comment(statement.unit), comment(f"{statement.ref} {statement.text}".strip())
        if pair[1] is None:
            return [Slot(name, member(name), unit, says)]
        return [Slot(f"{name}_{p}", member(f"{name}_{p}"), unit, says) for p in ("re", "im")]

    # -- functions

    def _routines(self) -> tuple[Routine, ...]:
        kinds = [
            ("start", "First sample: sets the state", self.first, False),
            ("step", "Next sample: advances the state", self.step, False),
            ("start_jacobian", "First sample, with derivatives by parameters", self.first, True),
            ("step_jacobian", "Next sample, with derivatives by parameters", self.step, True),
        ]
        if not self.steps:
            kinds = [
                ("evaluate", "Outputs at one sample", self.step, False),
                ("jacobian", "Outputs and their derivatives by parameters", self.step, True),
            ]
        return tuple(self._routine(*k) for k in kinds if self.program.wrt or not k[3])

    def _routine(self, name: str, says: str, sample: Sample, jacobian: bool) -> Routine:
        starts = name.startswith("start")
        results = _results(sample, self.program, self.outputs_of(sample, jacobian), jacobian)
        roots = list(results.all())
        need = sample.graph.needed(roots)
        printer = Printer(sample.graph)
        body = self._loads(printer, need, starts, _Moving.of(sample, jacobian))
        cost = work(sample.graph, need)
        if sample.part is not None:
            loop, more = self._parts(sample.part, printer, jacobian)
            body, cost = [*body, *loop], cost.with_loop(more, sample.part.count)
        body += printer.lines(need, roots)
        kept = [f"state->{s.member} = " for s in self.states]
        values = [printer.value(at) for at in results.states]
        values += [printer.value(sample.graph.input(of)) for of in self.previous.values()]
        stores = [k + bare(v) + ";" for k, v in zip(kept, values, strict=True)]
        stores += [
            f"out->{s.member} = {bare(printer.value(at))};"
            for s, at in zip(self.outputs, results.outputs, strict=True)
        ]
        checked = [printer.value(at) for at in dict.fromkeys(results.all())]
        if jacobian:
            stores += [
                f"tangent->{s.member} = {bare(printer.value(at))};"
                for s, at in zip(self.tangents, results.tangents, strict=True)
            ]
            width = len(self.program.wrt)
            stores += [
                f"jac[{k // width}][{k % width}] = {'0.0' if at is None else bare(printer.value(at))};"
                for k, at in enumerate(results.jacobian)
            ]
        body += guarded(checked, stores)
        arguments = self._arguments(name, jacobian)
        unused = [x for x in ("p", "in") if not re.search(rf"\b{x}->", "\n".join(body))]
        body = [*(f"(void){x};" for x in unused if re.search(rf"\*{x}\b", arguments)), *body]
        return Routine(name, says, arguments, tuple(body), cost.operations)

    def _parts(self, part: Part, outer: Printer, jacobian: bool) -> tuple[list[str], Work]:
        """The loop over the parts of a step, in the names of `outer`; and the work of one."""
        printer = Printer(part.graph, taken=outer.taken)
        for at, node in enumerate(outer.graph.nodes):
            if node.op == "in" and at in outer.names:
                printer.names[part.graph.input(str(node.data))] = outer.names[at]
        return part_loop(part, printer, jacobian)

    def outputs_of(self, sample: Sample, jacobian: bool) -> list[Pair]:
        """Values as the source writes them; beside derivatives, in the form that these share."""
        form = {**sample.equations, **(sample.fitted if jacobian else {})}
        return [form[o.name] for o in self.model.outputs]

    def _arguments(self, name: str, jacobian: bool) -> str:
        """Those of the function called `name`, over several lines where one would be too long."""
        parts = [f"const {self.prefix}_parameters *p"]
        if self.inputs:
            parts.append(f"const {self.prefix}_input *in")
        if self.steps:
            parts.append(f"{self.prefix}_state *state")
        if jacobian and self.tangents:
            parts.append(f"{self.prefix}_tangent *tangent")
        parts.append(f"{self.prefix}_output *out")
        if jacobian:
            parts.append(f"double jac[{self.prefix.upper()}_ROWS][{self.prefix.upper()}_COLUMNS]")
        return broken(parts, ", ", len(f"int {self.prefix}_{name}();"))

    def _loads(self, printer: Printer, need: list[int], starts: bool, moving: _Moving) -> list[str]:
        """Struct members that the body uses, as local constants; variables where a loop moves them."""
        lines = []
        groups: list[tuple[str, Sequence[Slot]]] = [("p", self.parameters), ("in", self.inputs)]
        if not starts:
            groups += [("state", self.states), ("tangent", self.tangents)]
        wanted = {*need, *(printer.graph.input(of) for of in self.previous.values())}
        for pointer, slots in groups:
            for s in slots:
                at = printer.graph.input(s.name)
                if at in wanted or s.name in moving.needs:
                    local = printer.fresh(c_name(s.member))
                    printer.names[at] = local
                    kind = "double" if s.name in moving.names else "const double"
                    lines.append(f"{kind} {local} = {pointer}->{s.member};")
        return lines


@dataclass(frozen=True)
class _Moving:
    """What the loop over the parts of a step needs, and the `names` among that which it changes."""

    needs: frozenset[str] = frozenset()
    names: frozenset[str] = frozenset()

    @staticmethod
    def of(sample: Sample, jacobian: bool) -> _Moving:
        if sample.part is None:
            return _Moving()
        results = sample.part.results(jacobian)
        return _Moving(frozenset(sample.part.graph.inputs(results.values())), frozenset(results))


@dataclass(frozen=True)
class _Results:
    states: tuple[int, ...]
    outputs: tuple[int, ...]
    tangents: tuple[int, ...]
    jacobian: tuple[int | None, ...]

    def all(self) -> list[int]:
        return [
            *self.states, *self.outputs, *self.tangents, *(at for at in self.jacobian if at is not None)
        ]  # fmt: skip


def _results(sample: Sample, program: Program, outputs: list[Pair], jacobian: bool) -> _Results:
    zero = sample.graph.const(0.0)
    values: list[int] = []
    for re_, im in outputs:
        values += [zero if re_ is None else re_] + ([] if im is None else [im])
    slopes: list[int | None] = []
    for o in program.outputs if jacobian else ():
        parts = (0,) if sample.equations[o][1] is None else (0, 1)
        slopes += [d[k] for k in parts for d in sample.jacobian[o]]
    tangents = tuple(sample.sensitivities.values()) if jacobian else ()
    return _Results(tuple(sample.states.values()), tuple(values), tangents, tuple(slopes))
