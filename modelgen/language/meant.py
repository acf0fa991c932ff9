"""Which quantities symbols mean that are written by hand: `sympy.Symbol("x")` knows nothing of being real."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import sympy as sp

from modelgen.language.quantities import Condition, Equation, Implicit, Statement

if TYPE_CHECKING:
    from modelgen.language.model import Model, Port

Table = dict[str, sp.Symbol]


def meant(model: Model) -> dict[str, Any]:
    """Statements, ports and conditions of `model`, each symbol of a real quantity's name being that quantity.

    An equation is complex if what it holds is, so they are gone through in order.
    """
    from modelgen.language.model import substituted

    known: Table = {q.name: q.symbol for q in (*model.inputs, *model.parameters, *model.scalar_parameters)}
    known |= {s.name: s.symbol for s in model.statements if not isinstance(s, Equation)}
    statements: list[Statement] = []
    for s in model.statements:
        swaps = {old: new for e in expressions(s) for old, new in _swaps(e, known).items()}
        statements.append(substituted(s, swaps) if swaps else s)
        known[s.name] = statements[-1].symbol
    ports = tuple(_port(p, known) for p in model.ports)
    conditions = tuple(_condition(c, known) for c in model.conditions)
    return {"statements": tuple(statements), "ports": ports, "conditions": conditions}


def _port(port: Port, known: Table) -> Port:
    swaps = {old: new for _, x in port.variables for old, new in _swaps(x, known).items()}
    if not swaps:
        return port
    return replace(port, variables=tuple((n, x.xreplace(swaps)) for n, x in port.variables))


def _condition(condition: Condition, known: Table) -> Condition:
    swaps = _swaps(condition.expr, known)
    return replace(condition, expr=condition.expr.xreplace(swaps)) if swaps else condition


def expressions(s: Statement) -> list[Any]:
    """What stands in a statement."""
    if isinstance(s, Equation):
        return [s.expr]
    if isinstance(s, Implicit):
        return [s.residual, *map(sp.sympify, s.bracket)]
    return [sp.sympify(e) for e in (s.initial, s.update, s.rate) if e is not None]


def _swaps(expr: Any, known: Table) -> Table:
    """Symbols of an expression that have a real quantity's name without being its symbol."""
    return {s: new for s in symbols(expr) if (new := known.get(s.name, s)) != s and new.is_real}


@lru_cache(maxsize=4096)
def symbols(expr: Any) -> frozenset[sp.Symbol]:
    """What an expression uses; models that share equations ask for it again and again."""
    return frozenset(part for part in _parts(expr) if isinstance(part, sp.Symbol))


@lru_cache(maxsize=4096)
def undefined(expr: Any) -> bool:
    """Whether an expression holds a quotient by zero, which is no number."""
    return any(part is sp.zoo for part in _parts(expr))


def _parts(expr: Any) -> Collection[Any]:
    """All that an expression is made of. A part that stands in many places is looked at once: written out,
    the start of a state may be vast."""
    seen: dict[int, Any] = {}
    ahead = [expr]
    while ahead:
        part = ahead.pop()
        if id(part) not in seen:
            seen[id(part)] = part
            ahead.extend(part.args)
    return seen.values()
