"""Expressions as Python text."""

from __future__ import annotations

from typing import Any

import sympy as sp
from sympy.printing.str import StrPrinter


class Printer(StrPrinter):
    """Expressions that Python and sympy read back exactly as they were; notes which names they need."""

    def __init__(self, symbols: dict[sp.Symbol, str]) -> None:
        super().__init__()
        self.symbols = symbols
        self.used: set[str] = set()

    def _name(self, name: str) -> str:
        self.used.add(name)
        return name

    def _print_Symbol(self, x: Any) -> str:
        return self.symbols[x]

    def _print_ImaginaryUnit(self, x: Any) -> str:
        return self._name("j")

    def _print_Pi(self, x: Any) -> str:
        return self._name("pi")

    def _print_Exp1(self, x: Any) -> str:
        return f"{self._name('exp')}(1)"

    def _print_Infinity(self, x: Any) -> str:
        return self._name("inf")

    def _print_NegativeInfinity(self, x: Any) -> str:
        return f"-{self._name('inf')}"

    def _print_NaN(self, x: Any) -> str:
        return self._name("nan")

    def _print_Float(self, x: Any) -> str:
        return repr(float(x))

    def _print_Rational(self, x: Any) -> str:
        if x.q == 1:
            return str(x.p)
        return f"{'-' if x.p < 0 else ''}{self._name('Rational')}({abs(x.p)}, {x.q})"

    _print_Half = _print_Rational

    def _print_Pow(self, x: Any, rational: bool = False) -> str:
        if abs(x.exp) == sp.S.Half and x.exp.is_Rational:
            self.used.add("sqrt")
        return str(super()._print_Pow(x, rational=rational))

    def _print_Mul(self, x: Any) -> str:
        """Where a number would meet a sum first, sympy would multiply it in: the rest goes in brackets."""
        number, rest = x.as_coeff_Mul()
        if number is not sp.S.One and _starts_with_sum(rest):
            sign = "-" if number == -1 else f"{self._print(number)}*"
            return f"{sign}({self._print(rest)})"
        return str(super()._print_Mul(x))

    def _print_Relational(self, x: Any) -> str:
        if x.rel_op in ("==", "!="):
            return f"{self._name('Eq' if x.rel_op == '==' else 'Ne')}({self.stringify(x.args, ', ')})"
        # Python turns 0 < x round into x > 0, unless the number is sympy's
        left = f"{self._name('Rational')}({x.lhs.p}, {x.lhs.q})" if x.lhs.is_Rational else self._print(x.lhs)
        return f"{left} {x.rel_op} {self._print(x.rhs)}"

    def _print_ITE(self, x: Any) -> str:
        return str(self._print(x.to_nnf()))

    _print_Xor = _print_ITE

    def _print_Basic(self, x: Any) -> str:
        return f"{self._name(type(x).__name__)}({', '.join(self._print(a) for a in x.args)})"

    _print_Function = _print_Basic
    _print_LatticeOp = _print_Basic
    emptyPrinter = _print_Basic


def _starts_with_sum(product: Any) -> bool:
    """Whether the first factor above the line or below it, as they are printed, is a sum."""
    above: list[Any] = []
    below: list[Any] = []
    for f in product.as_ordered_factors():
        base, exponent = f.as_base_exp()
        under = exponent.is_Rational and exponent < 0
        (below if under else above).append(base if exponent in (1, -1) else f)
    return any(factors[0].is_Add for factors in (above, below) if factors)
