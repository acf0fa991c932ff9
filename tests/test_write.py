"""A model written to a Python file and read back is the same model, whatever physics was added to it."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import pytest
import sympy as sp
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import modelgen.models as models
from modelgen.effects import CATALOGUE
from modelgen.errors import InputError
from modelgen.language import Equation, Implicit, Input, Model, Parameter, Piecewise, State, Symbol, sqrt
from modelgen.language.pyprint import Printer
from modelgen.language.write import to_python

SAME = ("id", "inputs", "parameters", "statements", "outputs", "ports", "source", "text")


def again(model: Model) -> Model:
    """The model of the file that is written of `model`; its units are checked when it is made."""
    names: dict[str, Any] = {}
    exec(compile(to_python(model), "written.py", "exec"), names)
    return names["model"]


def assert_same(model: Model) -> None:
    read = again(model)
    assert read.hash == model.hash
    for key in SAME:
        assert getattr(read, key) == getattr(model, key), key


def fitting(model: Model) -> list[Any]:
    return [(e, port) for e in CATALOGUE for port in e.fits(model)]


LONG = ("fractional_kelvin_voigt", "four_parameter_viscoelastic", "lugre")
NAMES = [pytest.param(n, marks=pytest.mark.slow) if n in LONG else n for n in models.SHIPPED]


@pytest.mark.parametrize("name", NAMES)
def test_shipped_models_with_and_without_each_effect(name: str) -> None:
    model = models.load(name)
    assert_same(model)
    for effect, port in fitting(model):
        assert_same(effect.extend(model, port))


@pytest.mark.parametrize("name", NAMES)
def test_two_effects_at_once(name: str) -> None:
    model = models.load(name)
    pairs = [(a, b) for a, b in combinations(fitting(model), 2) if a[0].id != b[0].id]
    for (a, at), (b, by) in pairs[:: max(1, len(pairs) // 12)]:
        assert_same(b.extend(a.extend(model, at), by))


@pytest.mark.parametrize("options", [{"eddy": "series"}, {"eddy": "none"}, {"eddy_sign": "printed"}])
def test_variants(options: dict[str, str]) -> None:
    assert_same(models.magnetostrictive_transducer.variant(**options))


def test_a_written_file_is_loaded_by_its_name(tmp_path: Path) -> None:
    model = models.electrodynamic_transducer
    (tmp_path / "found.py").write_text(
        to_python(model, "loudspeaker", 'found in "sweep"\\1'), encoding="utf-8"
    )
    assert models.load("found.py:loudspeaker", tmp_path).hash == model.hash
    text = (tmp_path / "found.py").read_text(encoding="utf-8")
    imports = [line for line in text.splitlines() if line.startswith(("import", "from"))]
    assert imports == [line for line in imports if line.startswith("from modelgen.language import")]
    assert all(len(line) <= 110 for line in text.splitlines())
    with pytest.raises(InputError, match="variable"):
        to_python(model, "no name")


def test_names_that_mean_something_else_in_python() -> None:
    """A parameter may be called lambda, gamma, re, Model or model; a state may be used above itself."""
    t = Input("t", "s")
    names = ("lambda", "gamma", "re", "Model", "model", "inf", "x_before", "SOURCE")
    given = [Parameter(n, "1", 0.5, (0.0, 2.0), source="here") for n in names]
    x = Symbol("x", real=True)
    total = Equation("sum", x + sp.Add(*given), "1")
    state = State("x", given[0], sqrt(1 + x**2) / 3, unit="1", substeps=2)
    root = Implicit("print", Symbol("print", real=True) - total.symbol, (-1, total.symbol + 1))
    last = Equation("y", Piecewise((state * root, total > 0), (sp.Rational(1, 3), True)), "1")
    model = Model("odd", (t,), tuple(given), (total, state, root, last), ("y",))
    assert_same(model)
    rate = replace(state, update=None, rate=-x * given[1])
    with pytest.raises(InputError, match="right-hand side"):
        replace(model, statements=(total, rate, root, last))  # 1/s is wanted: units are checked in files, too


SYMBOLS = sp.symbols("x y z", real=True)
numbers = st.one_of(
    st.integers(-5, 5).map(sp.Integer),
    st.builds(sp.Rational, st.integers(-7, 7), st.integers(2, 9)),
    st.floats(-1e3, 1e3).filter(lambda v: v != 0 and abs(v) > 1e-12).map(sp.Float),
    st.sampled_from([sp.pi, sp.I, sp.E]),
)


def grown(inner: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    powers = st.sampled_from(
        [-3, -2, -1, 2, sp.Rational(1, 2), sp.Rational(-3, 2), sp.Float(0.5), SYMBOLS[2]]
    )
    return st.one_of(
        st.lists(inner, min_size=2, max_size=4).map(lambda a: sp.Add(*a)),
        st.lists(inner, min_size=2, max_size=4).map(lambda a: sp.Mul(*a)),
        st.tuples(inner, powers).map(lambda a: sp.Pow(*a)),
        st.tuples(st.sampled_from([sp.exp, sp.Abs, sp.re, sp.tanh, sp.sqrt]), inner).map(
            lambda a: a[0](a[1])
        ),
    )


expressions = st.recursive(st.one_of(st.sampled_from(SYMBOLS), numbers), grown, max_leaves=8)


def rebuilt(expr: Any) -> Any:
    return expr.func(*map(rebuilt, expr.args)) if expr.args else expr


@settings(max_examples=200, deadline=None)
@given(expressions)
def test_expressions_are_read_back_exactly(expr: Any) -> None:
    if expr.has(sp.zoo, sp.nan, sp.oo) or any(not 1e-290 < abs(x) < 1e290 for x in expr.atoms(sp.Float)):
        return  # a model holds numbers of double precision
    assume(
        rebuilt(expr) == expr
    )  # sympy itself leaves some products of roots of j as they aren't when made anew
    text = Printer({x: x.name for x in SYMBOLS}).doprint(expr)
    names = {**vars(sp), "j": sp.I, **{x.name: x for x in SYMBOLS}}
    assert sp.srepr(sp.sympify(eval(text, names))) == sp.srepr(expr), text
