"""What a model is checked for when it is made: names, order of use, and units of every equation."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import sympy as sp

from modelgen.errors import InputError, did_you_mean
from modelgen.language.derived import PER_TIME, check_derived
from modelgen.language.meant import expressions, symbols, undefined
from modelgen.language.quantities import Equation, Implicit, State
from modelgen.units import converts

if TYPE_CHECKING:
    from modelgen.language.model import Model


def check_model(model: Model) -> None:
    """Raise InputError that names the model and the equation when something is not as it should be."""
    _check_names(model)
    _check_use(model)
    if not model.checked:
        _check_steps(model)
        try:
            _check_units(model)
            check_derived(model)
        except InputError:
            _check_axis(model, fits=False)  # rates are by the first input: by another none has the right unit
            raise
        _check_axis(model, fits=True)


def _check_names(model: Model) -> None:
    from modelgen.language.model import check_name

    check_name(model.id, "model id")
    seen: set[str] = set()
    parts = (p for p in model.scalar_parameters if p not in model.parameters)
    for q in (*model.inputs, *model.parameters, *parts, *model.statements):
        check_name(q.name, f"model '{model.id}': name")
        if q.name in seen:
            raise InputError(f"model '{model.id}': name '{q.name}' is declared twice")
        seen.add(q.name)
    for p in model.scalar_parameters:
        low, high = p.bounds
        if p.default is not None and not low <= p.default <= high:
            raise InputError(
                f"model '{model.id}': default {p.default:g} of '{p.name}' is outside [{low:g}, {high:g}]"
            )
    names = [s.name for s in model.statements]
    for o in model.outputs:
        if o.name not in names:
            raise InputError(
                f"model '{model.id}': output '{o.name}' is no equation{did_you_mean(o.name, names)}"
            )
    if not model.outputs:
        raise InputError(f"model '{model.id}' has no output")
    for port in model.ports:
        if port.equation not in names:
            raise InputError(
                f"model '{model.id}', port '{port.name}' of kind '{port.kind}': '{port.equation}' is no "
                f"equation{did_you_mean(port.equation, names)}"
            )
        for key, x in port.variables:
            for name in sorted(_names(sp.sympify(x)) - seen):
                raise InputError(
                    f"model '{model.id}', port '{port.name}': variable '{key}' is '{name}', which the model "
                    f"does not have{did_you_mean(name, seen)}"
                )


def _check_use(model: Model) -> None:
    """Every symbol is declared, and an equation is used only after it stands."""
    scalars = [p.name for p in model.scalar_parameters]
    for condition in model.conditions:
        for name in sorted(_names(condition.expr)):
            if name not in scalars:
                raise InputError(
                    f"model '{model.id}', condition '{condition.says}': '{name}' is no parameter"
                    f"{did_you_mean(name, scalars)}"
                )
    states = {s.name for s in model.states}
    known = {i.name for i in model.inputs} | {p.name for p in model.parameters}
    known |= {p.name for p in model.scalar_parameters} | states
    at_first = known - states
    for s in model.statements:
        for name in sorted(_names(s.initial)) if isinstance(s, State) else ():
            if name not in at_first:
                raise InputError(
                    f"model '{model.id}', state '{s.name}': its initial value uses '{name}', "
                    "wanted inputs and parameters alone"
                )
        own = {s.name} if isinstance(s, Implicit) else set()
        for e in expressions(s):
            if undefined(e):
                raise InputError(f"model '{model.id}', equation '{s.name}': it divides by zero")
            for name in sorted(_names(e) - known - own):
                later = " (it stands further down)" if name in {x.name for x in model.statements} else ""
                raise InputError(
                    f"model '{model.id}', equation '{s.name}': '{name}' is not declared{later}"
                    f"{_hint(model, name, known) if not later else ''}"
                )
        known.add(s.name)


MOST_STEPS = 10_000
"""Steps between two samples: what needs more is stiff, and would run for hours."""


def _check_steps(model: Model) -> None:
    for s in model.states:
        count = s.substeps
        if isinstance(count, bool) or not hasattr(count, "__index__") or not 1 <= count <= MOST_STEPS:
            raise InputError(
                f"model '{model.id}', state '{s.name}': substeps is {count!r}, wanted a whole number from 1 "
                f"to {MOST_STEPS}"
            )


def _check_axis(model: Model, fits: bool) -> None:
    """Time stands first among the inputs, if it is one of them: where rates by another are not in
    their units; and without rates where it is called t, but in sweeps over frequency."""
    rates = [s.name for s in model.states if s.rate is not None]
    rates += [i.name for i in model.inputs if i.derived and i.derived[0] in PER_TIME]
    times = [i.name for i in model.inputs if i.derived is None and converts(i.unit, "s")]
    if not times or model.axis in times:
        return
    says = f"model '{model.id}': its first input is '{model.axis}', wanted"
    if rates and not fits:
        raise InputError(f"{says} '{times[0]}', along which '{rates[0]}' is formed")
    if not rates and "t" in times and not converts(model.inputs[0].unit, "Hz"):
        raise InputError(f"{says} 't', which orders samples")


def _hint(model: Model, name: str, known: set[str]) -> str:
    """What an undeclared name may have been meant for."""
    of = name.removesuffix("_prev")
    if of != name and of in {i.name for i in model.inputs}:
        return f": the value of '{of}' at the sample before is previous({of}), one more of its inputs"
    return did_you_mean(name, known)


@lru_cache(maxsize=4096)
def _names(expr: Any) -> frozenset[str]:
    return frozenset(x.name for x in symbols(expr))


class _UnitError(Exception):
    pass


def _check_units(model: Model) -> None:
    from modelgen.units import parse, registry

    one = registry().Unit("dimensionless")
    units: dict[str, Any] = {}
    for q in (*model.inputs, *model.parameters, *model.scalar_parameters, *model.statements):
        try:
            units[q.name] = parse(q.unit)
        except InputError as why:
            raise InputError(f"model '{model.id}', '{q.name}': {why}") from None
    for s in model.statements:
        where = f"model '{model.id}', equation '{s.name}'" + (f" [{s.ref}]" if s.ref else "")
        wanted = units[s.name]
        checks: list[tuple[Any, Any]] = []
        if isinstance(s, Equation):
            checks = [(s.expr, wanted)]
        elif isinstance(s, State):
            time = units[model.inputs[0].name] if model.inputs else one
            checks = [(s.initial, wanted), (s.update, wanted), (s.rate, wanted / time)]
        else:
            checks = [(b, wanted) for b in s.bracket]
        try:
            if isinstance(s, Implicit):
                _unit(s.residual, units, one)
            for expr, unit in checks:
                if expr is not None:
                    _same(
                        _unit(expr, units, one), unit, f"the right-hand side is in {{}}, '{s.name}' in {{}}"
                    )
        except _UnitError as why:
            raise InputError(f"{where}: {why}") from None


ANY = None
"""Unit of zero, infinity and the like: agrees with every unit."""


def _same(a: Any, b: Any, says: str, where: Any = None) -> Any:
    """Return the unit of both, or raise: neither dimension nor scale may differ (mm + m is a mistake,
    too). `where` is the expression to show."""
    if a is ANY or b is ANY:
        return b if a is ANY else a
    if a == b:
        return a
    from modelgen.units import bridge, shown

    if not (a.dimensionality or b.dimensionality):  # deg, rad and 1 pass
        return a
    scales = bridge(a, b)
    if scales is None or abs(scales[0] - 1) > 1e-9:
        place = f", in {_short(where)}" if where is not None else ""
        cure = _cure(shown(a), scales) if a.dimensionality == b.dimensionality else ""
        raise _UnitError(says.format(shown(a), shown(b)) + place + cure)
    return a


def _cure(found: str, scales: tuple[float, str] | None) -> str:
    """What to do about two units of one dimension."""
    same = "write all in one unit (columns of recordings are converted anyway)"
    if scales is None:
        return f"; they have not the same zero: {same}"
    ratio, unit = scales
    return (
        f"; they differ by a factor of {max(ratio, 1 / ratio):.6g}: {same}, or multiply what is in {found} "
        f'by Parameter("per", "{unit}", {ratio:.15g}, known=True), as a plain number has no unit'
    )


def _unit(expr: Any, units: dict[str, Any], one: Any) -> Any:
    """The unit of an expression; raises _UnitError with what does not fit."""
    if isinstance(expr, sp.Symbol):
        return units[expr.name]
    if expr.is_Number or expr.is_NumberSymbol or expr is sp.I:
        return ANY if expr.is_zero or expr in (sp.oo, -sp.oo, sp.nan) else one
    if isinstance(expr, sp.Add | sp.Max | sp.Min):
        total = ANY
        for a in expr.args:
            total = _same(total, _unit(a, units, one), "{} and {} can't be added", expr)
        return total
    if isinstance(expr, sp.Mul):
        product = one
        for a in expr.args:
            u = _unit(a, units, one)
            if u is not ANY:
                product = product * u
        return product
    if isinstance(expr, sp.Pow):
        return _power(expr, units, one)
    if isinstance(expr, sp.Abs | sp.re | sp.im):
        return _unit(expr.args[0], units, one)
    if isinstance(expr, sp.Piecewise):
        total = ANY
        for value, condition in expr.args:
            total = _same(total, _unit(value, units, one), "branches in {} and {}", expr)
            _unit_condition(condition, units, one)
        return total
    if isinstance(expr, sp.arg | sp.sign):
        return one
    if isinstance(expr, sp.atan2):
        _same(_unit(expr.args[0], units, one), _unit(expr.args[1], units, one), "atan2 of {} and {}")
        return one
    for a in expr.args:  # functions take and give plain numbers
        _same(
            _unit(a, units, one),
            one,
            f"argument of {type(expr).__name__} is in {{}}, not in {{}}",
            expr,
        )
    return one


def _unit_condition(condition: Any, units: dict[str, Any], one: Any) -> None:
    if isinstance(condition, sp.core.relational.Relational):
        left, right = (_unit(a, units, one) for a in condition.args)
        _same(left, right, "{} and {} can't be compared", condition)
    else:
        for a in getattr(condition, "args", ()):
            _unit_condition(a, units, one)


def _power(expr: Any, units: dict[str, Any], one: Any) -> Any:
    base, exponent = expr.args
    unit = _unit(base, units, one)
    if exponent.is_Rational or exponent.is_Float:
        return one if unit is ANY else unit ** float(exponent)
    _same(_unit(exponent, units, one), one, "exponent is in {}, not in {}", expr)
    _same(unit, one, "base of a power with a symbol in its exponent is in {}, not in {}", expr)
    return one


def _short(expr: Any) -> str:
    text = str(expr)
    return text if len(text) < 80 else text[:77] + "..."
