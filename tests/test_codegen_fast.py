"""What makes kernels fast changes no number: the algebra before the loop, and functions without a branch."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import Any

import mpmath as mp
import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

import modelgen.models as models
from modelgen.codegen import build, build_many
from modelgen.codegen.build import ALL
from modelgen.codegen.compiler import FAST, find_compiler
from modelgen.codegen.emit import emit, environment
from modelgen.codegen.program import build_program
from modelgen.effects import CATALOGUE
from modelgen.language import Equation, Input, Model, Parameter, Piecewise

TRANSDUCERS = ("magnetostrictive_transducer", "electrodynamic_transducer")
SIX = ("mu33_re", "mu33_im", "S33_re", "S33_im", "d33_re", "d33_im")
ENDS = (np.inf, -np.inf, np.nan, 0.0, -0.0, 5e-324, -5e-324, 1e-310, 1e308, -1e308)


@pytest.fixture(scope="module")
def branchless(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Any]:
    """Calls a function of templates/vector.h.j2, compiled as kernels are."""
    names = ("exp", "log", "sin", "cos", "atan2")
    template = environment().from_string('{% from "vector.h.j2" import vector %}{{ vector(used) }}')
    code = "#include <math.h>\n#include <stddef.h>\n#include <stdint.h>\n"
    code += template.render(used={f"mg_{n}" for n in names})
    for n in names:
        more = "x[i], y[i]" if n == "atan2" else "x[i]"
        code += (
            f"void v_{n}(size_t n, const double *restrict x, const double *restrict y, double *restrict o)"
            f"{{ (void)y; for (size_t i = 0; i < n; ++i) o[i] = mg_{n}({more}); }}\n"
        )
    folder = tmp_path_factory.mktemp("vector")
    (folder / "v.c").write_text(code)
    compiler = find_compiler()
    command = [*compiler.command, *compiler.flags(FAST), "v.c", "-o", "v.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    library = ctypes.CDLL(str(folder / "v.so"))

    def call(name: str, x: Any, y: Any = 0.0) -> Any:
        x, y = (np.array(a, dtype=float) for a in np.broadcast_arrays(np.array(x, dtype=float), y))
        out = np.empty(x.size)
        addresses = (ctypes.c_void_p(a.ctypes.data) for a in (x, y, out))
        getattr(library, f"v_{name}")(ctypes.c_size_t(x.size), *addresses)
        return out

    return call


@pytest.mark.parametrize("name, low, high, ulps", [
    ("exp", -708.0, 709.0, 1.5), ("log", 1e-308, 1e3, 1.5), ("sin", -30.0, 30.0, 2.5),
    ("cos", -3.0, 3.0, 2.5), ("sin", -1e6, 1e6, 4.0),
])  # fmt: skip
def test_functions_without_a_branch_are_right_to_the_last_places(
    branchless: Any, name: str, low: float, high: float, ulps: float
) -> None:
    x = np.random.default_rng(0).uniform(low, high, 800)
    with mp.workprec(120):
        exact = [getattr(mp, name)(mp.mpf(float(v))) for v in x]
        errors = [abs(mp.mpf(float(a)) - b) for a, b in zip(branchless(name, x), exact, strict=True)]
    assert all(e <= ulps * np.spacing(abs(float(b))) for e, b in zip(errors, exact, strict=True))


def test_the_angle_is_right_all_around(branchless: Any) -> None:
    rng = np.random.default_rng(1)
    y, x = rng.normal(size=2000) * np.exp(4 * rng.normal(size=2000)), rng.normal(size=2000)
    assert branchless("atan2", y, x) == pytest.approx(np.arctan2(y, x), rel=1e-15)
    on_axes = [(0, 1), (1, 0), (-1, 0), (0, -1), (0, 0)]
    for b, a in on_axes:
        assert branchless("atan2", b, a)[0] == pytest.approx(np.arctan2(b, a), rel=1e-15)
    assert np.isnan(branchless("atan2", [np.nan, 1.0, np.nan], [0.0, np.nan, np.nan])).all()


@pytest.mark.parametrize("name", ["exp", "log"])
def test_functions_without_a_branch_at_the_ends_of_the_range(branchless: Any, name: str) -> None:
    with np.errstate(all="ignore"):
        wanted = getattr(np, name)(np.array(ENDS))
    np.testing.assert_allclose(branchless(name, ENDS), wanted, rtol=1e-15)


def test_an_angle_without_digits_is_no_number(branchless: Any) -> None:
    for name in ("sin", "cos"):
        assert np.isnan(branchless(name, [np.inf, -np.inf, np.nan, 1e308, 1e10])).all()


def random_parameters(model: Model, seed: int) -> dict[str, float]:
    """Defaults, each changed by up to two octaves, within bounds."""
    rng = np.random.default_rng(seed)
    moved = {p.name: float(p.default or 0.0) * float(np.exp(rng.normal())) for p in model.scalar_parameters}
    return {p.name: float(np.clip(moved[p.name], *p.bounds)) for p in model.scalar_parameters}


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(TRANSDUCERS), st.integers(0, 2**31))
def test_the_kernel_agrees_with_the_equations_as_written(name: str, seed: int) -> None:
    function = build(getattr(models, name))
    values = random_parameters(function.model, seed)
    f = np.geomspace(1.0, 1e5, 64)
    written = function.all(f=f, **values)["Z"]
    np.testing.assert_allclose(np.abs(function(f=f, **values) - written) / np.abs(written), 0, atol=1e-12)


SCALES = {"omega": 3e3, "time": 3e-4, "duration": 3e-3, "port": 10.0}


@pytest.mark.slow
@pytest.mark.parametrize("name", TRANSDUCERS)
def test_with_any_effect_added_they_agree_too(name: str) -> None:
    model = replace(getattr(models, name), checked=False)
    pairs = [(e, port) for e in CATALOGUE for port in e.fits(model)]
    extended = [e.extend(model, port) for e, port in pairs]
    wrt = [tuple(p.name for p in m.scalar_parameters if not p.known) for m in extended]
    f = np.geomspace(10.0, 1e4, 40)
    functions = build_many(list(zip(extended, wrt, strict=True)), ("values", "all"), ("complex",))
    for function, (e, port) in zip(functions, pairs, strict=True):
        values, own = random_parameters(function.model, 3), e.parameters(model, port)
        values |= {own[q.name].name: max(0.1, q.null) for q in e.strengths}
        values |= {own[q.name].name: q.low * q.high * SCALES.get(q.scale, 0.5) for q in e.shapes}
        fast, written = function(f=f, **values), function.all(f=f, **values)["Z"]
        assert np.isfinite(fast).all(), e.id
        worst = np.max(np.abs(fast - written) / np.abs(written))
        assert worst < 1e-12, (e.id, port.name, worst)


def test_from_the_textbook_form_to_one_division_in_the_loop() -> None:
    """In (6) to (11) the coupling has χ above and below: it cancels, and the loop divides by Z_t alone."""
    source = emit(build_program(models.magnetostrictive_transducer, SIX), ("values",), "", ("complex",))
    loop = next(k for k in source.kernels if k.name == "values_complex").code.split("for (")[1]
    code = "".join(line.split("/*")[0] for line in loop.splitlines())
    assert code.count("/") == 1
    assert next(k.work.operations for k in source.kernels if k.name == "values_complex") <= 26


def test_nothing_is_divided_by_what_may_be_zero() -> None:
    """μ'' = 0, d = 0 and f → 0 are harmless in the equations, so they are in the kernel."""
    function = build(models.magnetostrictive_transducer, SIX)
    values = {"mu33_im": 0.0, "d33_re": 0.0, "d33_im": 0.0}
    written = function.all(f=[1600.0], **values)["Z"]
    assert function(f=[1600.0], **values) == pytest.approx(written, rel=1e-13)
    assert np.isfinite(function.jacobian(f=[1600.0], **values)).all()


def test_nor_by_what_other_bounds_kept_from_zero() -> None:
    """Code that is kept from an earlier build is not that of the same equations under tighter bounds."""
    model = models.magnetostrictive_transducer
    for low in (1e-30, -np.inf):
        bounded = (replace(p, bounds=(low, np.inf)) for p in model.parameters if isinstance(p, Parameter))
        within = model.with_parameters(*bounded)
        kept = build(within, SIX, wait=True).code.source.kernels
        assert [k.work for k in kept] == [k.work for k in emit(build_program(within, SIX), ALL).kernels]


@pytest.mark.parametrize("held", SIX)
def test_a_constant_that_is_held_changes_no_number(held: str) -> None:
    """With μ' held, sums that are proportional had different terms, and no kernel was made."""
    free = tuple(n for n in SIX if n != held)
    function, whole = (build(models.magnetostrictive_transducer, n) for n in (free, SIX))
    f = np.geomspace(100.0, 1e4, 50)
    assert function(f=f) == pytest.approx(whole(f=f), rel=1e-12)
    columns = [SIX.index(n) for n in free]
    assert function.jacobian(f=f) == pytest.approx(whole.jacobian(f=f)[..., columns], rel=1e-9)


@pytest.mark.parametrize("name, off", [("modified_dahl", {"b": np.nextafter(1.0, 2.0)}), ("lugre", None)])
@pytest.mark.parametrize("n", [2, 8, 9, 256, 257, 258, 265, 700])
def test_a_scan_gives_what_one_step_after_the_other_gives(name: str, off: Any, n: int) -> None:
    """In lanes and tiles of any filling; an exponent beside 1 makes the modified Dahl model march."""
    F = build(getattr(models, name))
    t = np.arange(n) * 1e-3
    recording = {"t": t, "z": 3 * np.sin(40 * t) + np.cumsum(np.random.default_rng(n).normal(0, 0.05, n))}
    scanned, theta = F.prepare(**recording), F.prepare(**recording).p[F.free]
    values, jac = scanned.jacobian(theta, "real")
    assert scanned.values(theta, "real") == pytest.approx(values, rel=1e-13)
    if off is None:
        wanted = F.all(**recording)["F"][None, :]
    else:
        wanted, slopes = F.prepare(**recording, **off).jacobian(theta, "real")
        size = np.abs(slopes).max(axis=2, keepdims=True)
        assert jac / size == pytest.approx(slopes / size, abs=1e-12)
    assert values == pytest.approx(wanted, rel=1e-12, abs=1e-13)


def test_tiles_without_a_turn_take_one_exponential_less_and_give_the_same() -> None:
    """A slow swing turns in two of eight tiles. An exponent beside 1 makes the model march."""
    F, t = build(models.modified_dahl), np.arange(2000) * 1e-3
    recording = {"t": t, "z": 3 * np.sin(4 * t)}
    tiles, marched = F.prepare(**recording), F.prepare(**recording, b=np.nextafter(1.0, 2.0))
    theta = tiles.p[F.free]
    for found, wanted in zip(tiles.jacobian(theta, "real"), marched.jacobian(theta, "real"), strict=True):
        size = np.abs(wanted).max(axis=-1, keepdims=True)
        assert found / size == pytest.approx(wanted / size, abs=1e-12)
    assert tiles.values(theta, "real") == pytest.approx(marched.values(theta, "real"), rel=1e-12, abs=1e-13)
    source = emit(build_program(models.modified_dahl, ("rho",)), ("values",), "", ("real",))
    code = next(k for k in source.kernels if k.name == "values_real").code
    lean, full = code.split("mg_turns == 0U")[1].split("} else {")[:2]
    assert (lean.count("mg_exp("), full.count("mg_exp(")) == (1, 2)


@pytest.mark.parametrize("by", [1, sp.I])
def test_normal_equations_of_many_columns_are_those_of_the_jacobian(by: Any) -> None:
    """Σ a_k/(1 + k x), real, and with j x in the place of x: 30 columns, whose products are loops."""
    x = Input("x", "1")
    a = [Parameter(f"a_{k}", "1", 0.5 + k % 3) for k in range(30)]
    total = sum(q * q / (1 + by * k * x) for k, q in enumerate(a, 1))
    model = Model("many", (x,), tuple(a), (Equation("Z", total, "1"),), ("Z",))
    (F,) = build_many([(model, tuple(q.name for q in a))], ("jacobian", "normal"))
    at, measure = np.linspace(0.1, 2, 37), "real" if by == 1 else "complex"
    ready, theta = F.prepare(x=at), [q.default for q in a]
    value, jac = ready.jacobian(theta, measure)
    data, weight = np.cos(at) * np.ones_like(value), 1 + at * np.ones_like(value)
    whole, g, A = ready.normal(theta, measure, ready.pad(data), ready.pad(weight))
    e, J = weight * (value - data), (weight[:, None] * jac).swapaxes(1, 2).reshape(-1, len(a))
    assert whole == pytest.approx(np.sum(e**2), rel=1e-12)
    assert g == pytest.approx(J.T @ e.ravel(), rel=1e-10)
    assert pytest.approx(J.T @ J, rel=1e-12) == A


def test_a_piecewise_within_a_condition() -> None:
    """x beyond a gap that is g on one side of y = 0 and h on the other; x where its sign is not that of y."""
    x, y = Input("x", "1"), Input("y", "1")
    g, h = Parameter("g", "1"), Parameter("h", "1")
    X, Y, gap = x.symbol, y.symbol, Piecewise((g.symbol, y.symbol > 0), (h.symbol, True))
    laws = (
        Equation("beyond", Piecewise((X, abs(X) > gap), (0, True)), "1"),
        Equation("alone", Piecewise((X, sp.Xor(X > 0, Y > 0)), (0, True)), "1"),
    )
    f = build(Model("gap", (x, y), (g, h), laws, ("beyond", "alone")))
    for at in product((-2.0, 0.5, 3.0), (-1.0, 1.0), (1.0, 4.0), (1.0, 4.0)):
        a, b, low, high = at
        beyond = a if abs(a) > (low if b > 0 else high) else 0.0
        alone = a if (a > 0) != (b > 0) else 0.0
        assert np.ravel(f(x=a, y=b, g=low, h=high)).tolist() == [beyond, alone]
