"""M1, one parameter set: Z with its Jacobian by six unknowns, and the normal equations in one pass."""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Callable
from typing import Any

import numpy as np
import sympy as sp

from benchmarks.compilers import casadi_call, casadi_compiled, compiled, symforce_cpp
from benchmarks.timing import Run
from benchmarks.transducer import SIX, Setting, address, function, hand, real_form, textbook
from modelgen.codegen import Function
from modelgen.codegen.emit import emit
from modelgen.codegen.function import aligned
from modelgen.codegen.instant import Memory
from modelgen.codegen.machine import machine
from modelgen.codegen.program import build_program
from modelgen.codegen.tiers import Code, Tiers


def ours(s: Setting) -> Run:
    theta, ready = s.sets[0], function().prepare(f=s.f)
    values, jac = ready.jacobian(theta, "complex")
    answer = np.concatenate([values[:, None], jac], axis=1)

    def run() -> Any:
        ready.jacobian(theta, "complex")
        return answer

    return run


def ours_raw(s: Setting) -> Run:
    """The kernel alone, its arrays laid out beforehand, as a fit calls it."""
    F = function()
    ready = F.prepare(f=s.f)
    out, jac, p = aligned(2, ready.stride), aligned(2, 6, ready.stride), ready.p.copy()
    p[F.free] = s.sets[0]
    F.code.call("jacobian_complex", ready.n, ready.stride, ready.work, p, out, jac)
    answer = np.concatenate([out[:, None, : ready.n], jac[:, :, : ready.n]], axis=1)
    kernel = F.code.addresses["jacobian_complex"]
    args = [ready.n, ready.stride, *(a.ctypes.data for a in (ready.work, p, out, jac))]

    def run(keep: Any = (ready, out, jac, p)) -> Any:
        kernel(*args)
        return answer

    return run


def by_hand(s: Setting) -> Run:
    n, theta = len(s.f), np.ascontiguousarray(s.sets[0])
    staged, out, jac, f = np.empty((5, n)), np.empty((2, n)), np.empty((2, 6, n)), np.ascontiguousarray(s.f)
    hand().m1_prepare(ctypes.c_size_t(n), address(f), address(staged))
    args = (ctypes.c_size_t(n), *(address(a) for a in (staged, theta, out, jac)))
    call = hand().m1_jacobian
    call(*args)
    answer = np.concatenate([out[:, None], jac], axis=1)

    def run(keep: Any = (staged, theta, out, jac)) -> Any:
        call(*args)
        return answer

    return run


def derivatives() -> tuple[Any, list[Any]]:
    names, Z = textbook()
    return names, [Z, *(sp.diff(Z, v) for v in names[1:])]


def lambdified(s: Setting) -> Run:
    names, rows = derivatives()
    call = sp.lambdify(names, rows, "numpy", cse=True)

    def run() -> Any:
        z = np.stack(np.broadcast_arrays(*call(s.f, *s.sets[0])))
        return np.stack([z.real, z.imag])

    return run


def differences(s: Setting) -> Run:
    names, Z = textbook()
    call = sp.lambdify(names, Z, "numpy", cse=True)
    theta = s.sets[0]
    steps = 1e-6 * np.maximum(np.abs(theta), 1e-13)

    def run() -> Any:
        columns = [call(s.f, *theta)]
        for k, h in enumerate(steps):
            up, down = theta.copy(), theta.copy()
            up[k] += h
            down[k] -= h
            columns.append((call(s.f, *up) - call(s.f, *down)) / (2 * h))
        z = np.stack(columns)
        return np.stack([z.real, z.imag])

    return run


def jax(s: Setting) -> Run:
    import jax as j

    j.config.update("jax_enable_x64", True)
    import jax.numpy as jnp

    names, Z = textbook()
    call = sp.lambdify(names, Z, "jax", cse=False)
    f, theta = jnp.array(s.f), jnp.array(s.sets[0])

    def both(theta: Any) -> Any:
        z = call(f, *theta)
        return jnp.stack([z.real, z.imag])

    made = j.jit(lambda t: jnp.concatenate([both(t)[..., None], j.jacfwd(both)(t)], axis=-1))
    return lambda: np.asarray(made(theta).block_until_ready()).transpose(0, 2, 1)


def numba(s: Setting) -> Run:
    import numba as nb

    names, rows = derivatives()
    call = nb.njit(sp.lambdify(names, tuple(rows), "math", cse=True), fastmath=True, error_model="numpy")

    @nb.njit(fastmath=True, error_model="numpy")
    def loop(f: Any, t: Any, out: Any) -> None:
        for i in range(len(f)):
            row = call(f[i], t[0], t[1], t[2], t[3], t[4], t[5])
            for k in range(7):
                z = row[k] + 0j
                out[0, k, i] = z.real
                out[1, k, i] = z.imag

    out, theta = np.empty((2, 7, len(s.f))), np.ascontiguousarray(s.sets[0])

    def run() -> Any:
        loop(s.f, theta, out)
        return out

    return run


def casadi(s: Setting, generated: bool) -> Run:
    import casadi as ca

    f, t = ca.SX.sym("f"), ca.SX.sym("t", 6)
    z = ca.vertcat(*real_form([f, *(t[k] for k in range(6))]))
    one = ca.Function("one", [f, t], [ca.horzcat(z, ca.jacobian(z, t))], {"cse": True})
    many = one.map(len(s.f))
    many = casadi_compiled(many) if generated else many
    out = np.empty((len(s.f), 7, 2))  # columns first
    run = casadi_call(many, [s.f.copy(), np.tile(s.sets[0], len(s.f))], out)
    return lambda: run().transpose(2, 1, 0)


def symforce(s: Setting) -> Run:
    def rows(v: list[Any]) -> list[Any]:
        parts = real_form(v)
        return [x for p in parts for x in (p, *(p.diff(u) for u in v[1:]))]

    code = symforce_cpp(rows, 7) + (
        "void all(size_t n, const double *restrict f, const double *restrict t, double *restrict out) {"
        "for (size_t i = 0; i < n; ++i) { double o[14];"
        "const double x[7] = {f[i], t[0], t[1], t[2], t[3], t[4], t[5]};"
        "call(x, o); for (size_t k = 0; k < 14; ++k) out[k * n + i] = o[k]; } }"
    )
    call = ctypes.CDLL(str(compiled(code, tempfile.mkdtemp(), "-ffast-math", cpp=True)))["all"]
    out, theta, f = np.empty((2, 7, len(s.f))), np.ascontiguousarray(s.sets[0]), np.ascontiguousarray(s.f)

    def run() -> Any:
        call(ctypes.c_size_t(len(f)), address(f), address(theta), address(out))
        return out

    return run


def unseen(taped: bool) -> Callable[[Setting], Run]:
    """A model that no compiler has seen: its C compiled in memory, or its loops as tapes."""
    F = function()
    source = emit(build_program(F.model, SIX), ("normal",), measures=("complex",), taped=taped)
    code = Code(source, Memory(source.source, machine()))
    return lambda s: fused(s, Function(F.model, F.wrt, F.free, Tiers(lambda: code)))


def fused(s: Setting, of: Function | None = None) -> Run:
    F, theta = of or function(), s.sets[0]
    ready = F.prepare(f=s.f)
    data, weight = ready.pad(np.stack([s.data.real, s.data.imag])), ready.pad(np.ones((2, len(s.f))))
    p, flat = ready.p.copy(), np.empty(len(SIX) * (len(SIX) + 1) // 2 + len(SIX) + 1)
    p[F.free] = theta
    kernel = F.code.addresses["normal_complex"]
    args = [ready.n, ready.stride, *(a.ctypes.data for a in (ready.work, p, data, weight, flat))]

    def run(keep: Any = (ready, data, weight, p)) -> Any:
        kernel(*args)
        return flat

    return run


def matrices(s: Setting) -> Run:
    """What there is to do without a fused kernel: our own Jacobian, then products by numpy's BLAS."""
    F, theta = function(), s.sets[0]
    ready = F.prepare(f=s.f)
    y = np.stack([s.data.real, s.data.imag])

    def run() -> Any:
        values, jac = ready.jacobian(theta, "complex")
        e, J = (values - y).ravel(), jac.transpose(0, 2, 1).reshape(-1, 6)
        A = J.T @ J
        return np.concatenate([A[np.triu_indices(6)], J.T @ e, [e @ e]])

    return run


JACOBIAN: dict[str, Callable[[Setting], Run]] = {
    "modelgen": ours_raw,
    "modelgen, from Python": ours,
    "C by hand": by_hand,
    "numba": numba,
    "symforce, -ffast-math": symforce,
    "CasADi codegen, map": lambda s: casadi(s, True),
    "CasADi VM, map": lambda s: casadi(s, False),
    "JAX jit(jacfwd)": jax,
    "sympy lambdify, cse": lambdified,
    "numpy, differences": differences,
}
FUSED: dict[str, Callable[[Setting], Run]] = {
    "modelgen": fused,
    "modelgen, as a tape": lambda s: unseen(True)(s),
    "modelgen, compiled in memory": lambda s: unseen(False)(s),
    "our Jacobian, then numpy": matrices,
}
