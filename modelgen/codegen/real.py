"""The real program: a graph of real operations, each made once. Complex numbers are pairs of its nodes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

UNARY: dict[str, Callable[[float], float]] = {
    "neg": lambda a: -a, "sqrt": math.sqrt, "exp": math.exp, "log": math.log, "sin": math.sin,
    "cos": math.cos, "tan": math.tan, "asin": math.asin, "acos": math.acos, "atan": math.atan,
    "sinh": math.sinh, "cosh": math.cosh, "tanh": math.tanh, "fabs": abs, "floor": math.floor,
    "ceil": math.ceil, "asinh": math.asinh, "acosh": math.acosh, "atanh": math.atanh, "log1p": math.log1p,
    "expm1": math.expm1, "erf": math.erf, "sign": lambda a: (a > 0) - (a < 0), "not": lambda a: float(a == 0),
}  # fmt: skip
BINARY: dict[str, Callable[[float, float], float]] = {
    "add": lambda a, b: a + b, "sub": lambda a, b: a - b, "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b, "pow": math.pow, "fmin": min, "fmax": max, "atan2": math.atan2,
    "hypot": math.hypot, "fmod": math.fmod, "lt": lambda a, b: float(a < b), "le": lambda a, b: float(a <= b),
    "eq": lambda a, b: float(a == b), "ne": lambda a, b: float(a != b),
    "and": lambda a, b: float(a != 0 and b != 0), "or": lambda a, b: float(a != 0 or b != 0),
    "ifz": lambda a, b: b if a != 0 else 0.0,
}  # fmt: skip
COMMUTATIVE = {"add", "mul", "fmin", "fmax", "eq", "ne", "and", "or"}


class Node(NamedTuple):
    """One operation. `op` is "const" (value in `data`), "in" (name in `data`), "call" (function in `data`),
    or a name above."""

    op: str
    args: tuple[int, ...] = ()
    data: str | float = ""


@dataclass
class Graph:
    """Nodes in an order in which they can be computed; making the same operation twice gives the same
    node."""

    nodes: list[Node] = field(default_factory=list)
    labels: dict[int, tuple[str, str]] = field(default_factory=dict)  # node → (name, comment)
    _index: dict[Node, int] = field(default_factory=dict)

    def copy(self) -> Graph:
        """The same nodes; what is added to one is not added to the other."""
        return Graph(list(self.nodes), dict(self.labels), dict(self._index))

    def _put(self, node: Node) -> int:
        at = self._index.get(node)
        if at is None:
            at = self._index[node] = len(self.nodes)
            self.nodes.append(node)
        return at

    def const(self, value: float) -> int:
        return self._put(Node("const", (), float(value) + 0.0))  # −0 and 0 are one

    def input(self, name: str) -> int:
        return self._put(Node("in", (), name))

    def call(self, function: str, *args: int) -> int:
        return self._put(Node("call", args, function))

    def value(self, at: int) -> float | None:
        """The number that a node holds, or None."""
        node = self.nodes[at]
        return float(node.data) if node.op == "const" else None

    def label(self, at: int, name: str, comment: str = "") -> None:
        """Give a node its name in the C; the first name stays. Numbers and inputs have none."""
        if self.nodes[at].op not in ("const", "in"):
            self.labels.setdefault(at, (name, comment))

    def unary(self, op: str, a: int) -> int:
        value = self.value(a)
        if value is not None:
            try:
                return self.const(UNARY[op](value))
            except (ValueError, OverflowError):
                pass
        if op == "neg" and self.nodes[a].op == "neg":
            return self.nodes[a].args[0]
        if op == "neg" and self.nodes[a].op == "sub":
            return self.binary("sub", *reversed(self.nodes[a].args))
        if op == "fabs" and self.nodes[a].op in ("fabs", "sqrt", "exp"):
            return a
        return self._put(Node(op, (a,)))

    def binary(self, op: str, a: int, b: int) -> int:
        va, vb = self.value(a), self.value(b)
        if va is not None and vb is not None:
            try:
                return self.const(BINARY[op](va, vb))
            except (ValueError, OverflowError, ZeroDivisionError):
                pass
        simpler = getattr(self, f"_{op}", lambda *_: None)(a, b, va, vb)
        if simpler is not None:
            return int(simpler)
        if op in COMMUTATIVE and a > b:
            a, b = b, a
        return self._put(Node(op, (a, b)))

    def _add(self, a: int, b: int, va: float | None, vb: float | None) -> int | None:
        if va == 0:
            return b
        if vb == 0:
            return a
        if self.nodes[b].op == "neg":
            return self.binary("sub", a, self.nodes[b].args[0])
        if self.nodes[a].op == "neg":
            return self.binary("sub", b, self.nodes[a].args[0])
        return None

    def _sub(self, a: int, b: int, va: float | None, vb: float | None) -> int | None:
        if vb == 0:
            return a
        if va == 0:
            return self.unary("neg", b)
        if a == b:
            return self.const(0.0)
        if self.nodes[b].op == "neg":
            return self.binary("add", a, self.nodes[b].args[0])
        return None

    def _mul(self, a: int, b: int, va: float | None, vb: float | None) -> int | None:
        if va == 0 or vb == 0:
            return self.const(0.0)
        if va == 1:
            return b
        if vb == 1:
            return a
        if va == -1:
            return self.unary("neg", b)
        if vb == -1:
            return self.unary("neg", a)
        na, nb = self.nodes[a], self.nodes[b]
        if na.op == "neg" and nb.op == "neg":
            return self.binary("mul", na.args[0], nb.args[0])
        if na.op == "neg":
            return self.unary("neg", self.binary("mul", na.args[0], b))
        if nb.op == "neg":
            return self.unary("neg", self.binary("mul", a, nb.args[0]))
        return None

    def _div(self, a: int, b: int, va: float | None, vb: float | None) -> int | None:
        if va == 0:
            return self.const(0.0)
        if vb == 1:
            return a
        if a == b:
            return self.const(1.0)
        if vb is not None and vb != 0 and math.frexp(vb)[0] in (0.5, -0.5):
            return self.binary("mul", a, self.const(1.0 / vb))
        return None

    def _ifz(self, a: int, b: int, va: float | None, vb: float | None) -> int | None:
        if vb == 0:
            return self.const(0.0)
        return None if va is None else (b if va != 0 else self.const(0.0))

    def _pow(self, a: int, b: int, va: float | None, vb: float | None) -> int | None:
        if vb == 0:
            return self.const(1.0)
        if vb == 1:
            return a
        if vb == 2:
            return self.binary("mul", a, a)
        if vb == 0.5:
            return self.unary("sqrt", a)
        return None

    def needed(self, roots: Iterable[int]) -> list[int]:
        """All nodes that `roots` depend on, in order."""
        seen: set[int] = set()
        stack = list(roots)
        while stack:
            at = stack.pop()
            if at not in seen:
                seen.add(at)
                stack.extend(self.nodes[at].args)
        return sorted(seen)

    def inputs(self, roots: Iterable[int]) -> set[str]:
        """Names of what `roots` depend on."""
        return {str(self.nodes[at].data) for at in self.needed(roots) if self.nodes[at].op == "in"}

    def needed_until(self, roots: Iterable[int], given: set[int]) -> list[int]:
        """As `needed`, but not what the nodes `given` depend on (they are included)."""
        seen: set[int] = set()
        stack = list(roots)
        while stack:
            at = stack.pop()
            if at not in seen:
                seen.add(at)
                if at not in given:
                    stack.extend(self.nodes[at].args)
        return sorted(seen)


class Work(NamedTuple):
    """What one sample costs: operations in all; of them divisions and roots, and functions such as exp."""

    operations: int
    divisions: int = 0
    functions: int = 0

    def with_loop(self, other: Work, count: int) -> Work:
        """With `count` times the other's."""
        return Work(*(a + count * b for a, b in zip(self, other, strict=True)))

    def plus(self, more: int) -> Work:
        """With additions and multiplications added."""
        return self._replace(operations=self.operations + more)


CHEAP = {
    "add", "sub", "mul", "neg", "fabs", "fmin", "fmax", "sign", "floor", "ceil", "ifz", "re", "im",
    "lt", "le", "eq", "ne", "and", "or", "not",
}  # fmt: skip


def work(graph: Graph, ids: Iterable[int]) -> Work:
    """Of these nodes; numbers and inputs cost nothing."""
    ops = [op for op in (graph.nodes[at].op for at in ids) if op not in ("const", "in")]
    divisions = sum(op in ("div", "sqrt") for op in ops)
    return Work(len(ops), divisions, sum(op not in CHEAP for op in ops) - divisions)
