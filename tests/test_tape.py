"""Loops as tapes: the same bits as compiled C, for every operation, at every length of a tile."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from modelgen import models
from modelgen.codegen import Function, build_many
from modelgen.codegen.build import _compile, default_wrt
from modelgen.codegen.compiler import QUICK, WIDE
from modelgen.codegen.emit import emit
from modelgen.codegen.function import Prepared
from modelgen.codegen.instant import available
from modelgen.codegen.program import build_program
from modelgen.codegen.roofline import example
from modelgen.codegen.tape import CODES, OPERATIONS
from modelgen.codegen.tiers import Code, Tiers
from modelgen.effects import CATALOGUE
from modelgen.language import Equation, Input, Model, Parameter, Symbol
from modelgen.models import SHIPPED

pytestmark = pytest.mark.skipif(not available(), reason="no Tiny C Compiler for this machine")
KERNELS = ("values", "jacobian", "sumsq", "normal")
LENGTHS = (1, 2, 15, 64, 65, 255, 257, 700)


def both(model: Model) -> tuple[Function, Function]:
    """A model in memory, and as a library that rounds every operation."""
    wrt = default_wrt(model)
    (taped,) = build_many([(model, wrt)], KERNELS)
    source = emit(build_program(model, wrt), KERNELS)
    library = _compile([source], QUICK if model.is_time_model else WIDE)
    return taped, Function(model, wrt, taped.free, Tiers(lambda: Code(source, library)))


def results(ready: Prepared, measure: str, theta: np.ndarray) -> list[np.ndarray]:
    """Of all kernels, with data and weights that any two of the same length have in common."""
    rng = np.random.default_rng(ready.n)
    shape = (ready.code.channels(measure), ready.n)
    data, weight = (ready.pad(rng.uniform(0.5, 1.5, shape)) for _ in range(2))
    rows = np.array([theta, 1.01 * theta])
    normal = ready.normal(theta, measure, data, weight)
    sums = ready.sumsq(rows, measure, data, weight)
    return [ready.values(theta, measure), *ready.jacobian(theta, measure), sums, *map(np.asarray, normal)]


def assert_same_bits(model: Model, n: int, tapes: str) -> None:
    one, other = both(model)
    assert one.code.source.tapes == tapes and not isinstance(one.code.library, Path)
    at = example(model, n)
    ready, compiled = one.prepare(**at), other.prepare(**at)
    for measure in one.code.source.measures:
        theta = ready.p[one.free]
        for a, b in zip(results(ready, measure, theta), results(compiled, measure, theta), strict=True):
            assert np.array_equal(a, b, equal_nan=True), measure


TAPES = {"complex_stiffness": "none", "bouc_wen": "none", "modified_dahl": "some"}


@pytest.mark.parametrize("name", [n for n in SHIPPED if getattr(models, n).inputs])
def test_shipped_models(name: str) -> None:
    assert_same_bits(getattr(models, name), 401, TAPES.get(name, "all"))


@pytest.mark.parametrize("n", LENGTHS)
@pytest.mark.parametrize("name", ["electrodynamic_transducer", "lugre"])
def test_tiles_of_any_length(name: str, n: int) -> None:
    assert_same_bits(getattr(models, name), n, "all")


def test_every_operation() -> None:
    x, a, b = Input("x", "1"), Parameter("a", "1", 0.7), Parameter("b", "1", 1.3)
    X, A, B = (Symbol(n, real=True) for n in "xab")
    unit = sp.Abs(X) / (1 + X**2)  # 0 to 1/2
    f = {
        "arithmetic": A * X + B * X**2 - X / (A + X**2) + 2 / (1 + unit) - (A - X) * (B - X) + A / X,
        "powers": (1 + unit) ** A + sp.sqrt(1 + X**2) + (A + unit) ** X,
        "circle": sp.sin(A * X) + sp.cos(X) + sp.tan(unit) + sp.atan(A * X) + sp.atan2(X, A) + sp.acos(unit),
        "hyperbola": sp.sinh(A * X) + sp.cosh(X) + sp.tanh(B * X) + sp.asinh(X) + sp.atanh(A * unit),
        "logarithm": sp.exp(-unit * A) + sp.log(B + X**2) + sp.erf(A * X) + sp.asin(A * unit),
        "choice": sp.Piecewise((A * X, X < -B), (B * X**2, X <= 0.3), (X, True))
        + sp.Max(A * X, B)
        + sp.sign(X),
        "steps": sp.floor(3 * X) + sp.ceiling(X) + sp.Min(X, A) + sp.Abs(X - A),
    }
    equations = tuple(Equation(n, e) for n, e in f.items())
    assert_same_bits(Model("operations", (x,), (a, b), equations, tuple(f)), 333, "all")


@pytest.mark.parametrize("every", [6, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "base", ["electrodynamic_transducer", "magnetostrictive_transducer", "modified_dahl"]
)
def test_models_with_an_effect(base: str, every: int) -> None:
    """Effects that fit a port of the base, what a search compiles by the hundred: all, or each `every`
    one."""
    model = replace(getattr(models, base), checked=False)
    extended = [e.extend(model, port) for e in CATALOGUE[::every] for port in e.fits(model)]
    made = [(m, default_wrt(m)) for m in extended]
    taped = build_many(made, ("jacobian",))
    assert len(made) >= 10
    for F, (m, wrt) in zip(taped, made, strict=True):
        source = emit(build_program(m, wrt), ("jacobian",))
        library = _compile([source], QUICK if m.is_time_model else WIDE)
        G = Function(m, wrt, F.free, Tiers(lambda: Code(source, library)))  # noqa: B023
        at = example(m, 130)
        ready, compiled = F.prepare(**at), G.prepare(**at)
        theta, measure = ready.p[F.free], F.code.source.measures[0]
        for x, y in zip(ready.jacobian(theta, measure), compiled.jacobian(theta, measure), strict=True):
            assert np.array_equal(x, y, equal_nan=True), m.id


def test_operations_are_what_they_are_called() -> None:
    """The machine's own list has no name twice, and as many operands as its C uses."""
    assert len(CODES) == len({*CODES}) and len(CODES) > 50
    for name, kinds, text in OPERATIONS:
        used = {c for c in "abcd" if re.search(rf"\b{c}\b", text)}
        assert used == set("abcd"[: len(kinds)]), name
