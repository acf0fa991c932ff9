"""A least-squares problem evaluated, and fitted, in C: fused kernels where noise is independent, else a
model's own and a whitener."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from threading import Event
from time import thread_time
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from modelgen.codegen.fitters import Descent, Recording, address, library
from modelgen.codegen.function import Prepared
from modelgen.fit.pool import cores, share, slices
from modelgen.fit.recorded import Recorded
from modelgen.fit.series import Series
from modelgen.fit.whitener import Whitener

if TYPE_CHECKING:
    from modelgen.fit.experiment import Layout

Array = np.ndarray[Any, np.dtype[Any]]

WORTH = 200_000  # samples; less work than that is not shared out


class Ends(NamedTuple):
    """Where descents ended: θ (m, p); r·r, status, evaluations, iterations (m,); of one alone its history.

    interrupted: whether they were cut short; r·r is infinite of those that had not begun.
    """

    theta: Array
    value: Array
    status: Array
    evaluations: Array
    iterations: Array
    history: Array
    interrupted: bool = False


@dataclass(frozen=True, eq=False)
class Compiled:
    """Sums of squares and normal equations of whole problems, `size` parameters, in one call each."""

    recordings: tuple[Recorded, ...]
    size: int

    @cached_property
    def samples(self) -> int:
        """Samples of all recordings."""
        return sum(r.prepared.n for r in self.recordings)

    @cached_property
    def _room(self) -> int:
        """Numbers that a recording's parameters and sums take."""
        columns = [(len(r.prepared.p), len(r.prepared.function.wrt)) for r in self.recordings]
        return max(p + (c + 1) * (c + 2) // 2 for p, c in columns)

    @cached_property
    def _fused(self) -> Any:
        return (Recording * len(self.recordings))(*(r.table(r.held, r.fused) for r in self.recordings))

    @cached_property
    def _apart(self) -> Any:
        return (Recording * len(self.recordings))(*(r.table(r.held, False) for r in self.recordings))

    def tables(self, apart: bool = False) -> tuple[Any, Any]:
        """Recordings with memory of their own to work in, and what to keep meanwhile: one for each run that
        goes on. apart: none of them sums by itself."""
        base = self._apart if apart else self._fused
        own, local = (Recording * len(base))(), np.zeros(self._room)
        ctypes.memmove(own, base, ctypes.sizeof(base))
        block = np.empty(max((r.room for r in self.recordings if apart or not r.fused), default=0))
        kept: list[Any] = [local, block]
        for row, r in zip(own, self.recordings, strict=True):
            row.local = address(local)
            if apart or not r.fused:
                kept.append(r.begun(row, block))
        return own, kept

    def _worked(self, begun: float) -> None:
        """Tell code that may rise how long it was worked in."""
        for rise in {r.prepared.code.rise for r in self.recordings}:
            if rise is not None:
                rise.worked(thread_time() - begun)

    def residuals(self, theta: Array) -> Array:
        """Whitened residuals (N,), recording by recording, in each channel by channel; (m, N) at the rows of
        θ (m, p)."""
        begun, (table, keep) = thread_time(), self.tables(apart=True)
        rows = np.ascontiguousarray(np.atleast_2d(theta), dtype=float)
        found = np.empty((len(rows), sum(r.size for r in self.recordings)))
        of = ctypes.addressof(table), len(table), *rows.shape, address(rows)
        library().mg_noise_residuals(*of, found.shape[1], address(found))
        del keep
        self._worked(begun)
        return found.reshape(*np.shape(theta)[:-1], -1)

    def columns(self, theta: Array, wanted: Sequence[int]) -> Array:
        """The columns `wanted` of their Jacobian, (N, len(wanted)), each in one piece; (m, N, len(wanted)) at
        the rows of θ (m, p)."""
        begun, (table, keep) = thread_time(), self.tables(apart=True)
        rows = np.ascontiguousarray(np.atleast_2d(theta), dtype=float)
        which = np.array(wanted, dtype=np.int64)
        found = np.empty((len(rows), len(which), sum(r.size for r in self.recordings)))
        of = ctypes.addressof(table), len(table), *rows.shape, address(rows)
        library().mg_noise_columns(*of, address(which), *found.shape[1:], address(found))
        del keep
        self._worked(begun)
        return np.moveaxis(found.reshape(*np.shape(theta)[:-1], *found.shape[1:]), -1, -2)

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
        threads: int | None = None, beyond: bool = False, kept: bool = False,
    ) -> Ends:  # fmt: skip
        """Levenberg–Marquardt from each row of `begins` (m, p).

        box: lower, upper, width (p,); settings: max_iter, tol, damping; beyond: see `GaussNewton`. kept:
        Ctrl-C ends the runs, and what they have found so far is returned.
        """
        m, theta = len(begins), np.array(begins, dtype=float)
        value, counts = np.full(m, np.inf), np.zeros((3, m), dtype=int)
        history, runs, stopped = np.zeros(settings[0]), list[Descent](), Event()

        def stop() -> None:
            stopped.set()
            for run in runs:
                run.stop()

        def some(part: slice) -> None:
            begun, (table, keep) = thread_time(), self.tables()
            run = Descent(*box, *settings, beyond)
            runs.append(run)
            trace = history if m == 1 else np.zeros(settings[0])
            for k in range(part.start, part.stop):
                if stopped.is_set():
                    break
                counts[0, k] = run.run(theta[k], table, trace)
                theta[k], value[k] = run.theta, run.value
                counts[1:, k] = run.s.evaluations, run.s.iteration
            del keep
            self._worked(begun)

        parts = 4 * (threads or cores()) if m * self.samples * 30 > WORTH else 1
        try:
            share(some, slices(m, parts), threads, stop if kept else None)
        except KeyboardInterrupt:
            if not kept:
                raise
        status, evaluations, iterations = counts
        longest = iterations.max(initial=0)
        return Ends(theta, value, status, evaluations, iterations, history[:longest], stopped.is_set())

    def fixed(self, index: int, value: float) -> Compiled:
        """The same with parameter `index` of θ held at `value`."""
        held = [np.where(r.place == index, value, r.held) for r in self.recordings]
        places = [np.where(r.place == index, -1, r.place - (r.place > index)) for r in self.recordings]
        moved = (replace(r, place=p, held=h) for r, p, h in zip(self.recordings, places, held, strict=True))
        return Compiled(tuple(moved), self.size - 1)


def compiled(
    prepared: Sequence[Prepared], series: Sequence[Series], whiteners: Sequence[Whitener], layout: Layout
) -> Compiled:
    """The sums of an experiment: fused where noise is independent, all channels are measured, and the model
    has the kernels."""
    found = []
    for ready, s, w, place, held in zip(prepared, series, whiteners, layout.place, layout.held, strict=True):
        there = {f"sumsq_{s.measure}", f"normal_{s.measure}"} <= set(ready.code.addresses)
        whole = tuple(s.rows) == tuple(range(ready.code.channels(s.measure)))
        weight = np.abs(np.broadcast_to(w.weight, s.data.shape))
        found.append(
            Recorded(
                ready, s.measure, ready.pad(s.data), ready.pad(weight), w, np.array(s.rows, dtype=np.uintp),
                np.ascontiguousarray(place, dtype=np.int64), np.ascontiguousarray(held),
                fused=there and whole and w.root is None and w.ar is None,
            )
        )  # fmt: skip
    return Compiled(tuple(found), len(layout.names))
