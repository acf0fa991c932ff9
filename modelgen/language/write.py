"""A model as a Python file: what a diagnosis found is handed back in the language of models."""

from __future__ import annotations

import builtins
import keyword
from collections import Counter
from collections.abc import Sequence
from math import inf, isinf
from typing import Any

import sympy as sp

from modelgen.language import __all__ as LANGUAGE
from modelgen.language import functions
from modelgen.language.layout import arguments, assigned, fill, imported, quoted, row
from modelgen.language.meant import expressions
from modelgen.language.model import Model, Output, Port, check_name
from modelgen.language.pyprint import Printer
from modelgen.language.quantities import (
    ComplexParameter,
    Condition,
    Equation,
    Implicit,
    Input,
    Parameter,
    Statement,
    acceleration_of,
    complex_parameter,
    previous,
    rate_of,
    turning_point_of,
)

ALL = (-inf, inf)
Call = tuple[str, list[str]]
"""A function's name and the text of its arguments."""


def to_python(model: Model, name: str = "model", note: str = "") -> str:
    """A Python file which builds `model` as the variable `name`: same quantities, equations, ports and hash.

    It imports nothing but modelgen.language; `note` goes into its docstring. What a variant was chosen by
    (`options`) is not written: the file holds this variant. Raises InputError when `name` is no name.
    """
    check_name(name, "variable")
    file = _File(model, name)
    groups = [
        [line for i in model.inputs for line in file.define(i, file.input(i))],
        [line for p in model.parameters for line in file.define(p, file.parameter(p))],
        [line for s in model.statements for line in file.statement(s)],
        file.model(),
    ]
    parts = [[_docstring(model, note)], file.imports(), file.constants(), *groups]
    return "\n\n".join("\n".join(p) for p in parts if p) + "\n"


def _docstring(model: Model, note: str) -> str:
    parts = [model.text or model.id, f"Source: {model.source}" if model.source else "", note]
    text = "\n\n".join(p.strip() for p in parts if p.strip()).replace("\\", "\\\\").replace('"', '\\"')
    return f'"""{text}\n"""' if "\n" in text else f'"""{text}"""'


def free(name: str, taken: set[str]) -> str:
    """`name`, with underscores behind it where that means something else already; from here on it is
    taken."""
    while name in taken:
        name += "_"
    taken.add(name)
    return name


class _File:
    """What is known while the file grows downwards: variables, what symbols are called, what is used."""

    def __init__(self, model: Model, name: str) -> None:
        self.source = model
        self.name = name
        self.printer = Printer({})
        self.symbols = self.printer.symbols
        reserved = (dir(builtins), keyword.kwlist, LANGUAGE, vars(functions))
        self.taken = {name, "inf", "nan", *(x for names in reserved for x in names)}
        quantities = (*model.inputs, *model.parameters, *model.statements)
        self.variable = {q.name: free(q.name, self.taken) for q in quantities}
        sources = Counter(p.source if isinstance(p, Parameter) else p.re.source for p in model.parameters)
        self.shared = self.numbered("SOURCE", [s for s, n in sources.items() if s and n > 1])

    def numbered(self, name: str, texts: Sequence[str]) -> dict[str, str]:
        """A variable for each text that stands in several places."""
        several = len(texts) > 1
        return {t: free(f"{name}_{k}" if several else name, self.taken) for k, t in enumerate(texts, 1)}

    def use(self, name: str) -> str:
        self.printer.used.add(name)
        return name

    def imports(self) -> list[str]:
        wanted = self.printer.used - {"inf", "nan"}
        own = sorted(wanted & set(LANGUAGE))
        others = sorted(wanted - set(own) & set(vars(functions)))
        foreign = sorted(wanted - set(own) - set(others))
        places = (("modelgen.language", own), ("modelgen.language.functions", others), ("sympy", foreign))
        return [imported(module, names) for module, names in places if names]

    def constants(self) -> list[str]:
        lines = [f'{x} = float("{x}")' for x in ("inf", "nan") if x in self.printer.used]
        return lines + [assigned(variable, quoted(text)) for text, variable in self.shared.items()]

    def define(self, q: Any, value: Call) -> list[str]:
        """`variable = value`; from here on the variable stands for the quantity's symbol."""
        variable = self.variable[q.name]
        self.symbols[q.symbol] = variable
        if isinstance(q, ComplexParameter):
            self.symbols |= {q.re.symbol: f"{variable}.re", q.im.symbol: f"{variable}.im"}
        return [f"{variable} = {fill(*value, before=len(variable) + 3)}"]

    # -- quantities --------------------------------------------------------------------------------------

    def input(self, i: Input) -> Call:
        kind, of = i.derived or ("", "")
        before = [x for x in self.source.inputs[: self.source.inputs.index(i)] if x.name == of]
        if before and (found := _derived(kind, before[0], i)):
            function, others = found
            return self.call(function, [self.variable[of], *map(quoted, others)])
        return self.call("Input", [quoted(i.name), quoted(i.unit)], [
            ("text", quoted(i.text), not i.text), ("derived", repr(i.derived), i.derived is None),
            ("range", repr(i.range), i.range is None),
        ])  # fmt: skip

    def parameter(self, p: Parameter | ComplexParameter) -> Call:
        if isinstance(p, ComplexParameter):
            return self.complex_parameter(p)
        return self.call("Parameter", [quoted(p.name), quoted(p.unit)], [
            ("default", self.number(p.default), p.default is None),
            ("bounds", self.pair(p.bounds), p.bounds == ALL),
            ("text", quoted(p.text), not p.text), ("source", self.reference(p.source), not p.source),
            ("known", "True", not p.known), ("part", repr(p.part), p.part is None),
        ], positional=4)  # fmt: skip

    def complex_parameter(self, p: ComplexParameter) -> Call:
        """By `complex_parameter` where that gives the same parts, else with its parts written out."""
        parts = (p.re.default, p.im.default)
        default = None if parts[0] is None or parts[1] is None else complex(parts[0], parts[1])
        text = p.re.text.removeprefix("real part of ")
        text = "" if text == p.name else text
        name = [quoted(p.name), quoted(p.unit)]
        if complex_parameter(p.name, p.unit, default, p.re.bounds, p.im.bounds, text, p.re.source) != p:
            return self.call(
                "ComplexParameter", [*name, fill(*self.parameter(p.re)), fill(*self.parameter(p.im))]
            )
        return self.call("complex_parameter", name, [
            ("default", repr(default), default is None),
            ("re", self.pair(p.re.bounds), p.re.bounds == ALL),
            ("im", self.pair(p.im.bounds), p.im.bounds == ALL),
            ("text", quoted(text), not text), ("source", self.reference(p.re.source), not p.re.source),
        ], positional=1)  # fmt: skip

    def reference(self, source: str) -> str:
        return self.shared.get(source, quoted(source))

    def number(self, x: float | None) -> str:
        if x is None:
            return "None"
        if isinf(x):
            self.use("inf")
        short = f"{x:g}"
        return short if float(short) == x else repr(float(x))

    def pair(self, pair: tuple[float, float]) -> str:
        return row(self.number(x) for x in pair)

    # -- statements --------------------------------------------------------------------------------------

    def statement(self, s: Statement) -> list[str]:
        aliases = [line for e in expressions(s) for line in self.aliases(e)]
        say = self.printer.doprint
        tail = [
            ("unit", quoted(s.unit), s.unit == "1"), ("ref", quoted(s.ref), not s.ref),
            ("text", quoted(s.text), not s.text),
        ]  # fmt: skip
        if isinstance(s, Equation):
            value = self.call("Equation", [quoted(s.name), say(s.expr)], tail, positional=2)
        elif isinstance(s, Implicit):
            bracket = row(say(b) for b in s.bracket)
            value = self.call("Implicit", [quoted(s.name), say(s.residual), bracket], tail, positional=2)
        else:
            steps = [(k, say(getattr(s, k) or 0), getattr(s, k) is None) for k in ("update", "rate")]
            tail = [*steps, *tail, ("substeps", repr(s.substeps), s.substeps == 1),
                    ("stiff", repr(s.stiff), not s.stiff)]  # fmt: skip
            value = self.call("State", [quoted(s.name), say(s.initial)], tail)
        return [*aliases, *self.define(s, value)]

    def aliases(self, expr: Any) -> list[str]:
        """Variables for symbols that no quantity stands for as yet: a state before its step, an unknown.

        Also for a quantity that was real when its user was written, and has become complex since.
        """
        lines = []
        unknown = {s.name for s in self.source.statements if isinstance(s, Implicit)}
        declared = {x.name for x in self.symbols}
        for x in sorted(expr.free_symbols - set(self.symbols), key=lambda x: x.name):
            kind = "real" if x.is_real else "complex"
            new = kind if x.name in declared else "sought" if x.name in unknown else "before"
            self.symbols[x] = free(f"{x.name}_{new}", self.taken)
            real = ["real=True"] if x.is_real else []
            lines.append(f"{self.symbols[x]} = {fill(*self.call('Symbol', [quoted(x.name), *real]))}")
        return lines

    # -- the model ---------------------------------------------------------------------------------------

    def model(self) -> list[str]:
        m = self.source
        values = [sp.sympify(value) for p in m.ports for _, value in p.variables]
        lines = [line for v in values for line in self.aliases(v)]
        variables = Counter(self.variables(p) for p in m.ports if p.variables)
        shared = self.numbered("at", [v for v, n in variables.items() if n > 1])
        quantities = {"inputs": m.inputs, "parameters": m.parameters, "statements": m.statements}
        texts = {key: [self.variable[q.name] for q in found] for key, found in quantities.items()}
        texts |= {
            "outputs": [self.output(o) for o in m.outputs],
            "ports": [self.port(p, shared) for p in m.ports],
            "conditions": [self.condition(c) for c in m.conditions],
        }
        fields = [quoted(m.id)]
        fields += [
            f"{k}={fill('', x, before=len(k) + 6, always=k == 'ports')}" for k, x in texts.items() if x
        ]
        fields += [f"drops={row(row([quoted(n), repr(x)]) for n, x in m.drops)}"] if m.drops else []
        fields += [f"{key}={quoted(text)}" for key, text in (("source", m.source), ("text", m.text)) if text]
        lines += [assigned(variable, text) for text, variable in shared.items()]
        body = "".join("    " + f.replace("\n", "\n    ") + ",\n" for f in fields)
        return [*lines, f"{self.name} = {self.use('Model')}(\n{body})"]

    def condition(self, c: Condition) -> str:
        given = [quoted(c.says), self.printer.doprint(c.expr)]
        return fill(*self.call("Condition", given, [("ref", quoted(c.ref), not c.ref)]))

    def output(self, o: Output) -> str:
        others = [("measured_as", repr(o.measured_as), not o.measured_as)]
        return fill(*self.call("Output", [quoted(o.name)], others))

    def port(self, p: Port, shared: dict[str, str]) -> str:
        variables = self.variables(p)
        there = [shared.get(variables, variables)] if p.variables else []
        return fill(*self.call("Port", [*map(quoted, (p.name, p.kind, p.equation)), *there]), before=9)

    def variables(self, port: Port) -> str:
        own = set(self.variable.values())
        texts = {key: self.printer.doprint(sp.sympify(value)) for key, value in port.variables}
        return row(row([quoted(key), f"{t}.symbol" if t in own else t]) for key, t in texts.items())

    def call(
        self,
        function: str,
        given: Sequence[str],
        optional: Sequence[tuple[str, str, bool]] = (),
        positional: int = 0,
    ) -> Call:
        return self.use(function), arguments(given, optional, positional)


def _derived(kind: str, of: Input, i: Input) -> tuple[str, tuple[str, ...]] | None:
    """The function which derives `i` from `of`, and its further arguments, where it gives just that."""
    named = {
        "previous": (previous(of), "previous", ()),
        "turning": (turning_point_of(of), "turning_point_of", ()),
        "rate": (rate_of(of, i.name, i.unit), "rate_of", (i.name, i.unit)),
        "acceleration": (acceleration_of(of, i.name, i.unit), "acceleration_of", (i.name, i.unit)),
    }
    same, function, others = named.get(kind, (None, "", ()))
    return (function, others) if same == i else None
