"""The quantities that a model is written in. Each is frozen data, and can stand in an expression as its
symbol."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf
from typing import TYPE_CHECKING, Any

import sympy as sp

from modelgen.errors import InputError
from modelgen.units import PURE


class Symbolic:
    """Lets a declared quantity stand in sympy expressions as its symbol."""

    name: str
    unit: str

    def __post_init__(self) -> None:
        if self.unit in PURE:  # one spelling, which results show
            object.__setattr__(self, "unit", "1")

    if TYPE_CHECKING:  # the operators are set below, all in the same way

        def _unary(self) -> Any: ...
        def _binary(self, other: Any) -> Any: ...

        __neg__ = __abs__ = _unary
        __add__ = __sub__ = __mul__ = __truediv__ = __pow__ = _binary
        __radd__ = __rsub__ = __rmul__ = __rtruediv__ = __rpow__ = _binary
        __lt__ = __le__ = __gt__ = __ge__ = _binary

    @property
    def symbol(self) -> sp.Symbol:
        """The sympy symbol; complex quantities have a symbol without the assumption `real`."""
        return sp.Symbol(self.name, real=None if getattr(self, "complex", False) else True)

    def _sympy_(self) -> sp.Symbol:
        return self.symbol


def _operator(name: str) -> Callable[..., Any]:
    def method(self: Symbolic, *others: Any) -> Any:
        return getattr(self.symbol, name)(*(sp.sympify(o) for o in others))

    return method


for _name in ("add", "sub", "mul", "truediv", "pow"):
    setattr(Symbolic, f"__{_name}__", _operator(f"__{_name}__"))
    setattr(Symbolic, f"__r{_name}__", _operator(f"__r{_name}__"))
for _name in ("__neg__", "__abs__", "__lt__", "__le__", "__gt__", "__ge__"):
    setattr(Symbolic, _name, _operator(_name))


@dataclass(frozen=True)
class Parameter(Symbolic):
    """A number that a fit may change.

    `default` and `bounds` are in `unit`; `known` parameters are held at their default unless a case frees
    them by giving bounds. `source` is where default and bounds come from. `part` is ("re" or "im", name of
    the complex one).
    """

    name: str
    unit: str = "1"
    default: float | None = None
    bounds: tuple[float, float] = (-inf, inf)
    text: str = ""
    source: str = ""
    known: bool = False
    part: tuple[str, str] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.default is not None:
            _number(self, "default", self.default, "a number or None")
        pair = self.bounds
        if not isinstance(pair, tuple | list) or len(pair) != 2:
            raise InputError(f"parameter '{self.name}': bounds are {pair!r}, wanted (low, high)")
        for end in pair:
            _number(self, "bounds", end, "two numbers, (low, high)")
        if not pair[0] < pair[1]:
            what = "are reversed" if pair[0] > pair[1] else "hold no range"
            raise InputError(f"bounds of parameter '{self.name}' {what}: [{pair[0]:g}, {pair[1]:g}]")
        _yes_or_no(f"parameter '{self.name}': known", self.known)


def _number(p: Parameter, what: str, value: object, wanted: str) -> None:
    if isinstance(value, str | bytes | bool | complex | list | tuple) or not hasattr(value, "__float__"):
        raise InputError(f"parameter '{p.name}': {what}: found {value!r}, wanted {wanted}")


def _yes_or_no(what: str, value: object) -> None:
    if not isinstance(value, bool):  # any text is true, "no" as well
        raise InputError(f"{what}: found {value!r}, wanted True or False")


@dataclass(frozen=True)
class ComplexParameter(Symbolic):
    """A complex constant; its real and imaginary part are parameters `name_re`, `name_im`."""

    name: str
    unit: str
    re: Parameter
    im: Parameter
    complex: bool = field(default=True, init=False)


def complex_parameter(
    name: str,
    unit: str,
    default: complex | None = None,
    re: tuple[float, float] = (-inf, inf),
    im: tuple[float, float] = (-inf, inf),
    text: str = "",
    source: str = "",
) -> ComplexParameter:
    """Declare a complex constant with search ranges for both its parts."""
    parts = [
        Parameter(
            f"{name}_{p}",
            unit,
            None if default is None else (default.real if p == "re" else default.imag),
            bounds,
            text=f"{'real' if p == 're' else 'imaginary'} part of {text or name}",
            source=source,
            part=(p, name),
        )
        for p, bounds in (("re", re), ("im", im))
    ]
    return ComplexParameter(name, unit, parts[0], parts[1])


@dataclass(frozen=True)
class Input(Symbolic):
    """A quantity recorded or given at each sample.

    `derived` = (kind, input) marks one that is computed from another recorded input when it is not given:
    "previous" (value at the sample before), "turning" (extreme value inside the step), "rate",
    "acceleration", "amplitude", "quadrature" (a quarter of a cycle ahead). `range` is where its source used
    it: what an exported model is tested over.
    """

    name: str
    unit: str = "1"
    text: str = ""
    derived: tuple[str, str] | None = None
    range: tuple[float, float] | None = None


def previous(x: Input) -> Input:
    """The value of `x` at the sample before (its own value at the first sample)."""
    return Input(f"{x.name}_prev", x.unit, f"{x.name} at the sample before", ("previous", x.name))


def rate_of(x: Input, name: str, unit: str) -> Input:
    """dx/dt in `unit`, estimated from the record in a way that survives its noise (recordings.kinematics)."""
    return Input(name, unit, f"rate of {x.name}", ("rate", x.name))


def acceleration_of(x: Input, name: str, unit: str) -> Input:
    """d²x/dt² in `unit`, estimated from the record (recordings.kinematics)."""
    return Input(name, unit, f"acceleration of {x.name}", ("acceleration", x.name))


def amplitude_of(x: Input) -> Input:
    """Half the swing between turning points that `x` is in (recordings.envelope)."""
    return Input(f"{x.name}_amplitude", x.unit, f"running amplitude of {x.name}", ("amplitude", x.name))


def quadrature_of(x: Input) -> Input:
    """`x` a quarter of a cycle ahead, at every frequency: its Hilbert transform (recordings.envelope)."""
    return Input(f"{x.name}_ahead", x.unit, f"{x.name} a quarter of a cycle ahead", ("quadrature", x.name))


BACKWARD = ("previous", "turning")
"""Kinds of derived input that look back along the path: what was before tells them, not how it moves."""


def turning_point_of(x: Input) -> Input:
    """Where `x` turns inside the step, or its value before the step when it does not turn."""
    return Input(f"{x.name}_turn", x.unit, f"turning point of {x.name} inside the step", ("turning", x.name))


@dataclass(frozen=True)
class Equation(Symbolic):
    """`name` = `expr`, with the equation's number in its source. `complex` says that the value is complex."""

    name: str
    expr: Any
    unit: str = "1"
    ref: str = ""
    text: str = ""

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "expr", expression(self.expr))

    @property
    def complex(self) -> bool:
        return is_complex(self.expr)


@dataclass(frozen=True)
class Condition:
    """What parameters of a real device satisfy, such as passivity: `expr` ≥ 0, an expression in parameters.

    `says` states it in words, without a full stop.
    """

    says: str
    expr: Any
    ref: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "expr", expression(self.expr))


@dataclass(frozen=True)
class Implicit(Symbolic):
    """`name` is the root of `residual` = 0 (an expression in its own symbol) between `bracket`'s two
    expressions.

    Solved in the generated C by a safeguarded Newton iteration with a bound on its steps; derivatives follow
    from the implicit function theorem. The residual must change sign between the brackets.
    """

    name: str
    residual: Any
    bracket: tuple[Any, Any]
    unit: str = "1"
    ref: str = ""
    text: str = ""

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "residual", expression(self.residual))
        object.__setattr__(self, "bracket", tuple(expression(b) for b in self.bracket))


@dataclass(frozen=True)
class State(Symbolic):
    """A memory of a time model.

    At the first sample it has the value `initial`. At each later sample it is either replaced by `update`, in
    which its own symbol means the value before (statements run in the order in which they are written), or
    integrated from `rate` = dx/dt over the step in `substeps` steps, inputs and their rates running linearly
    between samples (the model gets their previous values as inputs, too): by the classical Runge–Kutta scheme
    of order 4, or, all of a model's together where one is `stiff`, by RODAS3, L-stable and of order 3.
    """

    name: str
    initial: Any = 0
    update: Any = None
    rate: Any = None
    unit: str = "1"
    ref: str = ""
    text: str = ""
    substeps: int = 1
    stiff: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        for key in ("initial", "update", "rate"):
            value = getattr(self, key)
            object.__setattr__(self, key, None if value is None else expression(value))
        if (self.update is None) == (self.rate is None):
            found = "neither update nor rate" if self.rate is None else "both update and rate"
            raise InputError(f"state '{self.name}' has {found}, wanted one of them")
        _yes_or_no(f"state '{self.name}': stiff", self.stiff)


Statement = Equation | Implicit | State


def expression(value: Any) -> Any:
    """A number or an expression as sympy's. Raises InputError for anything else, such as text."""
    try:
        return sp.sympify(value, strict=True)
    except sp.SympifyError:
        found = f"{value!r} of type {type(value).__name__}"
        raise InputError(f"{found} is no expression, wanted numbers and symbols of quantities") from None


def is_complex(expr: Any) -> bool:
    """Whether an expression's value is complex: it holds j, a complex symbol or a complex-valued function."""
    from modelgen.language.functions import COMPLEX_VALUED

    if isinstance(expr, sp.Abs | sp.arg | sp.re | sp.im):
        return False
    if expr is sp.I or isinstance(expr, COMPLEX_VALUED):
        return True
    if isinstance(expr, sp.Symbol):
        return expr.is_real is not True
    return any(is_complex(a) for a in expr.args)
