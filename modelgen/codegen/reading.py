"""Reads CasADi's SX into a graph of real numbers: its instruction list, run on pairs of real and imaginary
nodes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any

import casadi as ca

from modelgen.codegen.real import Graph
from modelgen.codegen.split import Complex, Pair
from modelgen.codegen.tosx import SAME, Call, Translator


class Reader:
    """Reads SX into a graph. Calls are made in order, as soon as their arguments are there: later expressions
    stand on them."""

    def __init__(
        self, graph: Graph, translator: Translator, named: Mapping[str, Any], plain: Mapping[str, Any]
    ) -> None:
        self.c = Complex(graph)
        self.translator = translator
        self.symbols: list[Any] = [translator.j]
        self.pairs: list[Pair] = [(None, graph.const(1.0))]
        for name, symbol in named.items():
            self._bind(symbol, (graph.input(name), None))
        for name, symbol in plain.items():
            self._bind(symbol, (graph.input(f"{name}_re"), graph.input(f"{name}_im")))

    def _bind(self, symbol: Any, pair: Pair) -> None:
        self.symbols.append(symbol)
        self.pairs.append(pair)

    def read(self, exprs: list[Any]) -> list[Pair]:
        """Pairs of nodes for SX scalars."""
        calls, found = self.translator.calls, list[Pair]()
        symbols = [*self.symbols, *(call.symbol for call in calls)]
        waiting = iter(calls)
        call = next(waiting, None)
        for pair in self._executed(symbols, [*(a for c in calls for a in c.args), *exprs]):
            found.append(pair)
            while call is not None and len(found) == len(call.args):
                self._bind(call.symbol, self._call(call, found))
                found, call = [], next(waiting, None)
        return found

    def _executed(self, symbols: Sequence[Any], exprs: list[Any]) -> Iterator[Pair]:
        """CasADi's instruction list, run on pairs of nodes: each of `exprs` before what only later ones
        need."""
        if not exprs:
            return
        options = {"live_variables": False, "allow_free": False}
        f = ca.Function("f", list(symbols), [ca.densify(ca.vertcat(*exprs))], options)
        table = _operations()
        work: dict[int, Pair] = {}
        for k in range(f.n_instructions()):
            op, o, i = f.instruction_id(k), f.instruction_output(k), f.instruction_input(k)
            if op == ca.OP_CONST:
                work[o[0]] = self.c.const(f.instruction_constant(k))
            elif op == ca.OP_INPUT:
                work[o[0]] = self.pairs[i[0]]
            elif op == ca.OP_OUTPUT:
                yield work[i[0]]
            else:
                work[o[0]] = table[op](self.c, *(work[a] for a in i))

    def _call(self, call: Call, args: list[Pair]) -> Pair:
        c, g, name = self.c, self.c.g, call.function
        if name == SAME:
            return args[0]
        if name in ("cpow", "powj"):
            return (c.power if name == "cpow" else c.jpow)(*args)
        simple = {"clog": c.log, "Abs": c.modulus, "arg": c.argument}
        if name in simple:
            return simple[name](*args)
        if name == "re":
            return (c.re(args[0]), None)
        if name == "im":
            return (c.im(args[0]), None)
        flat: list[int] = []
        for a, t in zip(args, call.takes, strict=True):
            flat += [c.re(a), c.im(a)] if t == "complex" else [c.re(a)]
        node = g.call(f"mg_{name}" if call.residual is None else name, *flat)
        return (g.unary("re", node), g.unary("im", node)) if call.complex else (node, None)


@cache
def _operations() -> dict[int, Any]:
    def real1(name: str) -> Any:
        return lambda c, a: (c.g.unary(name, c.re(a)), None)

    def real2(name: str) -> Any:
        return lambda c, a, b: (c.g.binary(name, c.re(a), c.re(b)), None)

    table: dict[int, Any] = {
        ca.OP_ASSIGN: lambda c, a: a, ca.OP_ADD: Complex.add, ca.OP_SUB: Complex.sub, ca.OP_MUL: Complex.mul,
        ca.OP_DIV: Complex.div, ca.OP_NEG: Complex.neg, ca.OP_EXP: Complex.exp, ca.OP_INV: Complex.inv,
        ca.OP_SQ: lambda c, a: c.mul(a, a), ca.OP_TWICE: lambda c, a: c.mul(c.const(2.0), a),
        ca.OP_SIN: lambda c, a: c.sin(a) if a[1] is not None else (c.g.unary("sin", c.re(a)), None),
        ca.OP_COS: lambda c, a: c.cos(a) if a[1] is not None else (c.g.unary("cos", c.re(a)), None),
        ca.OP_TAN: lambda c, a: c.tan(a) if a[1] is not None else (c.g.unary("tan", c.re(a)), None),
        ca.OP_SINH: lambda c, a: c.sinh_cosh(a)[0], ca.OP_COSH: lambda c, a: c.sinh_cosh(a)[1],
        ca.OP_TANH: Complex.tanh, ca.OP_IF_ELSE_ZERO: _if_else_zero,
    }  # fmt: skip
    for op, name in {
        "SQRT": "sqrt", "LOG": "log", "FABS": "fabs", "SIGN": "sign", "NOT": "not", "ASIN": "asin",
        "ACOS": "acos", "ATAN": "atan", "ASINH": "asinh", "ACOSH": "acosh", "ATANH": "atanh",
        "FLOOR": "floor", "CEIL": "ceil", "ERF": "erf", "LOG1P": "log1p", "EXPM1": "expm1",
    }.items():  # fmt: skip
        table[getattr(ca, f"OP_{op}")] = real1(name)
    for op, name in {
        "POW": "pow", "CONSTPOW": "pow", "FMIN": "fmin", "FMAX": "fmax", "ATAN2": "atan2", "LT": "lt",
        "LE": "le", "EQ": "eq", "NE": "ne", "AND": "and", "OR": "or", "FMOD": "fmod",
    }.items():  # fmt: skip
        table[getattr(ca, f"OP_{op}")] = real2(name)
    return table


def _if_else_zero(c: Complex, condition: Pair, a: Pair) -> Pair:
    re, im = (None if x is None else c.g.binary("ifz", c.re(condition), x) for x in a)
    return (re, im)
