"""A model is a value: inputs, parameters, statements in the paper's order, outputs, and ports where physics
can be added."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any

import sympy as sp

from modelgen.errors import InputError, did_you_mean, one_of
from modelgen.language.quantities import (
    ComplexParameter,
    Condition,
    Equation,
    Implicit,
    Input,
    Parameter,
    State,
    Statement,
    Symbolic,
    expression,
    previous,
)

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def check_name(name: str, what: str) -> str:
    """Return `name` if it can be an identifier in C and Python; else raise InputError."""
    if not isinstance(name, str) or not _NAME.fullmatch(name) or len(name) > 63:
        raise InputError(
            f"{what} {name!r} is not a name: letters, digits and _ only, a letter first, at most 63"
        )
    return name


def check_option(name: str, value: str, known: Iterable[str]) -> str:
    """Return `value` if it is one of the `known` values of a model's option; else raise InputError."""
    known = tuple(known)
    if value not in known:
        raise InputError(f"option {name}: unknown value {value!r}{one_of(str(value), known)}")
    return value


@dataclass(frozen=True)
class Output:
    """An equation that is measured; `measured_as` lists other names of its column in a recording."""

    name: str
    measured_as: tuple[str, ...] = ()


@dataclass(frozen=True)
class Port:
    """A place where physics can be added: the equation of `name`'s quantity, and what an effect may use
    there.

    `name` is what a verdict calls it ("electrical", "mechanical", "force", …); `kind` is what effects ask
    for.
    """

    name: str
    kind: str
    equation: str
    variables: tuple[tuple[str, Any], ...] = ()

    def __post_init__(self) -> None:  # an input or a state stands for its symbol
        if not all(isinstance(pair, tuple | list) and len(pair) == 2 for pair in self.variables):
            wanted = 'wanted (("z", z),) for one'
            raise InputError(f"port '{self.name}': variables are no pairs of name and quantity, {wanted}")
        object.__setattr__(self, "variables", tuple((n, expression(x)) for n, x in self.variables))

    def __getitem__(self, key: str) -> Any:
        return dict(self.variables)[key]


@lru_cache(maxsize=4096)
def _text(expr: sp.Basic) -> str:
    """The whole expression; models that share equations ask for it again and again."""
    return str(sp.srepr(expr, order="none"))  # as its parts lie, always alike


@dataclass(frozen=True)
class Model:
    """Physics written once. Immutable; every method that changes something returns a new model.

    drops: quantities of the same physics that drop out here, each with the one value with which it does, or
    None: a case may state them.

    Raises InputError when a name is used twice or not declared, or when units of an equation do not agree.
    """

    id: str
    inputs: tuple[Input, ...] = ()
    parameters: tuple[Parameter | ComplexParameter, ...] = ()
    statements: tuple[Statement, ...] = ()
    outputs: tuple[Output, ...] = ()
    ports: tuple[Port, ...] = ()
    source: str = ""
    text: str = ""
    options: tuple[tuple[str, str], ...] = ()
    conditions: tuple[Condition, ...] = ()
    drops: tuple[tuple[str, float | None], ...] = ()
    builder: Callable[..., Model] | None = field(default=None, compare=False, repr=False)
    checked: bool = field(default=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        from modelgen.language.check import check_model
        from modelgen.language.meant import meant

        for key in ("inputs", "parameters", "statements", "outputs", "ports", "conditions"):
            given = getattr(self, key)
            if isinstance(given, str) or not isinstance(given, Iterable) or isinstance(given, Symbolic):
                raise InputError(
                    f"model '{self.id}': {key} is of type {type(given).__name__}, wanted a tuple of them, "
                    f"({key[:-1]},) for one"
                )
            object.__setattr__(self, key, tuple(given))
        outputs = tuple(Output(o) if isinstance(o, str) else o for o in self.outputs)
        object.__setattr__(self, "outputs", outputs)
        for key, found in meant(self).items() if not self.checked else ():
            object.__setattr__(self, key, found)
        if any(s.rate is not None for s in self.states):
            have = {i.name for i in self.inputs}
            more = (i for i in map(previous, self._integrated_along()) if i.name not in have)
            object.__setattr__(self, "inputs", (*self.inputs, *more))
        check_model(self)

    def _integrated_along(self) -> list[Input]:
        """Inputs that a state's rate depends on, recorded ones and their rates, and time: over a step they
        run linearly from their previous values, which the model therefore needs, to the present ones."""
        from modelgen.language.meant import symbols

        rates = [s.rate for s in self.states if s.rate is not None]
        wanted = {self.axis} | {x.name for rate in rates for x in symbols(rate)}
        for s in reversed(self.statements):
            if isinstance(s, Equation) and s.name in wanted:
                wanted |= {x.name for x in symbols(s.expr)}
        have = {i.derived[1] for i in self.inputs if i.derived and i.derived[0] == "previous"}
        run = (None, "rate", "acceleration")
        return [i for i in self.inputs if i.name in wanted - have and (i.derived and i.derived[0]) in run]

    @cached_property
    def scalar_parameters(self) -> tuple[Parameter, ...]:
        """All parameters as real numbers, complex ones as their two parts, in order."""
        flat: list[Parameter] = []
        for p in self.parameters:
            flat += [p] if isinstance(p, Parameter) else [p.re, p.im]
        return tuple(flat)

    def parameter(self, name: str) -> Parameter:
        """The scalar parameter called `name`; InputError with the nearest name otherwise."""
        for p in self.scalar_parameters:
            if p.name == name:
                return p
        names = [p.name for p in self.scalar_parameters]
        raise InputError(f"model '{self.id}' has no parameter '{name}'{did_you_mean(name, names)}")

    def __getitem__(self, name: str) -> Statement:
        """The statement called `name`."""
        for s in self.statements:
            if s.name == name:
                return s
        raise InputError(
            f"model '{self.id}' has no equation '{name}'"
            f"{did_you_mean(name, [s.name for s in self.statements])}"
        )

    @cached_property
    def states(self) -> tuple[State, ...]:
        return tuple(s for s in self.statements if isinstance(s, State))

    def derived_from(self, name: str) -> dict[str, str]:
        """How inputs follow from the input `name` ("rate", "previous", "turning", …) -> their names."""
        return {i.derived[0]: i.name for i in self.inputs if i.derived and i.derived[1] == name}

    @property
    def moved(self) -> str:
        """The input whose rate the model knows, which is the motion; "" where none is."""
        return next((i.derived[1] for i in self.inputs if i.derived and i.derived[0] == "rate"), "")

    @property
    def is_time_model(self) -> bool:
        """True when samples must be taken in order: the model has states, or an input that looks back."""
        return bool(self.states) or any(i.derived for i in self.inputs)

    @property
    def axis(self) -> str:
        """The input along which samples are ordered ("f", "t", …), or "" for a model without inputs."""
        return self.inputs[0].name if self.inputs else ""

    @cached_property
    def hash(self) -> str:
        """Content hash: the same physics has the same hash, whatever file it stands in."""
        parts: list[str] = [self.id]
        for q in (*self.inputs, *self.scalar_parameters):
            parts.append(
                f"{type(q).__name__}:{q.name}:{q.unit}:"
                f"{getattr(q, 'part', None)}:{getattr(q, 'derived', None)}"
            )
        for s in self.statements:
            keys = {
                Equation: ("expr",),
                Implicit: ("residual", "bracket"),
                State: ("initial", "update", "rate", "substeps", "stiff"),
            }
            parts.append(
                f"{s.name}:{s.unit}:{s.ref}:"
                + ";".join(
                    _text(sp.sympify(getattr(s, k))) if getattr(s, k) is not None else "-"
                    for k in keys[type(s)]
                )
            )
        parts += [o.name for o in self.outputs]
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]

    def variant(self, **options: str) -> Model:
        """The same model with other options, e.g. `eddy_sign="printed"`."""
        if self.builder is None:
            raise InputError(f"model '{self.id}' has no options, but {', '.join(options)} was given")
        known = dict(self.options)
        for key in options:
            if key not in known:
                raise InputError(f"model '{self.id}' has no option '{key}'{one_of(key, known)}")
        return self.builder(**{**known, **options})

    # -- adding physics
    # ------------------------------------------------------------------------------------------

    def with_parameters(self, *new: Parameter | ComplexParameter) -> Model:
        """A model with more parameters; one of the same name is replaced."""
        names = {p.name for p in new}
        return replace(self, parameters=(*(p for p in self.parameters if p.name not in names), *new))

    def with_inputs(self, *new: Input) -> Model:
        """A model with more inputs; those it has already are not added again."""
        have = {i.name for i in self.inputs}
        return replace(self, inputs=(*self.inputs, *(i for i in new if i.name not in have)))

    def before(self, name: str, *new: Statement) -> Model:
        """A model with statements put before the statement called `name`."""
        at = [s.name for s in self.statements].index(self[name].name)
        return replace(self, statements=(*self.statements[:at], *new, *self.statements[at:]))

    def after(self, name: str, *new: Statement) -> Model:
        """A model with statements put after the statement called `name`."""
        at = [s.name for s in self.statements].index(self[name].name) + 1
        return replace(self, statements=(*self.statements[:at], *new, *self.statements[at:]))

    def extend(
        self,
        equation: str,
        change: Callable[[Any], Any],
        *,
        parameters: tuple[Parameter, ...] = (),
        inputs: tuple[Input, ...] = (),
        statements: tuple[Statement, ...] | Callable[[Any], tuple[Statement, ...]] = (),
        ref: str = "",
        text: str = "",
    ) -> Model:
        """A model in which `equation` becomes `change(what it was)`.

        What it was keeps its expression under the name `equation_1` (`_2`, …), so the source's equation stays
        readable. `statements` (or a function of the old symbol that returns them) are put between the two.
        """
        old = self[equation]
        if not isinstance(old, Equation):
            raise InputError(
                f"'{equation}' of model '{self.id}' is not an equation that physics can be added to"
            )
        names = {s.name for s in self.statements}
        count = 1
        while f"{equation}_{count}" in names:
            count += 1
        inner = replace(old, name=f"{equation}_{count}")
        between = statements(inner.symbol) if callable(statements) else statements
        outer = Equation(equation, change(inner.symbol), old.unit, ref, text)
        at = [s.name for s in self.statements].index(equation)
        have = {i.name for i in self.inputs}
        return replace(
            self,
            inputs=(*self.inputs, *(i for i in inputs if i.name not in have)),
            parameters=(*self.parameters, *parameters),
            statements=(*self.statements[:at], inner, *between, outer, *self.statements[at + 1 :]),
        )

    def substitute(self, equation: str, mapping: Mapping[Any, Any]) -> Model:
        """A model in which symbols of one statement are replaced by expressions."""
        new = substituted(self[equation], mapping)
        return replace(self, statements=tuple(new if s.name == equation else s for s in self.statements))


def substituted(statement: Statement, mapping: Mapping[Any, Any]) -> Statement:
    """The statement with symbols replaced by expressions, wherever they stand in it."""
    table = {sp.sympify(a): sp.sympify(b) for a, b in mapping.items()}

    def sub(expr: Any) -> Any:
        return None if expr is None else expr.xreplace(table)

    if isinstance(statement, Equation):
        return replace(statement, expr=sub(statement.expr))
    if isinstance(statement, State):
        whole = {key: sub(getattr(statement, key)) for key in ("initial", "update", "rate")}
        return replace(statement, **whole)
    return replace(
        statement, residual=sub(statement.residual), bracket=tuple(sub(b) for b in statement.bracket)
    )
