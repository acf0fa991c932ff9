"""A least-squares problem evaluated, and fitted, in C: fused kernels on recordings with independent noise."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from modelgen.codegen.fitters import Descent, Recording, address, library
from modelgen.codegen.function import Prepared
from modelgen.fit.pool import cores, share, slices

Array = np.ndarray[Any, np.dtype[Any]]

WORTH = 200_000  # samples; less work than that is not shared out


class Ends(NamedTuple):
    """Where descents ended: θ (m, p); r·r, status, evaluations, iterations (m,); of one alone its history."""

    theta: Array
    value: Array
    status: Array
    evaluations: Array
    iterations: Array
    history: Array


@dataclass(frozen=True, eq=False)
class Fused:
    """One recording for the fused kernels. data, weight: (channels, stride), zero behind the last sample.

    place: position of each column in θ, −1 where the value in `held` stands.
    """

    prepared: Prepared
    measure: str
    data: Array
    weight: Array
    place: Array
    held: Array

    def table(self, local: Array) -> Recording:
        """The C structure; arrays stay ours."""
        f, ready = self.prepared.function, self.prepared
        called = (f.code.addresses[f"{k}_{self.measure}"] for k in ("normal", "sumsq"))
        kernels = (ctypes.cast(c, ctypes.c_void_p) for c in called)
        arrays = (ready.work, ready.p, self.data, self.weight, f.free, self.place, self.held, local)
        return Recording(
            *kernels, ready.n, ready.stride, len(f.wrt), len(ready.p), *(address(a) for a in arrays)
        )


@dataclass(frozen=True, eq=False)
class Compiled:
    """Sums of squares and normal equations of whole problems, `size` parameters, in one call each."""

    recordings: tuple[Fused, ...]
    size: int

    @cached_property
    def samples(self) -> int:
        """Samples of all recordings."""
        return sum(r.prepared.n for r in self.recordings)

    @cached_property
    def _tables(self) -> tuple[Any, int]:
        rows, room = [], 0
        for r in self.recordings:
            columns = len(r.prepared.function.wrt)
            room = max(room, len(r.prepared.p) + (columns + 1) * (columns + 2) // 2)
            rows.append(r.table(r.held))
        return (Recording * len(rows))(*rows), room

    def tables(self) -> tuple[Any, Array]:
        """Recordings with memory of their own to work in, and that memory: one for each run that goes on."""
        base, room = self._tables
        own, local = (Recording * len(base))(), np.zeros(room)
        ctypes.memmove(own, base, ctypes.sizeof(base))
        for r in own:
            r.local = address(local)
        return own, local

    def values(self, thetas: Array, threads: int | None = None) -> Array:
        """r·r at each row of θ (m, p); +inf where it is not finite."""
        rows = np.ascontiguousarray(thetas, dtype=float)
        found, call = np.empty(len(rows)), library().mg_fit_values

        def some(part: slice) -> None:
            table, keep = self.tables()
            here, out = rows[part], found[part]
            call(ctypes.addressof(table), len(table), self.size, len(here), address(here), address(out))
            del keep

        parts = 4 * (threads or cores()) if len(rows) * self.samples > WORTH else 1
        share(some, slices(len(rows), parts), threads)
        return found

    def normal(self, theta: Array) -> tuple[float, Array, Array]:
        """r·r (+inf where anything is not finite), Jᵀr (p,) and JᵀJ (p, p)."""
        theta = np.ascontiguousarray(theta, dtype=float)
        table, keep = self.tables()
        g, A = np.empty(self.size), np.empty((self.size, self.size))
        at = (address(a) for a in (theta, g, A))
        value = library().mg_fit_normal(ctypes.addressof(table), len(table), self.size, *at)
        del keep
        return float(value), g, A

    def descend(
        self, begins: Array, box: tuple[Array, Array, Array], settings: tuple[int, float, float],
        threads: int | None = None, beyond: bool = False,
    ) -> Ends:  # fmt: skip
        """Levenberg–Marquardt from each row of `begins` (m, p).

        box: lower, upper, width (p,); settings: max_iter, tol, damping; beyond: see `GaussNewton`.
        """
        m, theta = len(begins), np.array(begins, dtype=float)
        value, counts = np.empty(m), np.zeros((3, m), dtype=int)
        history = np.zeros(settings[0])

        def some(part: slice) -> None:
            run, (table, keep) = Descent(*box, *settings, beyond), self.tables()
            trace = history if m == 1 else np.zeros(settings[0])
            for k in range(part.start, part.stop):
                counts[0, k] = run.run(theta[k], table, trace)
                theta[k], value[k] = run.theta, run.value
                counts[1:, k] = run.s.evaluations, run.s.iteration
            del keep

        parts = 4 * (threads or cores()) if m * self.samples * 30 > WORTH else 1
        share(some, slices(m, parts), threads)
        status, evaluations, iterations = counts
        return Ends(theta, value, status, evaluations, iterations, history[: iterations.max(initial=0)])

    def fixed(self, index: int, value: float) -> Compiled:
        """The same with parameter `index` of θ held at `value`."""
        held = [np.where(r.place == index, value, r.held) for r in self.recordings]
        places = [np.where(r.place == index, -1, r.place - (r.place > index)) for r in self.recordings]
        moved = (replace(r, place=p, held=h) for r, p, h in zip(self.recordings, places, held, strict=True))
        return Compiled(tuple(moved), self.size - 1)


def fused(
    prepared: Sequence[Prepared], measures: Sequence[str], data: Sequence[Array], weight: Sequence[Array],
    place: Array, held: Array, size: int,
) -> Compiled:  # fmt: skip
    """Put recordings together; data and weight (channels, n) each, place and held (recordings, columns)."""
    parts = zip(prepared, measures, data, weight, place, held, strict=True)
    return Compiled(
        tuple(
            Fused(r, m, r.pad(y), r.pad(w), np.ascontiguousarray(p, dtype=np.int64), np.ascontiguousarray(h))
            for r, m, y, w, p, h in parts
        ),
        size,
    )
