"""Exact derivatives of SX that holds opaque calls: CasADi's own, with the calls' derivatives chained in by
hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import sympy as sp

from modelgen.codegen.tosx import NONHOLOMORPHIC, SAME, Call, Translator
from modelgen.language import Implicit


@dataclass
class Chain:
    """Derivatives along some directions: `leaves` are symbols whose derivatives are the rows of `rows`."""

    translator: Translator
    leaves: Sequence[Any]
    rows: Any
    _tangents: list[Any] | None = None

    @property
    def directions(self) -> int:
        return int(self.rows.shape[1])

    def tangent(self, exprs: Sequence[Any], upto: int | None = None) -> Any:
        """d(exprs)/d(directions), SX of shape (len(exprs), directions)."""
        if upto is None:
            if self._tangents is None:
                self._walk()
            upto = len(self._tangents or ())
        e = ca.vertcat(*exprs)
        total = ca.SX(len(exprs), self.directions)
        if self.leaves:
            total += ca.mtimes(ca.jacobian(e, ca.vertcat(*self.leaves)), self.rows)
        if upto:
            symbols = ca.vertcat(*(c.symbol for c in self.translator.calls[:upto]))
            total += ca.mtimes(ca.jacobian(e, symbols), ca.vertcat(*(self._tangents or ())[:upto]))
        return ca.sparsify(total)

    def _walk(self) -> None:
        """Tangents of all calls that stand now, in order (those that derivatives bring need none)."""
        self._tangents = []
        for k in range(len(self.translator.calls)):
            call = self.translator.calls[k]
            da = self.tangent(call.args, k)
            row = ca.SX(1, self.directions)
            if call.function == SAME:
                row = da
            elif da.nnz() and call.residual is not None:
                row = self._implicit(call, call.residual, da)
            elif da.nnz() and call.sympy in NONHOLOMORPHIC:
                row = self._nonholomorphic(call, da)
            elif da.nnz():
                for i in range(len(call.args)):
                    if da[i, :].nnz():
                        row += self.translator.derivative(call, i) * da[i, :]
            self._tangents.append(row)

    def _implicit(self, call: Call, residual: Residual, da: Any) -> Any:
        """Implicit function theorem: ds = −(Σ ∂g/∂a da)/(∂g/∂s)."""
        n = len(residual.arguments)
        gradient = residual.inlined(self.translator, (*call.args[:n], call.symbol))
        return -ca.mtimes(gradient[:, :n], da[:n, :]) / gradient[0, n]

    def _nonholomorphic(self, call: Call, da: Any) -> Any:
        """d|a| = Re(ā da)/|a|, d arg a = Im(ā da)/|a|², d Re a = Re da: by real directions only."""
        t = self.translator

        def part(kind: Any, x: Any) -> Any:
            return t.call(kind, (ca.SX(x),), ("complex",)).symbol

        a, row = call.args[0], ca.SX(1, self.directions)
        for d in range(self.directions):
            if not da[0, d].nnz():
                continue
            x = da[0, d]
            if call.sympy in (sp.re, sp.im):
                row[0, d] = part(call.sympy, x)
                continue
            re, im, dre, dim = part(sp.re, a), part(sp.im, a), part(sp.re, x), part(sp.im, x)
            if call.sympy is sp.Abs:
                row[0, d] = (re * dre + im * dim) / call.symbol
            else:
                row[0, d] = (re * dim - im * dre) / (re * re + im * im)
        return row


@dataclass(frozen=True)
class Residual:
    """The residual of an implicit equation, in symbols of its own: `symbols` of the arguments, then of the
    unknown."""

    statement: Implicit
    arguments: tuple[str, ...]
    symbols: tuple[Any, ...]
    translator: Translator
    value: Any
    gradient: Any

    @staticmethod
    def of(s: Implicit, arguments: Sequence[str], outer: Translator) -> Residual:
        """Translate the residual of `s`."""
        symbols = tuple(ca.SX.sym(n) for n in (*arguments, s.name))
        inner = Translator(dict(zip((*arguments, s.name), symbols, strict=True)), set(), outer.j)
        value = inner.sx(s.residual)
        gradient = Chain(inner, symbols, ca.SX.eye(len(symbols))).tangent([value])
        return Residual(s, tuple(arguments), symbols, inner, value, gradient)

    def inlined(self, outer: Translator, at: Sequence[Any]) -> Any:
        """The gradient with `at` in the place of the symbols, its calls made calls of `outer`."""
        old, new = list(self.symbols), list(at)
        for c in self.translator.calls:
            args = tuple(ca.substitute([a], old, new)[0] for a in c.args)
            old.append(c.symbol)
            new.append(outer.call(c.sympy, args, c.takes).symbol)
        return ca.substitute([self.gradient], old, new)[0]
