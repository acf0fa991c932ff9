"""sympy → CasADi SX. Complex quantities are plain symbols (`j` too); what SX does not know becomes an opaque
symbol."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import casadi as ca
import sympy as sp
from sympy.codegen.cfunctions import expm1
from sympy.core.relational import Relational
from sympy.logic.boolalg import BooleanFunction

from modelgen.errors import InputError
from modelgen.language import functions as fn

if TYPE_CHECKING:
    from modelgen.codegen.derive import Residual

PLAIN: dict[Any, Any] = {
    sp.exp: ca.exp, sp.sin: ca.sin, sp.cos: ca.cos, sp.tan: ca.tan, sp.sinh: ca.sinh, sp.cosh: ca.cosh,
    sp.tanh: ca.tanh, sp.log: ca.log, sp.Abs: ca.fabs, sp.sign: ca.sign, sp.atan2: ca.atan2, sp.asin: ca.asin,
    sp.acos: ca.acos, sp.atan: ca.atan, sp.asinh: ca.asinh, sp.acosh: ca.acosh, sp.atanh: ca.atanh,
    sp.floor: ca.floor, sp.ceiling: ca.ceil, sp.erf: ca.erf, expm1: ca.expm1,
}  # fmt: skip
NEEDS_REAL = (
    sp.Abs, sp.log, sp.sign, sp.atan2, sp.floor, sp.ceiling, sp.asin, sp.acos, sp.atan, sp.asinh,
    sp.acosh, sp.atanh, sp.erf, expm1,
)  # fmt: skip
NONHOLOMORPHIC = (sp.Abs, sp.arg, sp.re, sp.im)
RELATION = {
    sp.StrictLessThan: ca.lt, sp.LessThan: ca.le, sp.StrictGreaterThan: ca.gt, sp.GreaterThan: ca.ge,
    sp.Equality: ca.eq, sp.Unequality: ca.ne,
}  # fmt: skip
WIDE = (sp.Abs, fn.cpow, fn.clog)
"""Functions that take complex numbers, too, of those that SX does not or that are the language's own."""
SAME = "same"


@dataclass(frozen=True)
class Call:
    """A function or root that SX does not see into: `symbol` stands for its value (SAME: of its argument)."""

    function: str
    symbol: Any
    args: tuple[Any, ...]
    complex: bool
    takes: tuple[str, ...]
    sympy: Any = None
    residual: Residual | None = None


@dataclass
class Translator:
    """Translates expressions under an environment: name → SX, and which names are complex."""

    env: dict[str, Any]
    complex_names: set[str]
    j: Any = field(default_factory=lambda: ca.SX.sym("j"))
    calls: list[Call] = field(default_factory=list)
    _known: dict[tuple[Any, ...], Call] = field(default_factory=dict)

    def copy(self) -> Translator:
        """The same; calls that one makes are not the other's."""
        return replace(self, calls=list(self.calls), _known=dict(self._known))

    def same(self, name: str, value: Any) -> Any:
        """A symbol for a real value, so that derivatives of what uses it hold its derivative as a whole."""
        call = Call(SAME, ca.SX.sym(name), (value,), False, ("real",))
        self.calls.append(call)
        return call.symbol

    def is_complex(self, e: Any) -> bool:
        if isinstance(e, (sp.Symbol, sp.Dummy)):
            return _key(e) in self.complex_names
        if isinstance(e, NONHOLOMORPHIC):
            return False
        if e is sp.I or isinstance(e, fn.COMPLEX_VALUED):
            return True
        return any(self.is_complex(a) for a in e.args)

    def sx(self, e: Any, memo: dict[Any, Any] | None = None) -> Any:
        """The SX of a sympy expression."""
        memo = {} if memo is None else memo
        if e not in memo:
            x = self._sx(e, memo)
            memo[e] = x if isinstance(x, ca.SX) else ca.SX(x)
        return memo[e]

    def _sx(self, e: Any, memo: dict[Any, Any]) -> Any:
        if isinstance(e, (sp.Symbol, sp.Dummy)):
            return self.env[_key(e)]
        if e is sp.I:
            return self.j
        if e.is_Rational:
            return int(e.p) / int(e.q)
        if e.is_Number or e.is_NumberSymbol:
            return float(e)
        if isinstance(e, sp.Add):
            return self._sum(e, memo)
        if isinstance(e, sp.Mul):
            return self._product(e, memo)
        if isinstance(e, sp.Pow):
            return self._power(e, memo)
        if isinstance(e, sp.Piecewise):
            return self._piecewise(e, memo)
        if isinstance(e, (sp.Max, sp.Min)):
            if any(self.is_complex(a) for a in e.args):
                raise InputError(f"complex numbers have no order, in {e}; compare re(…) or Abs(…)")
            pick = ca.fmax if isinstance(e, sp.Max) else ca.fmin
            total = self.sx(e.args[0], memo)
            for a in e.args[1:]:
                total = pick(total, self.sx(a, memo))
            return total
        return self._function(e, memo)

    def _sum(self, e: Any, memo: dict[Any, Any]) -> Any:
        total: Any = 0
        for negative, a in _terms(e):
            total = total - self.sx(a, memo) if negative else total + self.sx(a, memo)
        return total

    def _product(self, e: Any, memo: dict[Any, Any]) -> Any:
        top: Any = None
        bottom: Any = None
        for below, a in _factors(e):
            x = self.sx(a, memo)
            if below:
                bottom = x if bottom is None else bottom * x
            else:
                top = x if top is None else top * x
        top = 1 if top is None else top
        return top if bottom is None else top / bottom

    def _power(self, e: Any, memo: dict[Any, Any]) -> Any:
        base, n = e.args
        if base == sp.E:
            return ca.exp(self.sx(n, memo))
        if n.is_Integer and abs(int(n)) <= 12:
            x = self.sx(base, memo)
            product = x
            for _ in range(abs(int(n)) - 1):
                product = product * x
            return product if n > 0 else 1 / product
        if self.is_complex(base) or self.is_complex(n):
            return self._function(fn.cpow(base, n), memo)
        if n == sp.Rational(1, 2):
            return ca.sqrt(self.sx(base, memo))
        if n == -sp.Rational(1, 2):
            return 1 / ca.sqrt(self.sx(base, memo))
        return self.sx(base, memo) ** self.sx(n, memo)

    def _piecewise(self, e: Any, memo: dict[Any, Any]) -> Any:
        total: Any = ca.SX.nan() if e.args[-1][1] is not sp.true else None
        for value, condition in reversed(e.args):
            x = self.sx(value, memo)
            total = x if total is None else ca.if_else(self._condition(condition, memo), x, total)
        return total

    def _condition(self, c: Any, memo: dict[Any, Any]) -> Any:
        if isinstance(c, Relational):
            if self.is_complex(c.lhs) or self.is_complex(c.rhs):
                raise InputError(f"complex numbers have no order, in {c}; compare re(…) or Abs(…)")
            return RELATION[type(c)](self.sx(c.lhs, memo), self.sx(c.rhs, memo))
        if isinstance(c, sp.Not):
            return ca.logic_not(self._condition(c.args[0], memo))
        if isinstance(c, (sp.And, sp.Or)):
            join = ca.logic_and if isinstance(c, sp.And) else ca.logic_or
            total = self._condition(c.args[0], memo)
            for a in c.args[1:]:
                total = join(total, self._condition(a, memo))
            return total
        if isinstance(c, BooleanFunction):  # ITE, of a Piecewise within a condition; Xor
            return self._condition(c.to_nnf(), memo)
        if c not in (sp.true, sp.false):
            raise InputError(f"'{c}' in a Piecewise is no condition: wanted comparisons, joined by & | ~")
        return ca.SX(1.0 if c == sp.true else 0.0)

    def _function(self, e: Any, memo: dict[Any, Any]) -> Any:
        kind = type(e)
        arguments_complex = any(self.is_complex(a) for a in e.args)
        if kind is sp.log and arguments_complex:
            return self._function(fn.clog(e.args[0]), memo)
        if arguments_complex and (kind in NEEDS_REAL or kind.__module__ == fn.__name__) and kind not in WIDE:
            raise InputError(f"{kind.__name__} takes real numbers, found a complex one, in {e}")
        if kind in (sp.re, sp.im) and not arguments_complex:
            return self.sx(e.args[0], memo) if kind is sp.re else 0.0
        if kind in PLAIN and not (arguments_complex and kind in NEEDS_REAL):
            return PLAIN[kind](*(self.sx(a, memo) for a in e.args))
        default = ("complex" if kind in NONHOLOMORPHIC else "any",) * len(e.args)
        takes = getattr(kind, "takes", None) or default
        if not (kind in NONHOLOMORPHIC or (issubclass(kind, sp.Function) and kind.__module__ == fn.__name__)):
            raise InputError(f"function '{kind.__name__}' is not part of the language")
        return self.call(kind, tuple(self.sx(a, memo) for a in e.args), takes).symbol

    def call(self, kind: Any, args: tuple[Any, ...], takes: tuple[str, ...]) -> Call:
        """The opaque call of a function of the language; the same arguments give the same call."""
        key = (kind, *(a.element_hash() if a.numel() else 0 for a in args))
        if key not in self._known:
            symbol = ca.SX.sym(f"{kind.__name__}_{len(self.calls)}")
            new = Call(kind.__name__, symbol, args, issubclass(kind, fn.COMPLEX_VALUED), takes, kind)
            self._known[key] = new
            self.calls.append(new)
        return self._known[key]

    def derivative(self, call: Call, index: int) -> Any:
        """∂f/∂(argument `index`) of an opaque function, as SX."""
        dummies, slope = _slope(call.sympy, len(call.args), index)
        inner = Translator({}, set(self.complex_names), self.j, self.calls, self._known)
        for d, a, t in zip(dummies, call.args, call.takes, strict=True):
            inner.env[_key(d)] = a
            if t == "complex" or (t == "any" and call.function in ("cpow", "clog") and d is dummies[0]):
                inner.complex_names.add(_key(d))
        return inner.sx(slope)


# what sympy takes long to find out, of expressions that models have in common


@lru_cache(maxsize=16384)
def _terms(e: Any) -> tuple[tuple[bool, Any], ...]:
    """Terms of a sum in order, as (whether it is taken off, term)."""
    terms = e.as_ordered_terms() if len(e.args) < 12 else e.args
    return tuple((True, -a) if a.could_extract_minus_sign() else (False, a) for a in terms)


@lru_cache(maxsize=16384)
def _factors(e: Any) -> tuple[tuple[bool, Any], ...]:
    """Factors of a product in order, as (whether it divides, factor)."""
    found = []
    for a in e.args:
        if isinstance(a, sp.Pow) and a.exp.is_Integer and a.exp < 0:
            found.append((True, a.base ** (-a.exp)))
        elif a.is_Rational and a.q != 1 and a.p == 1:
            found.append((True, sp.Integer(a.q)))
        else:
            found.append((False, a))
    return tuple(found)


@lru_cache(maxsize=1024)
def _slope(function: Any, count: int, index: int) -> tuple[tuple[sp.Dummy, ...], Any]:
    """Arguments, and ∂f/∂(argument `index`)."""
    dummies = tuple(sp.Dummy(f"x{i}", real=True) for i in range(count))
    return dummies, function(*dummies).fdiff(index + 1)


def _key(symbol: Any) -> str:
    return f"{symbol.name}#{symbol.dummy_index}" if isinstance(symbol, sp.Dummy) else str(symbol.name)
