"""How near kernels come to what the machine can do: operations, divisions and memory against measured
limits."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np

from modelgen.codegen.compiler import compile_library
from modelgen.codegen.emit import templates_folder
from modelgen.codegen.function import Function, aligned
from modelgen.codegen.loops import Kernel
from modelgen.language import Implicit, Model

FUNCTION = 24
"""Operations that stand for a function: what mg_exp takes."""
SAMPLES, SETS = 400, 4
LONG = 1024  # numbers a round in templates/machine.c
WIDE = 96
PATIENCE = 1e-3  # seconds a kernel is measured
ROUNDS = 2


@dataclass(frozen=True)
class Machine:
    """Nanoseconds of one addition or multiplication, one division, one number loaded or stored; one core."""

    arithmetic: float
    division: float
    memory: float


@dataclass(frozen=True)
class Roof:
    """A kernel's cost of one point [ns], what limits it on this machine, and that limit (None: not known)."""

    kernel: str
    operations: int
    reached: float
    limit: float | None
    by: str

    @property
    def share(self) -> float | None:
        """Of the limit that is reached."""
        return None if self.limit is None else self.limit / self.reached


def fastest(call: Callable[[], object], patience: float = PATIENCE) -> float:
    """Seconds of one call, the least seen in about `patience` seconds and seven calls."""
    call()
    start = last = time.perf_counter()
    seen: list[float] = []
    while last - start < patience or len(seen) < 7:
        call()
        now = time.perf_counter()
        seen.append(now - last)
        last = now
    return min(seen)


@cache
def machine() -> Machine:
    """This machine's limits, measured by a few loops that are compiled as kernels are."""
    code = (templates_folder() / "machine.c").read_text()
    library = ctypes.CDLL(str(compile_library({"machine.c": code})))
    x, y = aligned(2, LONG) + 0.5
    found = []
    for name, each, n in (("arithmetic", 2 * WIDE, 4000), ("division", LONG, 200), ("memory", 3 * LONG, 400)):
        f = getattr(library, f"machine_{name}")
        f.argtypes = [ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p]
        seconds = fastest(lambda f=f, n=n: f(n, x.ctypes.data, y.ctypes.data), 3e-3)  # type: ignore[misc]
        found.append(seconds * 1e9 / (n * each))
    return Machine(*found)


def roofline(function: Function) -> tuple[Roof, ...]:
    """Each kernel of `function` on a recording that stays in the first cache; one core."""
    iterates = any(isinstance(s, Implicit) for s in function.model.statements)
    calls, empty = _calls(function, SAMPLES), _calls(function, 0)
    pairs = zip(function.code.source.kernels, calls, empty, strict=True)
    return tuple(_roof(k, _nanoseconds(k, c, e), iterates) for k, c, e in pairs)


def _nanoseconds(kernel: Kernel, call: Callable[[], None], empty: Callable[[], None]) -> float:
    """Of one point, without what any call takes; with it, where a busy machine lets the two not be told
    apart."""
    points = SAMPLES * (SETS if kernel.name.startswith("sumsq") else 1)
    bare, whole = np.inf, np.inf
    for _ in range(ROUNDS):  # in turns, so that both see quiet moments
        bare = min(bare, fastest(empty, PATIENCE / 5))
        whole = min(whole, fastest(call, PATIENCE / 2))
    return float(whole - bare if bare < 0.9 * whole else whole) * 1e9 / points


def _roof(kernel: Kernel, reached: float, iterates: bool) -> Roof:
    """The longest of what the units for arithmetic, division and memory need, all at work at once."""
    limits, work = machine(), kernel.work
    plain = work.operations - work.divisions - work.functions
    needs = {
        "arithmetic": (plain + FUNCTION * work.functions) * limits.arithmetic,
        "division": work.divisions * limits.division,
        "memory": kernel.words * limits.memory,
    }
    by = max(needs, key=lambda n: needs[n])
    if iterates and kernel.name != "prepare":
        return Roof(kernel.name, work.operations, reached, None, "iteration")
    return Roof(kernel.name, work.operations, reached, needs[by] or None, by)


def _calls(function: Function, n: int) -> list[Callable[[], None]]:
    """Of each kernel a call of n points, 0 or SAMPLES, without any ado."""
    model = function.model
    ready = function.prepare(**example(model, SAMPLES))
    stride, p, work = ready.stride, ready.p, ready.work
    inputs = (ctypes.c_void_p * max(1, len(ready.inputs)))(*(a.ctypes.data for a in ready.inputs))
    theta = np.tile(p[function.free], (SETS, 1)) if model.inputs else np.zeros((SETS, 0))
    channels, columns = 2 * len(function.code.source.outputs), len(function.wrt)
    rows = 2 * len(function.code.source.equations)
    out, jac = aligned(max(channels, rows), stride), aligned(channels * max(1, columns), stride)
    data, weight, ssq = aligned(channels, stride), aligned(channels, stride) + 1.0, np.zeros(SETS)
    normal = np.zeros((columns + 1) * (columns + 2) // 2)
    begins: tuple[Any, ...] = (inputs,) if not model.inputs else (work, p)
    ends: dict[str, tuple[Any, ...]] = {
        "prepare": (inputs, p, work),
        "values": (*begins, out),
        "jacobian": (*begins, out, jac),
        "sumsq": (*begins, theta, data, weight, ssq),
        "normal": (*begins, data, weight, normal),
        "all": (inputs, p, out) if model.inputs else (inputs, out),
    }
    made: list[Callable[[], None]] = []
    for k in function.code.source.kernels:
        kind = k.name.split("_")[0]
        size = (n, stride if n else 0)
        first = (SETS if n else 0, *size) if kind == "sumsq" else size
        args = tuple(a.ctypes.data if isinstance(a, np.ndarray) else a for a in (*first, *ends[kind]))
        call = function.code.addresses[k.name]
        keep = (ready, theta, out, jac, data, weight, ssq, normal)  # alive as long as their addresses
        made.append(partial(_run, call, args, keep))
    return made


def _run(call: Any, args: tuple[Any, ...], _: tuple[Any, ...]) -> None:
    call(*args)


def example(model: Model, n: int) -> dict[str, Any]:
    """Inputs and parameters of `model` at n points: frequencies, a motion, or its defaults n times."""
    at = np.arange(n)
    moving = {
        i.name: np.geomspace(1.0, 1e4, n) if i.name == "f" else 1e-3 * at if not k else 3 * np.sin(0.05 * at)
        for k, i in enumerate(model.inputs)
        if i.derived is None
    }
    values = {
        p.name: p.default if p.default is not None else float(np.mean(np.clip(p.bounds, -10, 10)))
        for p in model.scalar_parameters
    }
    if model.inputs:
        return {**values, **moving}
    return {k: np.full(n, v) for k, v in values.items()}
