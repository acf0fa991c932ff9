"""Model M2, the modified Dahl model with b = 1: a simulation, and normal equations with 4 sensitivities."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import modelgen.models as models
from benchmarks.compilers import casadi_call, casadi_compiled
from benchmarks.timing import Run
from benchmarks.transducer import address, hand
from modelgen.codegen import Function, build

FOUR = ("k_D", "c_D", "h_D", "rho")
THETA = np.array([0.6797, 0.1374, 0.2309, 1.44, -0.5])  # with r(0)


@dataclass(frozen=True)
class Motion:
    """A displacement z [mm], its rate, its steps and their signs; a force to compare with."""

    t: Any
    z: Any
    v: Any
    step: Any
    sign: Any
    data: Any


def motion(n: int = 40_000) -> Motion:
    """Two tones, which never turn inside of a step: that is what all but ours leave out."""
    t = np.arange(n) * 1e-3
    z = 2.0 * np.sin(9.0 * t) + 0.7 * np.sin(31.0 * t)
    step = np.diff(z, prepend=z[0])
    v = np.gradient(z, t)
    return Motion(t, z, v, np.abs(step), np.where(step >= 0, 1.0, -1.0), 0.1 + 0.7 * z + 0.14 * v)


def function() -> Function:
    return build(models.modified_dahl, FOUR)


def prepared(m: Motion) -> tuple[Function, Any, Any]:
    F = function()
    before = np.concatenate([m.z[:1], m.z[:-1]])
    given = {"t": m.t, "z": m.z, "z_prev": before, "z_turn": before, "v": m.v, "a": 0 * m.z}
    ready = F.prepare(**given, F_0=0.0, r_0=THETA[4], **dict(zip(FOUR, THETA, strict=False)))
    return F, ready, np.ascontiguousarray(ready.p)


def call(F: Function, kernel: str, answer: Any, keep: Any, args: list[Any]) -> Run:
    addresses = [a.ctypes.data if isinstance(a, np.ndarray) else a for a in args]
    f = F.code.addresses[kernel]

    def run(held: Any = (keep, args)) -> Any:
        f(*addresses)
        return answer

    return run


def simulate_ours(m: Motion) -> Run:
    F, ready, p = prepared(m)
    out = np.empty(ready.stride)
    return call(F, "values_real", out[: ready.n], ready, [ready.n, ready.stride, ready.work, p, out])


def simulate_hand(m: Motion) -> Run:
    F, n = np.empty(len(m.z)), ctypes.c_size_t(len(m.z))

    def run() -> Any:
        hand().m2_values(n, *(address(a) for a in (m.z, m.v, m.step, m.sign, THETA, F)))
        return F

    return run


def jax_force(scan: str) -> Callable[..., Any]:
    import jax

    jax.config.update("jax_enable_x64", True)
    import jax.numpy as jnp

    def force(theta: Any, z: Any, v: Any, step: Any, sign: Any) -> Any:
        a = jnp.exp(-theta[3] * step)
        b = sign * (1 - a)
        if scan == "lax.scan":
            r = jax.lax.scan(lambda r, ab: (ab[0] * r + ab[1],) * 2, theta[4], (a, b))[1]
        else:
            A, B = jax.lax.associative_scan(lambda p, q: (q[0] * p[0], q[0] * p[1] + q[1]), (a, b))
            r = A * theta[4] + B
        return theta[0] * z + theta[1] * v + theta[2] * r

    return force


def simulate_jax(m: Motion, scan: str) -> Run:
    import jax

    made = jax.jit(jax_force(scan))
    args = [jax.numpy.array(x) for x in (THETA, m.z, m.v, m.step, m.sign)]
    return lambda: np.asarray(made(*args).block_until_ready())


def normal_jax(m: Motion, scan: str) -> Run:
    import jax

    force = jax_force(scan)

    def normal(theta: Any, z: Any, v: Any, step: Any, sign: Any, data: Any) -> Any:
        def residual(four: Any) -> Any:
            return force(jax.numpy.concatenate([four, theta[4:]]), z, v, step, sign) - data

        e, J = residual(theta[:4]), jax.jacfwd(residual)(theta[:4])
        A = J.T @ J
        return jax.numpy.concatenate([A[np.triu_indices(4)], J.T @ e, (e @ e)[None]])

    made = jax.jit(normal)
    args = [jax.numpy.array(x) for x in (THETA, m.z, m.v, m.step, m.sign, m.data)]
    return lambda: np.asarray(made(*args).block_until_ready())


def numba_force(m: Motion) -> Run:
    import numba

    @numba.njit(fastmath=True)
    def loop(z: Any, v: Any, step: Any, sign: Any, p: Any, out: Any) -> None:
        r = p[4]
        for i in range(len(z)):
            r = sign[i] + (r - sign[i]) * np.exp(-p[3] * step[i])
            out[i] = p[0] * z[i] + p[1] * v[i] + p[2] * r

    out = np.empty(len(m.z))

    def run() -> Any:
        loop(m.z, m.v, m.step, m.sign, THETA, out)
        return out

    return run


def casadi_step(sensitivities: bool) -> Any:
    """One sample: state (and its slope by ρ), inputs → new state and F (or what it adds to the sums)."""
    import casadi as ca

    x, u, p = ca.SX.sym("x", 2 if sensitivities else 1), ca.SX.sym("u", 5), ca.SX.sym("p", 4)
    r = u[3] + (x[0] - u[3]) * ca.exp(-p[3] * u[2])
    F = p[0] * u[0] + p[1] * u[1] + p[2] * r
    if not sensitivities:
        return ca.Function("m2", [x, u, p], [r, F])
    slope = ca.jacobian(r, p[3]) + ca.jacobian(r, x[0]) * x[1]
    row = ca.vertcat(u[0], u[1], r, p[2] * slope, F - u[4])
    terms = [row[i] * row[j] for i in range(4) for j in range(i, 4)] + [row[i] * row[4] for i in range(5)]
    return ca.Function("m2", [x, u, p], [ca.vertcat(r, slope), ca.vertcat(*terms)])


def casadi(m: Motion, sensitivities: bool) -> Run:
    import casadi as ca

    many = casadi_step(sensitivities).mapaccum(len(m.z))
    x, U, p = ca.MX.sym("x", 2 if sensitivities else 1), ca.MX.sym("U", 5, len(m.z)), ca.MX.sym("p", 4)
    end = many(x, U, ca.repmat(p, 1, len(m.z)))[1]
    total = ca.Function("total", [x, U, p], [ca.sum2(end) if sensitivities else end])
    inputs = np.ascontiguousarray(np.stack([m.z, m.v, m.step, m.sign, m.data], axis=1))
    start = np.array([THETA[4], 0.0][: 2 if sensitivities else 1])
    out = np.empty(15 if sensitivities else len(m.z))
    return casadi_call(casadi_compiled(total), [start, inputs, THETA[:4].copy()], out)


def solve_ivp(m: Motion) -> Run:
    """dr/dz = ρ (1 − r sign(dz)), by an adaptive solver through the recorded motion."""
    from scipy.integrate import solve_ivp as solve

    def rate(t: float, r: Any) -> Any:
        v = np.interp(t, m.t, m.v)
        return THETA[3] * v * (1 - r * np.sign(v))

    def run() -> Any:
        r = solve(rate, (m.t[0], m.t[-1]), [THETA[4]], "LSODA", m.t, rtol=1e-6, atol=1e-8).y[0]
        return THETA[0] * m.z + THETA[1] * m.v + THETA[2] * r

    return run


def normal_ours(m: Motion) -> Run:
    F, ready, p = prepared(m)
    data, weight, out = ready.pad(m.data[None]), ready.pad(np.ones((1, len(m.z)))), np.empty(15)
    return call(F, "normal_real", out, ready, [ready.n, ready.stride, ready.work, p, data, weight, out])


def normal_hand(m: Motion) -> Run:
    out, n = np.empty(15), ctypes.c_size_t(len(m.z))

    def run() -> Any:
        hand().m2_normal(n, *(address(a) for a in (m.z, m.v, m.step, m.sign, THETA, m.data, out)))
        return out

    return run


SIMULATE: dict[str, Callable[[Motion], Run]] = {
    "modelgen": simulate_ours,
    "C by hand": simulate_hand,
    "numba": numba_force,
    "JAX lax.scan": lambda m: simulate_jax(m, "lax.scan"),
    "JAX associative_scan": lambda m: simulate_jax(m, "associative_scan"),
    "CasADi codegen, mapaccum": lambda m: casadi(m, False),
    "scipy LSODA": solve_ivp,
}
NORMAL: dict[str, Callable[[Motion], Run]] = {
    "modelgen": normal_ours,
    "C by hand": normal_hand,
    "JAX lax.scan": lambda m: normal_jax(m, "lax.scan"),
    "JAX associative_scan": lambda m: normal_jax(m, "associative_scan"),
    "CasADi codegen, mapaccum": lambda m: casadi(m, True),
}
