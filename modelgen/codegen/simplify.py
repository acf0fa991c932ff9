"""Algebra that moves work out of the loop over samples: a model's output as a short sum of products

    Σ (what depends on parameters alone) · (on the sample alone) · Π (factors that depend on both)^±n

with equal factors cancelled. The paper's form stays what is shown; this one is what runs.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial, reduce
from operator import or_
from typing import Any

import casadi as ca

from modelgen.codegen.algebra import (
    FIELD,
    FREE,
    MINUS,
    ONE,
    ROOT,
    SAMPLE,
    Atom,
    Form,
    Powers,
    Term,
    number_mark,
    random_mark,
)  # fmt: skip

LONGEST = 6  # a sum with more terms is not multiplied out


@dataclass(frozen=True)
class Factor:
    """Something in the loop that is not a product: `sx` as it was first written, of a sum its `form`."""

    sx: Any
    mark: int
    form: Form = ()


@dataclass
class Staged:
    """Expressions with a symbol for each coefficient, through which derivatives by parameters go."""

    exprs: list[Any]
    symbols: list[Any]
    coefficients: list[Any]

    def whole(self, sx: Any) -> Any:
        """`sx` with the coefficients in the place of their symbols."""
        if not self.symbols:
            return sx
        return ca.substitute([sx], self.symbols, self.coefficients)[0]


def staged(exprs: Sequence[Any], masks: Mapping[str, int], j: Any, never_zero: Container[str]) -> Staged:
    """Rewrite SX scalars; `masks` says of each symbol's name what it depends on (no entry: on both).

    never_zero: names of what no value can be 0, so that the new form may divide by it.
    """
    algebra = _Algebra(masks, j, never_zero)
    forms = [algebra.form(e) for e in algebra.run(list(exprs))]
    found = [algebra.write(f) for f in forms]
    return Staged(found, algebra.symbols, [a.sx for a in algebra.coefficients])


@dataclass
class _Algebra:
    masks: Mapping[str, int]
    j: Any
    never_zero: Container[str]
    factors: list[Factor] = field(default_factory=list)
    symbols: list[Any] = field(default_factory=list)
    coefficients: list[Atom] = field(default_factory=list)
    _known: dict[int, int] = field(default_factory=dict)
    _symbol: dict[int, Any] = field(default_factory=dict)
    _inverse: dict[int, Any] = field(default_factory=dict)

    def run(self, exprs: list[Any]) -> list[Atom | Form]:
        """The forms of `exprs`, by CasADi's instruction list."""
        symbols = ca.symvar(ca.vertcat(*exprs))
        leaves = [self._leaf(s) for s in symbols]
        f = ca.Function("f", symbols, [ca.densify(ca.vertcat(*exprs))], {"live_variables": False})
        work: dict[int, Atom | Form] = {}
        written = _Written({}, {})
        result: list[Atom | Form] = [Atom(ca.SX(0), 0)] * len(exprs)
        for k in range(f.n_instructions()):
            op, o, i = f.instruction_id(k), f.instruction_output(k), f.instruction_input(k)
            if op == ca.OP_CONST:
                value = f.instruction_constant(k)
                written.known[o[0]] = ca.SX(value)
                work[o[0]] = Atom(written.known[o[0]], number_mark(value), 0, value != 0)
            elif op == ca.OP_INPUT:
                written.known[o[0]], work[o[0]] = symbols[i[0]], leaves[i[0]]
            elif op == ca.OP_OUTPUT:
                result[o[1]] = work[i[0]]
            else:
                written.made[o[0]] = op, tuple(i)
                work[o[0]] = self._apply(op, [work[a] for a in i], partial(written.of, o[0]))
        return result

    def _leaf(self, symbol: Any) -> Atom | Form:
        if symbol.element_hash() == self.j.element_hash():
            return Atom(symbol, ROOT, 0, True)
        name = symbol.name()
        mark, mask = random_mark(name), self.masks.get(name, FREE | SAMPLE)
        if mask == FREE | SAMPLE:
            return self._opaque(symbol, mark)
        return Atom(symbol, mark, mask, name in self.never_zero)

    def _opaque(self, sx: Any, mark: int) -> Form:
        at = self._known.setdefault(mark, len(self.factors))
        if at == len(self.factors):
            self.factors.append(Factor(sx, mark))
        return (Term(ONE, ONE, ((at, 1),)),)

    def _apply(self, op: int, args: list[Atom | Form], written: Callable[[], Any]) -> Atom | Form:
        if op in (ca.OP_SUB, ca.OP_NEG):
            args = [*args[:-1], self.product(MINUS, args[-1])]
            op = ca.OP_ADD if len(args) == 2 else ca.OP_ASSIGN
        if op == ca.OP_ASSIGN:
            return args[0]
        if op == ca.OP_ADD:
            return self.sum(*args)
        if op == ca.OP_MUL:
            return self.product(*args)
        if op == ca.OP_SQ:
            return self.product(args[0], args[0])
        if op == ca.OP_TWICE:
            return self.product(Atom(ca.SX(2), 2, 0, True), args[0])
        if op in (ca.OP_DIV, ca.OP_INV) and self._mark(args[-1]):
            return self.product(args[0] if len(args) == 2 else ONE, self.inverse(args[-1]))
        return self._other(op, args, written)

    def _other(self, op: int, args: list[Atom | Form], written: Callable[[], Any]) -> Atom | Form:
        """An operation that is no algebra: an atom, or a factor, with its argument as the paper has it.

        exp(a (1 - x)) multiplied out would lose digits where x is near 1.
        """
        mask = reduce(or_, (a.mask if isinstance(a, Atom) else FREE | SAMPLE for a in args))
        mark = random_mark(repr((op, [self._mark(a) for a in args])))
        return Atom(written(), mark, mask) if mask != FREE | SAMPLE else self._opaque(written(), mark)

    # -- sums and products ---------------------------------------------------------------------------------

    def form(self, x: Atom | Form) -> Form:
        if not isinstance(x, Atom):
            return x
        return () if x.mark == 0 else (Term(ONE, x) if x.mask == SAMPLE else Term(x),)

    def sum(self, a: Atom | Form, b: Atom | Form) -> Atom | Form:
        if isinstance(a, Atom) and isinstance(b, Atom) and a.mask | b.mask != FREE | SAMPLE:
            return b if a.mark == 0 else a if b.mark == 0 else a + b
        terms = {t.key: t for t in self.form(a)}
        for t in self.form(b):
            if t.key in terms:
                t = Term(terms[t.key].coefficient + t.coefficient, t.sample, t.powers)
            terms[t.key] = t
        return tuple(t for t in terms.values() if t.coefficient.mark)

    def product(self, a: Atom | Form, b: Atom | Form) -> Atom | Form:
        if isinstance(a, Atom) and isinstance(b, Atom) and a.mask | b.mask != FREE | SAMPLE:
            return a * b
        f, g = self.form(a), self.form(b)
        if not f or not g:
            return ()
        if len(f) > 1 and len(g) > 1:
            return self._expanded(f, g) or self._expanded(g, f) or (self.monomial(f) * self.monomial(g),)
        one, many = (f[0], g) if len(f) == 1 else (g[0], f)
        if len(many) > 1 and one.powers:  # a factor stays one, unless it cancels
            return (one * self.monomial(many),)
        return tuple(one * t for t in many)

    def _expanded(self, f: Form, g: Form) -> Form:
        """f·g multiplied out, if f stands in a denominator of g; else nothing."""
        whole = self.monomial(f)
        divides = {at for t in g for at, n in t.powers if n < 0}
        if not divides & {at for at, _ in whole.powers} or len(f) > LONGEST or any(t.powers for t in f):
            return ()
        total: Atom | Form = ()
        for t in g:
            cancels = divides & dict(t.powers).keys() & dict(whole.powers).keys()
            total = self.sum(total, (whole * t,) if cancels else tuple(t * s for s in f))
        return self.form(total)

    def inverse(self, a: Atom | Form) -> Atom | Form:
        if isinstance(a, Atom):
            return a.inverse()
        clear = Term(ONE)
        for at in sorted({at for t in a for at, n in t.powers if n < 0} if len(a) > 1 else ()):
            clear = clear * Term(ONE, ONE, ((at, -min(dict(t.powers).get(at, 0) for t in a)),))
        cleared = tuple(clear * t for t in a)
        return (clear * self.monomial(cleared).inverse(),)

    def monomial(self, f: Form) -> Term:
        """A form as one term: a sum becomes a factor, the same one as any sum proportional to it."""
        if len(f) == 1:
            return f[0]
        mark = self._mark(f)
        scale = mark * pow(min(f, key=lambda t: t.key).coefficient.mark, -1, FIELD) % FIELD
        at = self._known.setdefault(scale, len(self.factors))
        if at == len(self.factors):
            self.factors.append(Factor(None, mark, f))
        same = self.factors[at]
        if same.mark == mark:
            return Term(ONE, ONE, ((at, 1),))
        others = {t.key: t.coefficient for t in same.form}
        for t in f if others.keys() == {t.key for t in f} else ():  # as sums of the same terms they are alike
            if others[t.key].never_zero:
                return Term(t.coefficient * others[t.key].inverse(), ONE, ((at, 1),))
        self.factors.append(Factor(None, mark, f))
        return Term(ONE, ONE, ((len(self.factors) - 1, 1),))

    def _mark(self, a: Atom | Form) -> int:
        if isinstance(a, Atom):
            return a.mark
        total = 0
        for t in a:
            product = t.coefficient.mark * t.sample.mark
            for f, n in t.powers:
                product = product * pow(self.factors[f].mark, n, FIELD) % FIELD
            total += product
        return total % FIELD

    # -- back to SX ----------------------------------------------------------------------------------------

    def write(self, f: Form) -> Any:
        """SX of a form: terms with the same factors are summed first; a symbol for each coefficient."""
        groups: dict[Powers, Any] = {}
        for t in f:
            product = self._coefficient(t.coefficient) * t.sample.sx
            groups[t.powers] = groups[t.powers] + product if t.powers in groups else product
        total: Any = None
        for powers, inner in groups.items():
            for at, n in powers:
                for _ in range(abs(n)):
                    inner = inner * (self._factor(at) if n > 0 else self._reciprocal(at))
            total = inner if total is None else total + inner
        return ca.SX(0) if total is None else total

    def _coefficient(self, a: Atom) -> Any:
        if not a.mask & FREE:
            return a.sx
        if a.mark not in self._symbol:
            self._symbol[a.mark] = ca.SX.sym(f"C{len(self.symbols)}")
            self.symbols.append(self._symbol[a.mark])
            self.coefficients.append(a)
        return self._symbol[a.mark]

    def _factor(self, at: int) -> Any:
        f = self.factors[at]
        if f.sx is None:
            f = self.factors[at] = Factor(self.write(f.form), f.mark, f.form)
        return f.sx

    def _reciprocal(self, at: int) -> Any:
        if at not in self._inverse:
            self._inverse[at] = 1 / self._factor(at)
        return self._inverse[at]


@dataclass
class _Written:
    """Expressions as they were first written, by place in CasADi's instruction list: few are asked for."""

    known: dict[int, Any]
    made: dict[int, tuple[int, tuple[int, ...]]]

    def of(self, place: int) -> Any:
        waiting = [place]
        while waiting:
            op, args = self.made[waiting[-1]]
            missing = [a for a in args if a not in self.known]
            if missing:
                waiting += missing
            else:
                at = waiting.pop()
                self.known[at] = _operation(op, [self.known[a] for a in args])
        return self.known[place]


def _operation(op: int, args: list[Any]) -> Any:
    """The SX of one CasADi operation."""
    return ca.SX.unary(op, *args) if len(args) == 1 else ca.SX.binary(op, *args)
