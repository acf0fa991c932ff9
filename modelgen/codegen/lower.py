"""A model's statements as one SX program with exact derivatives (by CasADi), opaque calls and states chained
by hand."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from functools import reduce
from operator import or_
from typing import Any, NamedTuple

import casadi as ca

from modelgen.codegen.algebra import FREE, SAMPLE
from modelgen.codegen.derive import Chain, Residual
from modelgen.codegen.integrate import Slopes, rosenbrock, runge_kutta
from modelgen.codegen.simplify import staged
from modelgen.codegen.tosx import NONHOLOMORPHIC, Call, Translator
from modelgen.errors import InputError
from modelgen.language import Equation, Implicit, Model, State, Statement
from modelgen.language.derived import values_before
from modelgen.language.meant import expressions, symbols
from modelgen.language.quantities import ComplexParameter

UNROLLED = 4
"""More parts of a step than that are a loop."""
PART = "step part"
"""The number of a part of a step: an input by a name that no model can use."""


@dataclass(frozen=True)
class Column:
    """One derivative: by direction `at`, times j where it is an imaginary part's."""

    parameter: str
    terms: tuple[tuple[int, bool], ...]


class Lowering:
    """One pass through the statements: of the first sample (`first`), or of any later one.

    Where the step from sample to sample is a loop over its parts, states have come to its end before a later
    sample; with `part` one part is lowered instead, to which only states with a rate belong.

    `values` maps every name to its SX; `tangent` gives derivatives by the directions of `columns`. brief: as
    the equations are written, and only those that a fit needs.
    """

    def __init__(
        self, model: Model, wrt: tuple[str, ...], first: bool, part: bool = False, brief: bool = False
    ) -> None:  # fmt: skip
        self.model, self.wrt, self.first, self.brief = model, wrt, first, brief
        self.part = ca.SX.sym(PART) if part else None
        self.split_complex = _has_nonholomorphic(model)
        self.translator = Translator({}, set())
        self.inputs = {i.name: ca.SX.sym(i.name) for i in model.inputs}
        self._declare_parameters()
        self.old = {s.name: ca.SX.sym(s.name) for s in model.states}
        self.translator.env |= {**self.inputs, **({} if first else self.old)}
        self._run()
        self._chained({})

    def along(self, pattern: dict[str, set[int]]) -> Lowering:
        """The same where each state had depended on the directions that `pattern` says."""
        found = copy(self)
        found._chained(pattern)
        return found

    def _chained(self, pattern: dict[str, set[int]]) -> None:
        self.translator = self.translator.copy()  # derivatives make calls
        self.sensitivities: dict[tuple[str, int], Any] = {}
        old = ca.SX(len(self.old), len(self.directions))
        for row, name in enumerate(self.old):
            for at in sorted(pattern.get(name, ())):
                self.sensitivities[name, at] = old[row, at] = ca.SX.sym(f"d_{name}_{at}")
        leaves = [self._symbol(d) for d in self.directions] + ([] if self.first else list(self.old.values()))
        rows = ca.vertcat(ca.SX.eye(len(self.directions)), *([] if self.first else [old]))
        self.chain = Chain(self.translator, leaves, rows)

    def _declare_parameters(self) -> None:
        env = self.translator.env
        self.parameters = {p.name: ca.SX.sym(p.name) for p in self.model.scalar_parameters}
        env |= self.parameters
        self.plain: dict[str, Any] = {}
        for p in self.model.parameters:
            if isinstance(p, ComplexParameter):
                self.translator.complex_names.add(p.name)
                if self.split_complex:
                    env[p.name] = env[p.re.name] + self.translator.j * env[p.im.name]
                else:
                    self.plain[p.name] = env[p.name] = ca.SX.sym(p.name)
        scalars = {p.name: p for p in self.model.scalar_parameters}
        parts = {n: scalars[n].part for n in self.wrt}
        names = list(dict.fromkeys([*self.wrt, *(part[1] for part in parts.values() if part)]))
        self.directions = [n for n in names if n in self.wrt or n in self.plain]
        self.columns = []
        for n in self.wrt:
            terms = [(self.directions.index(n), False)]
            part = parts[n]
            if part and part[1] in self.plain:
                terms.append((self.directions.index(part[1]), part[0] == "im"))
            self.columns.append(Column(n, tuple(terms)))

    def _symbol(self, direction: str) -> Any:
        return self.plain[direction] if direction in self.plain else self.parameters[direction]

    def _run(self) -> None:
        t = self.translator
        self.values: dict[str, Any] = {}
        rated = [s for s in self.model.states if s.rate is not None]
        if self.first:
            for state in self.model.states:
                t.env[state.name] = self._real(t, state, state.initial)
        elif self.part is not None:
            self.values = self._integrated(rated)
            return
        elif rated and not parts_of(self.model):
            t.env |= self._integrated(rated)
        for s in fitted_statements(self.model) if self.brief else self.model.statements:
            if isinstance(s, Equation):
                t.env[s.name] = t.sx(s.expr)
                if t.is_complex(s.expr):
                    t.complex_names.add(s.name)
            elif isinstance(s, Implicit):
                t.env[s.name] = self._implicit(s, t)
            elif not self.first:
                new = t.env[s.name] if s.update is None else self._real(t, s, s.update)
                t.env[s.name] = t.same(s.name, new)
            self.values[s.name] = t.env[s.name]

    def _real(self, t: Translator, s: State | Implicit, expr: Any) -> Any:
        """The SX of what must be real in a statement."""
        if t.is_complex(expr):
            raise InputError(
                f"model '{self.model.id}', '{s.name}': {expr} is complex, wanted a real number; states and "
                "roots are real: carry re(…) and im(…), each by itself"
            )
        return t.sx(expr)

    def _implicit(self, s: Implicit, t: Translator) -> Any:
        free = sorted({x.name for x in s.residual.free_symbols} - {s.name})
        complex_ones = [n for n in free if n in t.complex_names]
        if complex_ones or t.is_complex(s.residual):
            raise InputError(
                f"model '{self.model.id}', implicit equation '{s.name}': its residual holds "
                f"'{(*complex_ones, 'j')[0]}', which is complex; write the real numbers that it needs, such "
                "as re(…), as equations before it"
            )
        args = tuple(t.env[n] for n in free) + tuple(self._real(t, s, b) for b in s.bracket)
        call = Call(
            f"solve_{s.name}",
            ca.SX.sym(s.name),
            args,
            False,
            ("real",) * len(args),
            None,
            Residual.of(s, free, t),
        )
        t.calls.append(call)
        return call.symbol

    # -- integration of dx/dt
    # ------------------------------------------------------------------------------------

    def _integrated(self, rated: list[State]) -> dict[str, Any]:
        """States over one step; inputs run linearly from their previous values to the present ones."""
        time = self.model.inputs[0].name
        before = {of: n for n, of in values_before(self.model).items()}
        if time not in before:
            raise InputError(f"model '{self.model.id}': a state with a rate needs the input previous({time})")
        base, names = self.translator.env, [s.name for s in rated]
        moves = {n: base[n] - base[p] for n, p in before.items()}

        def inputs(s: float) -> dict[str, Any]:
            return {n: base[p] + s * moves[n] for n, p in before.items()}

        def rates(s: float, x: list[Any]) -> list[Any]:
            return self._rates(rated, {**base, **inputs(s), **dict(zip(names, x, strict=True))})

        def slopes(s: float, x: list[Any]) -> Slopes:
            here = {**dict(zip(names, x, strict=True)), **inputs(s)}
            here = {n: self.translator.same(n, v) for n, v in here.items()}
            f = self._rates(rated, {**base, **here})
            rows = ca.diagcat(ca.SX.eye(len(names)), ca.vertcat(*moves.values()))
            D = Chain(self.translator, list(here.values()), rows).tangent(f)
            m = len(names)
            return Slopes(f, [[D[i, j] for j in range(m)] for i in range(m)], [D[i, m] for i in range(m)])

        start, steps = [base[n] for n in names], max(s.substeps for s in rated)
        end, H = start, moves[time]
        for k in range(steps) if self.part is None else (self.part,):
            if any(s.stiff for s in rated):
                end = rosenbrock(rates, slopes, end, H, steps, k)
            else:
                end = runge_kutta(rates, end, H, steps, k)
        return dict(zip(names, end, strict=True))

    def _rates(self, rated: list[State], env: dict[str, Any]) -> list[Any]:
        t = self.translator
        inner = Translator(dict(env), set(t.complex_names), t.j, t.calls, t._known)
        wanted = {s.name for s in rated}
        for s in self.model.statements:
            known = {x.name for e in expressions(s) for x in e.free_symbols} - {s.name} <= set(inner.env)
            if known and isinstance(s, Equation):
                inner.env[s.name] = inner.sx(s.expr)
                if inner.is_complex(s.expr):
                    inner.complex_names.add(s.name)
            elif known and isinstance(s, Implicit):
                inner.env[s.name] = self._implicit(s, inner)
            wanted.discard(s.name)
            if not wanted:
                break
        return [self._real(inner, s, s.rate) for s in rated]

    def tangent(self, exprs: list[Any]) -> Any:
        """d(exprs)/d(directions), SX of shape (len(exprs), directions), with calls and old states chained
        in."""
        return self.chain.tangent(exprs)

    def fitted(self, outputs: Sequence[str]) -> tuple[list[Any], Any]:
        """Values of `outputs` and their derivatives, with as little as may be left in the loop over samples.

        Derivatives go through the coefficients C that depend on parameters alone: ∂Z/∂C · dC/dθ.
        """
        exprs = [self.values[o] for o in outputs]
        if self.brief or self.model.states or not self.model.inputs:
            return exprs, self.tangent(exprs)
        short = staged(exprs, self._masks(), self.translator.j, nonzero(self.model))
        tangent = self.tangent(short.exprs)
        if short.symbols:
            slopes = ca.jacobian(ca.vertcat(*short.exprs), ca.vertcat(*short.symbols))
            tangent = tangent + ca.mtimes(slopes, self.tangent(short.coefficients))
        return [short.whole(e) for e in short.exprs], ca.sparsify(short.whole(tangent))

    def _masks(self) -> dict[str, int]:
        """What parameters, inputs and calls depend on: samples, free parameters, both, or neither."""
        free = {*self.wrt, *self.plain}
        masks = {n: FREE if n in free else 0 for n in (*self.parameters, *self.plain)}
        masks |= dict.fromkeys(self.inputs, SAMPLE)
        masks[self.translator.j.name()] = 0
        for call in self.translator.calls:
            inside = ca.symvar(ca.vertcat(*call.args))
            masks[call.symbol.name()] = reduce(or_, (masks[s.name()] for s in inside), 0)
        return masks


def parts_of(model: Model) -> int:
    """How many parts a step has, if so many that they are a loop; else 0."""
    steps = max((s.substeps for s in model.states if s.rate is not None), default=0)
    return steps if steps > UNROLLED else 0


def nonzero(model: Model) -> set[str]:
    """Names of parameters whose bounds leave 0 out: by these an expression may be divided."""
    found = {p.name for p in model.scalar_parameters if p.bounds[0] > 0 or p.bounds[1] < 0}
    pairs = (p for p in model.parameters if isinstance(p, ComplexParameter))
    return found | {p.name for p in pairs if {p.re.name, p.im.name} & found}


def fitted_statements(model: Model) -> list[Statement]:
    """What a fit needs: the primary outputs, all states, and what these depend on."""
    wanted, found = {*primary_outputs(model), *(s.name for s in model.states)}, list[Statement]()
    for s in reversed(model.statements):
        if s.name in wanted:
            found.append(s)
            wanted |= {x.name for e in expressions(s) for x in symbols(e)}
    return found[::-1]


def _has_nonholomorphic(model: Model) -> bool:
    """Whether a value that Jacobians need passes through |·|, arg, re or im of something complex, maybe."""
    if not any(isinstance(p, ComplexParameter) for p in model.parameters):
        return False
    return any(e.has(*NONHOLOMORPHIC) for s in fitted_statements(model) for e in expressions(s))


def primary_outputs(model: Model) -> tuple[str, ...]:
    """The outputs that are fitted: the first alone if it is complex, else all real ones."""
    from modelgen.language.quantities import is_complex

    first = model[model.outputs[0].name]
    if isinstance(first, Equation) and is_complex(first.expr):
        return (first.name,)
    return tuple(o.name for o in model.outputs)


class Lowered(NamedTuple):
    """A model lowered: a later sample, the first one if there are states, a part of a step if it has any.

    pattern: which directions each state depends on.
    """

    pattern: dict[str, set[int]]
    step: Lowering
    first: Lowering | None = None
    part: Lowering | None = None


def lower(model: Model, wrt: tuple[str, ...], brief: bool = False) -> Lowered:
    """Lower `model`; which states depend on which directions by iterating the structure to a fixed point."""
    if not model.states:
        return Lowered({}, Lowering(model, wrt, first=False, brief=brief))
    pattern: dict[str, set[int]] = {s.name: set() for s in model.states}
    first = Lowering(model, wrt, first=True, brief=brief)
    _collect(pattern, first)
    plain = Lowering(model, wrt, first=False, brief=brief)
    apart = Lowering(model, wrt, first=False, part=True, brief=brief) if parts_of(model) else None
    while True:
        size = sum(map(len, pattern.values()))
        step, part = plain.along(pattern), apart and apart.along(pattern)
        _collect(pattern, step)
        if part is not None:
            _collect(pattern, part)
        if sum(map(len, pattern.values())) == size:
            return Lowered(pattern, step, first, part)


def _collect(pattern: dict[str, set[int]], low: Lowering) -> None:
    names = [n for n in pattern if n in low.values]
    rows, columns = low.tangent([low.values[n] for n in names]).sparsity().get_triplet()
    for r, c in zip(rows, columns, strict=True):
        pattern[names[r]].add(c)
