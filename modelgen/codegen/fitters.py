"""The fitters in C (templates/fit.h.j2, fit.c.j2, noise.c.j2), compiled once and called by address."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any

import numpy as np

from modelgen.codegen.compiler import FAST, compile_library
from modelgen.codegen.emit import environment

Array = np.ndarray[Any, np.dtype[Any]]
RUNNING, CONVERGED, BUDGET, STALLED, NOT_FINITE = range(5)
_SIZE, _DOUBLE, _POINTER, _INT = ctypes.c_size_t, ctypes.c_double, ctypes.c_void_p, ctypes.c_int


class Recording(ctypes.Structure):
    """`mg_recording`."""

    _fields_ = (
        *((n, _POINTER) for n in ("normal", "sumsq")),
        *((n, _SIZE) for n in ("n", "stride", "columns", "parameters")),
        *((n, _POINTER) for n in ("work", "p", "data", "weight", "column", "place", "held", "local")),
    )


class Noise(ctypes.Structure):
    """`mg_noise`."""

    _fields_ = (
        *((n, _POINTER) for n in ("values", "jacobian", "work")),
        *((n, _SIZE) for n in ("outputs", "channels", "columns", "parameters")),
        *((n, _POINTER) for n in ("row", "column")),
        ("period", _DOUBLE),
        *((n, _POINTER) for n in ("re", "im")),
        ("shared", _SIZE),
        *((n, _POINTER) for n in ("modes", "less", "undo")),
        ("order", _SIZE),
        ("ar", _POINTER),
        ("bands", _SIZE),
        *((n, _POINTER) for n in ("band", "reach", "share", "block")),
    )


class LM(ctypes.Structure):
    """`mg_lm`."""

    _fields_ = (
        *((n, _SIZE) for n in ("size", "max_iter", "iteration", "evaluations")),
        *((n, _POINTER) for n in ("lower", "upper", "width")),
        *((n, _DOUBLE) for n in ("tol", "damping")),
        *((n, _INT) for n in ("beyond", "leg", "arriving", "kept_status")),
        ("until", _SIZE),
        *((n, _DOUBLE) for n in ("f", "mu", "nu", "floor", "predicted", "kept_f")),
        *((n, _POINTER) for n in (
            "theta", "trial", "g", "A", "g_new", "A_new", "D", "step", "way", "low", "high", "kept", "M",
            "held",
        )),
    )  # fmt: skip


class Swarm(ctypes.Structure):
    """`mg_swarm`."""

    _fields_ = (
        *((n, _SIZE) for n in ("particles", "size")),
        *((n, _POINTER) for n in ("low", "high", "wide")),
        *((n, _DOUBLE) for n in ("w", "c1", "c2", "v_max")),
        *((n, _INT) for n in ("walls", "ring")),
        *((n, _POINTER) for n in ("x", "v", "own", "value", "theta", "trial", "stream")),
    )


_SIGNATURES: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "mg_fit_normal": (_DOUBLE, (_POINTER, _SIZE, _SIZE, _POINTER, _POINTER, _POINTER)),
    "mg_fit_values": (None, (_POINTER, _SIZE, _SIZE, _SIZE, _POINTER, _POINTER)),
    "mg_noise_residuals": (None, (_POINTER, *[_SIZE] * 3, _POINTER, _SIZE, _POINTER)),
    "mg_noise_columns": (None, (_POINTER, *[_SIZE] * 3, _POINTER, _POINTER, _SIZE, _SIZE, _POINTER)),
    "mg_lm_place": (None, (_POINTER, _SIZE, _POINTER, _POINTER, _POINTER)),
    "mg_lm_begin": (_INT, (_POINTER, _DOUBLE)),
    "mg_lm_propose": (_INT, (_POINTER,)),
    "mg_lm_judge": (_INT, (_POINTER, _DOUBLE)),
    "mg_lm_run": (_INT, (_POINTER, _POINTER, _SIZE, _POINTER)),
    "mg_swarm_place": (None, (_POINTER, _SIZE, _SIZE, _POINTER, _POINTER)),
    "mg_swarm_begin": (None, (_POINTER, ctypes.c_uint64, _POINTER)),
    "mg_swarm_judge": (None, (_POINTER,)),
    "mg_swarm_move": (None, (_POINTER,)),
    "mg_swarm_extent": (_DOUBLE, (_POINTER,)),
    "mg_swarm_run": (_SIZE, (_POINTER, _POINTER, _SIZE, _SIZE, _DOUBLE, _POINTER)),
}


def sources(name: str = "fit") -> dict[str, str]:
    """The C of the fitters (or of "noise", which never leaves the host): file name → text."""
    env = environment()
    return {f"modelgen_{name}.{end}": env.get_template(f"{name}.{end}.j2").render() for end in ("h", "c")}


@cache
def library() -> Any:
    """The compiled fitters. Raises ToolError when there is no compiler."""
    handle = ctypes.CDLL(str(compile_library(sources() | sources("noise"), FAST)))
    for name, (result, arguments) in _SIGNATURES.items():
        function = getattr(handle, name)
        function.restype, function.argtypes = result, arguments
    return handle


def address(array: Array) -> int:
    return int(array.ctypes.data)


class Descent:
    """One Levenberg–Marquardt run, and the memory that it works in.

    Ask `propose` for a point until the status is no longer RUNNING; evaluate `trial` and tell `judge` the
    value, gradient Jᵀr and JᵀJ there. `theta` is the best point so far, with `value`. beyond: see fit.h.j2.
    """

    def __init__(
        self, lower: Array, upper: Array, width: Array, max_iter: int, tol: float, damping: float,
        beyond: bool = False,
    ) -> None:  # fmt: skip
        size = len(lower)
        self.c = library()
        self.theta, self._doubles = np.zeros(size), np.zeros(3 * size * size + 11 * size)
        self._ints = np.zeros(2 * size, dtype=np.intc)
        self._box = tuple(np.array(a, dtype=float) for a in (lower, upper, width))
        self.s = LM(
            max_iter=max_iter, tol=tol, damping=damping, beyond=int(beyond),
            **{n: address(a) for n, a in zip(("lower", "upper", "width"), self._box, strict=True)},
        )  # fmt: skip
        self.at = ctypes.addressof(self.s)
        self.c.mg_lm_place(self.at, size, *(address(a) for a in (self.theta, self._doubles, self._ints)))

    def _view(self, name: str, *shape: int) -> Array:
        start = (getattr(self.s, name) - address(self._doubles)) // 8
        return self._doubles[start : start + int(np.prod(shape))].reshape(shape)

    @property
    def value(self) -> float:
        return float(self.s.f)

    @property
    def gradient(self) -> Array:
        return self._view("g", len(self.theta))

    @property
    def matrix(self) -> Array:
        return self._view("A", len(self.theta), len(self.theta))

    @property
    def trial(self) -> Array:
        return self._view("trial", len(self.theta))

    def begin(self, theta: Array, value: float, gradient: Array, matrix: Array) -> int:
        """Start at θ with what was found there; the status."""
        self.theta[:], self.gradient[:], self.matrix[:] = theta, gradient, matrix
        return int(self.c.mg_lm_begin(self.at, value))

    def propose(self) -> int:
        """Put the next point into `trial`; the status."""
        return int(self.c.mg_lm_propose(self.at))

    def judge(self, value: float, gradient: Array, matrix: Array) -> int:
        """Take what was found at `trial`; the status."""
        size = len(self.theta)
        self._view("g_new", size)[:], self._view("A_new", size, size)[:] = gradient, matrix
        return int(self.c.mg_lm_judge(self.at, value))

    def run(self, theta: Array, recordings: Any, history: Array) -> int:
        """A whole run from θ on an array of `Recording`; the status."""
        self.theta[:] = theta
        return int(self.c.mg_lm_run(self.at, ctypes.addressof(recordings), len(recordings), address(history)))

    def stop(self) -> None:
        """End a run that goes on in another thread, after its iteration, at the best point so far."""
        self.s.beyond = self.s.max_iter = self.s.until = 0


class Flock:
    """A particle swarm in the unit cube, mapped to the box [low, high]: by the logarithm where `wide`."""

    def __init__(
        self, particles: int, low: Array, high: Array, wide: Array,
        coefficients: tuple[float, float, float, float], walls: int, ring: bool,
    ) -> None:  # fmt: skip
        size = len(low)
        self.c = library()
        self._doubles = np.zeros(particles * (4 * size + 2))
        self._streams = np.zeros(particles, dtype=np.uint64)
        self.low, self.high = np.array(low, dtype=float), np.array(high, dtype=float)
        self._box = (self.low, self.high, np.array(wide, dtype=np.intc))
        w, c1, c2, v_max = coefficients
        self.s = Swarm(
            w=w, c1=c1, c2=c2, v_max=v_max, walls=walls, ring=int(ring),
            **{n: address(a) for n, a in zip(("low", "high", "wide"), self._box, strict=True)},
        )  # fmt: skip
        self.at = ctypes.addressof(self.s)
        self.c.mg_swarm_place(self.at, particles, size, address(self._doubles), address(self._streams))
        views, start = [], 0
        for shape in (*[(particles, size)] * 4, (particles,), (particles,)):
            end = start + int(np.prod(shape))
            views.append(self._doubles[start:end].reshape(shape))
            start = end
        self.x, self.v, self.own, self.theta, self.value, self.trial = views

    def begin(self, seed: int, start: Array | None) -> None:
        """Random positions and speeds; the first particle sits at `start` (p,), in the unit cube."""
        self.c.mg_swarm_begin(self.at, seed, None if start is None else address(start))

    def judge(self, values: Array) -> None:
        """Take what was found at `theta`."""
        self.trial[:] = values
        self.c.mg_swarm_judge(self.at)

    def move(self) -> None:
        """Fly: new `x`, `theta`."""
        self.c.mg_swarm_move(self.at)

    @property
    def extent(self) -> float:
        """Of the swarm's best points along any axis, or its greatest speed."""
        return float(self.c.mg_swarm_extent(self.at))

    def run(self, recordings: Any, iterations: int, tol: float) -> Array:
        """Up to so many moves on an array of `Recording`, till the extent is below `tol`; the best values."""
        history = np.zeros(iterations)
        table = (ctypes.addressof(recordings), len(recordings))
        done = self.c.mg_swarm_run(self.at, *table, iterations, tol, address(history))
        return history[:done]
