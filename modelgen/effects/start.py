"""What a model is at the first sample: where the memories of effects begin."""

from collections.abc import Callable, Mapping
from typing import Any

import sympy
from sympy import sympify

from modelgen.effects.motion import moved_inputs
from modelgen.errors import InputError
from modelgen.language import Abs, Equation, Implicit, Model, Port, State
from modelgen.language.quantities import BACKWARD


def at_start(model: Model, expr: Any, known: Mapping[Any, Any] | None = None) -> Any:
    """An expression as it is at the first sample, in inputs and parameters alone: what `State.initial` may
    hold. There what an input was before is what it is. known: symbols that have other values there than the
    model's statements give them."""
    statements = {s.name: s for s in model.statements}
    inputs = {i.name: i.symbol for i in model.inputs}
    now = {i.name: inputs[i.derived[1]] for i in model.inputs if i.derived and i.derived[0] in BACKWARD}

    def first(symbol: Any) -> Any:
        if symbol.name in now:
            return now[symbol.name]
        s = statements.get(symbol.name)
        if isinstance(s, Implicit):
            raise InputError(f"model '{model.id}': no state can start from '{s.name}', it is implicit")
        return sympify(s.expr if isinstance(s, Equation) else s.initial) if s else symbol

    return put(expr, known or {}, first)


def put(expr: Any, known: Mapping[Any, Any], of: Callable[[Any], Any] = lambda symbol: symbol) -> Any:
    """An expression with what is `known` in the place of its parts, and `of` its other symbols in theirs.

    Each part is made once, though it may stand in many places: what composed effects begin with is large.
    """
    made = {sympify(a): sympify(b) for a, b in known.items()}

    def rebuilt(x: Any) -> Any:
        args = [start(a) for a in x.args]
        if all(new is a for new, a in zip(args, x.args, strict=True)):
            return x
        return Abs(*args) if x.func is sympy.Abs else x.func(*args)

    def start(x: Any) -> Any:
        if x not in made:
            whole = of(x) if x.is_Symbol else x
            made[x] = rebuilt(x) if whole is x else start(whole)
        return made[x]

    return start(sympify(expr))


def undeflected(model: Model, port: Port) -> Any:
    """The force where nothing moves, is deflected or remembered, in parameters alone."""
    motion = {i.symbol for i in (*moved_inputs(model), *(i for i in model.inputs if i.derived))}
    states = {s.symbol for s in model.statements if isinstance(s, State)}
    return at_start(model, model[port.equation], dict.fromkeys(motion | states, 0))
