"""A loop over samples as a tape for the machine: operations on vectors, and the registers that hold them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from modelgen.codegen.real import Graph

if TYPE_CHECKING:
    from modelgen.codegen.kernels import Region

_TEST = "({}) ? 1.0 : 0.0"
OPERATIONS: tuple[tuple[str, str, str], ...] = (
    *((f"{name}_{kinds}", kinds, f"a {sign} b")
      for name, sign in (("add", "+"), ("sub", "-"), ("mul", "*"), ("div", "/"))
      for kinds in ("vv", "vs", "sv")),
    *((f"{name}_{kinds}", kinds, text)
      for name, text in (("muladd", "a * b + c"), ("mulsub", "a * b - c"), ("submul", "c - a * b"))
      for kinds in ("vvv", "svv")),
    ("dot", "vvvv", "a * b + c * d"), ("cross", "vvvv", "a * b - c * d"),
    ("copy", "v", "a"), ("fill", "s", "a"), ("neg", "v", "-a"), ("sign", "v", "mg_sign(a)"),
    ("not", "v", _TEST.format("a == 0.0")), ("fmin", "vv", "mg_min(a, b)"), ("fmax", "vv", "mg_max(a, b)"),
    *((f, "v", f"mg_{f}(a)") for f in ("exp", "log", "sin", "cos")), ("atan2", "vv", "mg_atan2(a, b)"),
    *((f, "v", f"{f}(a)") for f in (
        "sqrt", "fabs", "floor", "ceil", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh",
        "acosh", "atanh", "log1p", "expm1", "erf")),
    *((f, "vv", f"{f}(a, b)") for f in ("pow", "hypot", "fmod")),
    *((op, "vv", _TEST.format(f"a {sign} b"))
      for op, sign in (("lt", "<"), ("le", "<="), ("eq", "=="), ("ne", "!="))),
    ("and", "vv", _TEST.format("a != 0.0 && b != 0.0")), ("or", "vv", _TEST.format("a != 0.0 || b != 0.0")),
    ("ifz", "vv", "(a != 0.0) ? b : 0.0"), ("sel", "vvv", "(a != 0.0) ? b : c"),
)  # fmt: skip
"""Operations: name, what each operand is (v: a vector, s: one number), C of a sample."""
CALLS: tuple[tuple[str, int], ...] = (
    ("mg_gamma", 1), ("mg_digamma", 1), ("mg_sinhc", 1), ("mg_sinhc_slope", 1), ("mg_wrap", 1),
    ("mg_dahl_step", 3), ("mg_dahl_step_u", 3), ("mg_dahl_step_x", 3), ("mg_dahl_step_b", 3),
    ("mg_bouc_wen_step", 4), ("mg_bouc_wen_step_q", 5), ("mg_bouc_wen_step_x", 3),
    ("mg_bouc_wen_step_n", 4), ("mg_bouc_wen_step_sigma", 4), ("mg_eddy_factor", 1), ("mg_eddy_deficit", 1),
)  # fmt: skip
"""Functions of the language (templates/functions.h.j2), and how many arguments they take."""
PAIRS = ("mg_eddy_factor", "mg_eddy_deficit")
"""Those that give a complex number."""
CODES = {name: k for k, name in enumerate([*(n for n, _, _ in OPERATIONS), *(f for f, _ in CALLS)])}
_ARITHMETIC = ("add", "sub", "mul", "div")

Operand = tuple[str, int]
"""A vector by its place ("v"), or one number by its index ("s")."""


def can_record(graph: Graph) -> bool:
    """Whether the machine has all operations of a graph."""
    known = {*_ARITHMETIC, *CODES, "const", "in", "re", "im"}
    return all((n.data if n.op == "call" else n.op) in known for n in graph.nodes)


TAPE = "static const unsigned short"


def is_tape(line: str) -> bool:
    """Whether a line of C is a table of numbers for the machine."""
    return line.lstrip().startswith(TAPE)


def record(region: Region, stored: Sequence[tuple[str, int | None]]) -> list[str]:
    """C that has the machine compute what is `stored` for `count` samples from `base` on."""
    tape = _Tape(region, stored)
    words, places = ", ".join(map(str, tape.finished())), ", ".join(f"(double *){p}" for p in tape.places)
    sizes = (len(tape.words), len(tape.places), tape.registers)
    return [
        "{",
        f"    {TAPE} mg_words[] = {{ {words} }};",
        f"    const double mg_numbers[] = {{ {', '.join(tape.numbers) or '0.0'} }};",
        f"    double *const mg_at[] = {{ {places} }};",
        "    mg_tape({}, mg_words, {}, mg_at, {}, mg_numbers, count);".format(*sizes),
        "}",
    ]


class _Tape:
    """A tape as it is recorded. Vectors are places in arrays, from 0 on, and registers, below 0 until all
    places are known. A register is free after its last use, even for the result of that very operation."""

    def __init__(self, region: Region, stored: Sequence[tuple[str, int | None]]) -> None:
        self.region, self.graph = region, region.printer.graph
        self.words: list[int] = []
        self.places: dict[str, int] = {}
        self.numbers: dict[str, int] = {}
        self.registers = 0
        self._free: list[int] = []
        self._at: dict[int, int] = {}  # vectors by node
        self._filled: dict[int, int] = {}  # registers that hold one number
        self._inside = set(region.inside)
        self._goal: dict[int, str] = {}  # where a node is computed to right away
        for place, at in stored:
            if at in self._inside:
                self._goal.setdefault(at, place)
        self._uses = Counter(a for at in region.inside for a in self.graph.nodes[at].args)
        self._uses.update(at for _, at in stored if at is not None)
        self._taken = {a for at in region.inside for a in self._products_in(at)}
        for at in region.inside:
            if at not in self._taken:
                self._compute(at)
        for place, at in stored:
            if at is None or self._goal.get(at) != place:
                self._copy(place, at)

    def finished(self) -> list[int]:
        """The words, with registers numbered after the places."""
        return [w if w >= 0 else len(self.places) - 1 - w for w in self.words]

    # -- which operations --

    def _is_vector(self, at: int) -> bool:
        return at in self._inside or at in self.region.given

    def _products_in(self, at: int) -> list[int]:
        """Products that a sum takes in, as it alone needs them: both, if all of their factors are vectors, or
        one."""
        nodes, node = self.graph.nodes, self.graph.nodes[at]
        if node.op not in ("add", "sub") or not all(map(self._is_vector, node.args)):
            return []
        sole = [
            a
            for a in node.args
            if a in self._inside and nodes[a].op == "mul" and self._uses[a] == 1 and a not in self._goal
        ]
        plain = [a for a in sole if all(map(self._is_vector, nodes[a].args))]
        return plain if len(plain) == 2 else sole[:1]

    def _operation(self, at: int) -> tuple[str, tuple[int, ...]]:
        """Name and sources of what computes a node, with the products that it takes in."""
        nodes, node = self.graph.nodes, self.graph.nodes[at]
        if node.op == "call":
            return str(node.data), node.args
        taken = [a in self._taken for a in node.args]
        if node.op not in ("add", "sub") or not any(taken):
            return node.op, node.args
        a, b = node.args
        if all(taken):
            return ("dot" if node.op == "add" else "cross"), (*nodes[a].args, *nodes[b].args)
        if taken[0]:
            return ("muladd" if node.op == "add" else "mulsub"), (*nodes[a].args, b)
        return ("muladd" if node.op == "add" else "submul"), (*nodes[b].args, a)

    def _formed(self, op: str, operands: list[Operand]) -> tuple[str, list[Operand]]:
        """The form of an operation for its operands."""
        kinds = "".join(kind for kind, _ in operands)
        if op in ("muladd", "mulsub", "submul"):
            if kinds[:2] == "vs":
                operands = [operands[1], operands[0], operands[2]]
            return f"{op}_{'svv' if 's' in kinds[:2] else 'vvv'}", operands
        if op in _ARITHMETIC:
            return f"{op}_{kinds}", operands
        return op, [self._vector(x) for x in operands]

    # -- where things are --

    def _place(self, text: str) -> int:
        pointer = "&" + re.sub(r"\bi\b", "base", re.sub(r"\bl\b", "0", text))
        return self.places.setdefault(pointer, len(self.places))

    def _register(self) -> int:
        if self._free:
            return self._free.pop()
        self.registers += 1
        return -self.registers

    def _number(self, text: str) -> Operand:
        return "s", self.numbers.setdefault(text, len(self.numbers))

    def _operand(self, at: int) -> Operand:
        place = self.region.given.get(at)
        if at not in self._at and place is None:
            return self._number(self.region.text(at))
        if at not in self._at and place is not None:
            if place.startswith("-"):
                register = self._register()
                self._write("neg", [register], [("v", self._place(place[1:]))])
                self._at[at] = register
            else:
                self._at[at] = self._place(place)
        return "v", self._at[at]

    def _vector(self, operand: Operand) -> Operand:
        """One number as a vector, where an operation wants that."""
        kind, index = operand
        if kind == "v":
            return operand
        if index not in self._filled:
            self._filled[index] = self._register()
            self._write("fill", [self._filled[index]], [operand])
        return "v", self._filled[index]

    # -- what is written --

    def _write(self, op: str, to: Sequence[int], operands: Sequence[Operand]) -> None:
        self.words += [CODES[op], *to, *(index for _, index in operands)]

    def _compute(self, at: int) -> None:
        node = self.graph.nodes[at]
        if node.op in ("re", "im"):  # what the call has given
            return
        op, sources = self._operation(at)
        op, operands = self._formed(op, [self._operand(a) for a in sources])
        results: list[int | None] = [at]
        if op in PAIRS:
            parts = {self.graph.nodes[u].op: u for u in self._inside if self.graph.nodes[u].args == (at,)}
            results = [parts.get("re"), parts.get("im")]
        else:
            self._release(sources)
        to = [self._target(x) for x in results]
        self._write(op, to, operands)
        for x, vector in zip(results, to, strict=True):
            if x is None:
                self._free.append(vector)
            else:
                self._at[x] = vector
        if op in PAIRS:
            self._release(sources)

    def _target(self, at: int | None) -> int:
        goal = None if at is None else self._goal.get(at)
        return self._register() if goal is None else self._place(goal)

    def _release(self, sources: Sequence[int]) -> None:
        for a in sources:
            self._uses[a] -= 1
            if self._uses[a] == 0 and self._at.get(a, 0) < 0:
                self._free.append(self._at[a])

    def _copy(self, place: str, at: int | None) -> None:
        operand = self._number("0.0") if at is None else self._operand(at)
        self._write("copy" if operand[0] == "v" else "fill", [self._place(place)], [operand])
