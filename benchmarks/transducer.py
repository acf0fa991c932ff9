"""Model M1, eq. 1–12 of the GMM paper, as each contestant would write it; eddy currents by their series.

The expression is the model's own, in its textbook form: what a user of each tool would start from.
"""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp

import modelgen.models as models
from benchmarks.compilers import casadi_call, casadi_compiled, compiled, symforce_cpp
from benchmarks.timing import Run
from modelgen.codegen import Function, build

SIX = ("mu33_re", "mu33_im", "S33_re", "S33_im", "d33_re", "d33_im")
LOW = np.array([2.0, -0.5, 1e-11, -1e-12, 5e-10, -5e-10])
HIGH = np.array([3.0, 0.0, 1e-10, 0.0, 5e-9, 0.0])
HAND = Path(__file__).parent / "hand.c"


@dataclass(frozen=True)
class Setting:
    """Frequencies (n,) [Hz], data (n,) [ohm] and parameter sets (m, 6)."""

    f: Any
    data: Any
    sets: Any


def setting(points: int = 401, sets: int = 1000) -> Setting:
    """Sets around the resonance's parameters, uniform in the box that the paper searches."""
    rng = np.random.default_rng(0)
    thetas = LOW + (HIGH - LOW) * rng.uniform(size=(sets, 6))
    f = np.linspace(1000.0, 2200.0, points)
    clean = function()(f=f)
    return Setting(f, clean * (1 + 0.01 * rng.normal(size=points)), thetas)


def function() -> Function:
    """Ours, with six unknowns."""
    return build(models.magnetostrictive_transducer.variant(eddy="series"), SIX)


@cache
def textbook() -> tuple[tuple[sp.Symbol, ...], sp.Expr]:
    """Symbols (f, six parameters) and Z of them, equation put into equation as they stand in the paper."""
    model = models.magnetostrictive_transducer.variant(eddy="series")
    env: dict[sp.Symbol, Any] = {}
    for p in model.parameters:
        if hasattr(p, "re"):
            env[p.symbol] = p.re.symbol + sp.I * p.im.symbol
    for p in model.scalar_parameters:
        if p.name not in SIX:
            env[p.symbol] = sp.Float(p.default)
    for s in model.statements:
        env[s.symbol] = sp.sympify(s.expr).xreplace(env)
        if s.name == "Z":
            break
    names = {p.name: p.symbol for p in model.scalar_parameters}
    return (model.inputs[0].symbol, *(names[n] for n in SIX)), env[s.symbol]


class Pair:
    """A complex number of two expressions, for tools that know real ones alone."""

    def __init__(self, re: Any, im: Any = 0.0) -> None:
        self.re, self.im = re, im

    def __add__(self, other: Any) -> Pair:
        o = as_pair(other)
        return Pair(self.re + o.re, self.im + o.im)

    def __mul__(self, other: Any) -> Pair:
        o = as_pair(other)
        return Pair(self.re * o.re - self.im * o.im, self.re * o.im + self.im * o.re)

    def __pow__(self, n: int) -> Pair:
        if n < 0:
            size = self.re * self.re + self.im * self.im
            return Pair(self.re / size, -self.im / size) ** -n
        return self if n == 1 else self * self ** (n - 1)

    def __neg__(self) -> Pair:
        return Pair(-self.re, -self.im)

    def __sub__(self, other: Any) -> Pair:
        return self + -as_pair(other)

    def __rsub__(self, other: Any) -> Pair:
        return as_pair(other) + -self

    def __truediv__(self, other: Any) -> Pair:
        return self * as_pair(other) ** -1

    def __rtruediv__(self, other: Any) -> Pair:
        return as_pair(other) * self**-1

    __radd__ = __add__
    __rmul__ = __mul__


def as_pair(x: Any) -> Pair:
    if isinstance(x, Pair):
        return x
    return Pair(x.real, x.imag) if isinstance(x, complex) else Pair(x)


def real_form(symbols: list[Any]) -> tuple[Any, Any]:
    """Re Z and Im Z of another tool's real symbols (f, six parameters)."""
    names, Z = textbook()
    j = sp.Symbol("j")
    pair = sp.lambdify((j, *names), Z.subs(sp.I, j), "math", cse=True)
    found = as_pair(pair(Pair(0.0, 1.0), *(Pair(s) for s in symbols)))
    return found.re, found.im


# -- hand-written C


@cache
def hand() -> Any:
    """benchmarks/hand.c, compiled as our kernels are."""
    return ctypes.CDLL(str(compiled(HAND.read_text(), tempfile.mkdtemp())))


def address(a: Any) -> Any:
    return ctypes.c_void_p(a.ctypes.data)


# -- the batch objective Σ |Z − data|² of each set


def batch_ours(s: Setting) -> Run:
    F = function()
    ready = F.prepare(f=s.f)
    data = ready.pad(np.stack([s.data.real, s.data.imag]))
    weight = ready.pad(np.ones((2, len(s.f))))
    return lambda: ready.sumsq(s.sets, "complex", data, weight)


def batch_hand(s: Setting) -> Run:
    n, m = len(s.f), len(s.sets)
    re, im = (np.ascontiguousarray(x) for x in (s.data.real, s.data.imag))
    staged, out, f = np.empty((8, n)), np.empty(m), np.ascontiguousarray(s.f)
    hand().m1_prepare(ctypes.c_size_t(n), address(f), address(staged))

    def run() -> Any:
        sizes = ctypes.c_size_t(m), ctypes.c_size_t(n)
        hand().m1_batch(*sizes, address(staged), address(re), address(im), address(s.sets), address(out))
        return out

    return run


def batch_numpy(s: Setting, cse: bool) -> Run:
    names, Z = textbook()
    call = sp.lambdify(names, Z, "numpy", cse=cse)
    columns = [c[:, None] for c in s.sets.T]

    def run() -> Any:
        return (np.abs(call(s.f, *columns) - s.data) ** 2).sum(axis=1)

    return run


def batch_jax(s: Setting) -> Run:
    import jax

    jax.config.update("jax_enable_x64", True)
    import jax.numpy as jnp

    names, Z = textbook()
    call = sp.lambdify(names, Z, "jax", cse=False)
    f, data, sets = jnp.array(s.f), jnp.array(s.data), jnp.array(s.sets)

    def objective(theta: Any) -> Any:
        e = call(f, *theta) - data
        return (e.real**2 + e.imag**2).sum()

    batch = jax.jit(jax.vmap(objective))
    return lambda: np.asarray(batch(sets).block_until_ready())


def batch_numba(s: Setting) -> Run:
    import numba

    names, Z = textbook()
    call = numba.njit(sp.lambdify(names, Z, "math", cse=True), fastmath=True, error_model="numpy")

    @numba.njit(fastmath=True, error_model="numpy")
    def batch(f: Any, data: Any, sets: Any) -> Any:
        out = np.empty(len(sets))
        for k in range(len(sets)):
            a, b, c, d, g, h = sets[k]
            total = 0.0
            for i in range(len(f)):
                e = call(f[i], a, b, c, d, g, h) - data[i]
                total += e.real**2 + e.imag**2
            out[k] = total
        return out

    return lambda: batch(s.f, s.data, s.sets)


def casadi_objective(s: Setting) -> Any:
    import casadi as ca

    v = ca.SX.sym("v", 9)
    re, im = real_form([v[k] for k in range(7)])
    one = ca.Function("one", [v], [(re - v[7]) ** 2 + (im - v[8]) ** 2])
    theta = ca.MX.sym("theta", 6)
    rows = ca.vertcat(ca.DM(s.f).T, ca.repmat(theta, 1, len(s.f)), ca.DM(s.data.real).T, ca.DM(s.data.imag).T)
    return ca.Function("m1_objective", [theta], [ca.sum2(one.map(len(s.f))(rows))])


def batch_casadi(s: Setting, generated: bool) -> Run:
    f = casadi_objective(s)
    f = casadi_compiled(f) if generated else f
    return casadi_call(f.map(len(s.sets)), [s.sets.copy()], np.empty(len(s.sets)))


def batch_symforce(s: Setting) -> Run:
    body = symforce_cpp(lambda v: real_form(v), 7)
    code = body + (
        "void batch(size_t m, size_t n, const double *restrict f, const double *restrict re, "
        "const double *restrict im, const double *restrict t, double *restrict out) {"
        "for (size_t k = 0; k < m; ++k) { double s = 0; for (size_t i = 0; i < n; ++i) { double o[2];"
        "const double x[7] = { f[i], t[6*k], t[6*k+1], t[6*k+2], t[6*k+3], t[6*k+4], t[6*k+5] };"
        "call(x, o); s += (o[0]-re[i])*(o[0]-re[i]) + (o[1]-im[i])*(o[1]-im[i]); } out[k] = s; } }"
    )
    call = ctypes.CDLL(str(compiled(code, tempfile.mkdtemp(), "-ffast-math", cpp=True))).batch
    re, im = (np.ascontiguousarray(x) for x in (s.data.real, s.data.imag))
    f, out = np.ascontiguousarray(s.f), np.empty(len(s.sets))

    def run() -> Any:
        sizes = ctypes.c_size_t(len(s.sets)), ctypes.c_size_t(len(s.f))
        call(*sizes, address(f), address(re), address(im), address(s.sets), address(out))
        return out

    return run


BATCH: dict[str, Callable[[Setting], Run]] = {
    "modelgen": batch_ours,
    "C by hand": batch_hand,
    "JAX jit(vmap)": batch_jax,
    "symforce, -ffast-math": batch_symforce,
    "numba": batch_numba,
    "CasADi codegen, map": lambda s: batch_casadi(s, True),
    "sympy lambdify, cse": lambda s: batch_numpy(s, True),
    "numpy as written": lambda s: batch_numpy(s, False),
    "CasADi VM, map": lambda s: batch_casadi(s, False),
}
