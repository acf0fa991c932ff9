"""Friction and lost motion on a path that holds its reversals: each operator is exact between them."""

from __future__ import annotations

from functools import lru_cache
from itertools import accumulate, pairwise

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

Array = npt.NDArray[np.float64]


def branches(path: Array) -> npt.NDArray[np.intp]:
    """Where the direction of a path changes, with its ends. Rests belong to the branch before."""
    d = np.sign(np.diff(path))
    moving = np.flatnonzero(d)
    turn = moving[1:][d[moving[1:]] != d[moving[:-1]]]
    return np.concatenate([[0], turn, [len(path) - 1]])


def dahl(path: Array, rho: float, r0: float = 0.0) -> Array:
    """Dahl's state, dr = ρ(1 - sr) dx with s = sgn dx: 1 - sr = (1 - sr)₀ exp(-ρ|x - x₀|) on each branch."""
    r = np.empty_like(path)
    r[0] = r0
    edge = branches(path)
    for a, b in pairwise(edge):
        s = np.sign(path[b] - path[a])
        r[a + 1 : b + 1] = s - (s - r[a]) * np.exp(-rho * np.abs(path[a + 1 : b + 1] - path[a]))
    return r


@lru_cache(maxsize=64)
def _slip(b: float) -> tuple[Array, Array]:
    """ln u and X along du/dX = -u^b from u = 2, integrated with ln u as the variable's logarithm."""
    lnu = np.linspace(np.log(2), np.log(1e-7), 4000)
    sol = solve_ivp(
        lambda l, x: -np.exp((1 - b) * l), (lnu[0], lnu[-1]), [0.0], t_eval=lnu, rtol=1e-10, atol=1e-12
    )
    return lnu[::-1], sol.y[0][::-1]


def dahl_power(path: Array, rho: float, b: float, r0: float = 0.0) -> Array:
    """Dahl's state with |1 - sr|^b, each branch read off one integrated master curve."""
    lnu, X = _slip(float(b))
    r = np.empty_like(path)
    r[0] = r0
    edge = branches(path)
    for a, e in pairwise(edge):
        s = np.sign(path[e] - path[a])
        u0 = np.log(max(1 - s * r[a], 1e-7))
        along = np.interp(u0, lnu, X) + rho * np.abs(path[a + 1 : e + 1] - path[a])
        r[a + 1 : e + 1] = s * (1 - np.exp(np.interp(along, X[::-1], lnu[::-1])))
    return r


def rate_dahl(v: Array, dt: float, rho: float, level: Array, relax: float) -> Array:
    """Dahl's state with a slip level g(t) and a relaxation rate [1/s]: ṙ = ρ(v - |v| r/g) - relax r.

    Linear in r: each fine step is an exact exponential with its coefficients held at the middle.
    """
    vm = 0.5 * (v[1:] + v[:-1])
    decay = rho * np.abs(vm) * 2 / (level[1:] + level[:-1]) + relax
    gone = np.exp(-decay * dt)
    gain = rho * vm * -np.expm1(-decay * dt) / np.maximum(decay, 1e-300)
    return np.array(
        list(
            accumulate(
                zip(gone.tolist(), gain.tolist(), strict=True), lambda r, c: c[0] * r + c[1], initial=0.0
            )
        )
    )


def play(path: Array, clearance: float) -> Array:
    """Position of a part that follows with a clearance (full width) and stays while it isn't pushed."""
    half = 0.5 * clearance
    out = []
    w = 0.0
    for z in path.tolist():
        if z - w > half:
            w = z - half
        elif w - z > half:
            w = z + half
        out.append(w)
    return np.array(out)


def soft_play(path: Array, clearance: float, softness: float) -> Array:
    """Lost motion of a joint that stiffens gradually: plays whose clearances spread about the mean one."""
    spread = 1 + softness * np.array([-0.9, -0.55, -0.2, 0.2, 0.55, 0.9])
    return np.asarray(np.mean([play(path, clearance * s) for s in spread], axis=0))


def travelled(path: Array) -> Array:
    """Distance covered along a path."""
    return np.concatenate([[0.0], np.cumsum(np.abs(np.diff(path)))])
