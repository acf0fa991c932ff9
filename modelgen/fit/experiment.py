"""A model, its compiled function and recordings as one least-squares problem, the only residual there is."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from modelgen.codegen.function import Function, Prepared
from modelgen.errors import InputError
from modelgen.fit.compiled import Compiled, compiled
from modelgen.fit.problem import Problem
from modelgen.fit.series import Array, Series
from modelgen.fit.whitener import Whitener
from modelgen.language import Model, Parameter
from modelgen.language.meant import symbols
from modelgen.recordings import Case

if TYPE_CHECKING:
    from modelgen.fit.segments import Segments


@dataclass(frozen=True)
class Layout:
    """Which parameters are free, and where each recording finds its values in θ.

    wrt: free parameters of a recording. names: entries of θ, `F_0[sweep]` where a recording has its own.
    place: (recordings, wrt) positions in θ; −1 where a constant of the recording stands, in `held` of the
    same shape. own: names of parameters with a value of their own in each recording.
    """

    wrt: tuple[str, ...]
    names: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    place: Array
    held: Array
    own: tuple[str, ...]

    def local(self, theta: Array, k: int) -> Array:
        """Values of `wrt` in recording k for θ (..., len(names)): shape (..., len(wrt))."""
        theta = np.asarray(theta, dtype=float)
        ended = np.concatenate([theta, np.full((*theta.shape[:-1], 1), np.nan)], axis=-1)
        return np.where(self.place[k] >= 0, ended[..., self.place[k]], self.held[k])


def initial_parameters(model: Model) -> set[str]:
    """Parameters that stand in initial values of states alone: the past of a recording, not its physics."""
    initial: set[str] = set()
    other: set[str] = set()
    for s in model.statements:
        for key in ("expr", "residual", "update", "rate", "initial"):
            expr = getattr(s, key, None)
            if expr is not None:
                (initial if key == "initial" else other).update(x.name for x in symbols(expr))
    return {p.name for p in model.scalar_parameters if p.name in initial - other}


def make_layout(
    model: Model, case: Case, series: Sequence[Series], wrt: tuple[str, ...] | None = None
) -> Layout:
    """Free are all parameters that no constant holds and that are not `known` (unless the case gives bounds).

    A constant of one recording holds its parameter there alone. wrt: the free parameters, if decided already.
    """
    if wrt is None:
        everywhere = set.intersection(*(set(s.constants) for s in series)) | set(case.constants)
        wrt = tuple(
            p.name
            for p in model.scalar_parameters
            if p.name not in everywhere and (not p.known or p.name in case.bounds)
        )
    initial = initial_parameters(model)
    own = tuple(n for n in wrt if n in case.per_recording or n in initial)
    held = np.array([[s.constants.get(n, np.nan) for n in wrt] for s in series], dtype=float)
    place = np.full(held.shape, -1)
    names: list[str] = []
    for n in [n for n in wrt if n not in own]:
        moves = np.isnan(held[:, wrt.index(n)])
        place[moves, wrt.index(n)] = len(names)
        names += [n] if moves.any() else []
    for r, s in enumerate(series):
        for n in own:
            if np.isnan(held[r, wrt.index(n)]):
                place[r, wrt.index(n)] = len(names)
                names.append(f"{n}[{s.name}]" if len(series) > 1 else n)
    bounded = tuple(_bounded(model.parameter(n.partition("[")[0]), case.bounds) for n in names)
    return Layout(wrt, tuple(names), bounded, place, held, own)


def _bounded(p: Parameter, bounds: Mapping[str, tuple[float, float]]) -> Parameter:
    low, high = bounds.get(p.name, p.bounds)
    default = p.default
    if default is not None and not low <= default <= high:
        default = None
    return replace(p, bounds=(float(low), float(high)), default=default)


@dataclass(frozen=True, eq=False)
class Experiment:
    """Residuals of all `series` as a function of θ, whitened."""

    model: Model
    function: Function
    layout: Layout
    series: tuple[Series, ...]
    constants: Mapping[str, float]

    @cached_property
    def prepared(self) -> tuple[Prepared, ...]:
        ready = []
        for s in self.series:
            values: dict[str, Any] = {
                p.name: 0.0 for p in self.model.scalar_parameters if p.name in self.layout.wrt
            }
            values |= {k: v for k, v in {**self.constants, **s.constants}.items()}
            values |= {i.name: s.inputs[i.name] for i in self.model.inputs if i.name in s.inputs}
            ready.append(self.function.prepare(**values))
        return tuple(ready)

    def local(self, theta: Array, k: int) -> Array:
        """Values of `layout.wrt` in recording k."""
        return self.layout.local(theta, k)

    def raw(self, theta: Array, k: int) -> Array:
        """Model minus data of recording k, (channels, n), not whitened."""
        s = self.series[k]
        out = self.prepared[k].values(self.local(theta, k), s.measure)[list(s.rows)]
        return _difference(out, s)

    def whitened(self, theta: Array, whiteners: Sequence[Whitener] | None = None) -> list[Array]:
        """Whitened residuals, recording by recording, (channels, n) each."""
        shapes = [s.data.shape for s in self.series]
        ends = np.cumsum([rows * n for rows, n in shapes])[:-1]
        parts = np.split(self.sums(whiteners).residuals(theta), ends)
        return [e.reshape(shape) for e, shape in zip(parts, shapes, strict=True)]

    def linearised(self, theta: Array, whiteners: Sequence[Whitener] | None = None) -> tuple[Array, Array]:
        """Whitened residual (N,) and Jacobian (N, len(theta)) over all recordings."""
        sums = self.sums(whiteners)
        return sums.residuals(theta), sums.columns(theta, range(sums.size))

    def columns(self, theta: Array, wanted: Sequence[int], whiteners: Sequence[Whitener]) -> Array:
        """The columns `wanted` of the whitened Jacobian alone, (N, len(wanted)); see `Compiled.columns`."""
        return self.sums(whiteners).columns(theta, wanted)

    def normal(self, theta: Array, whiteners: Sequence[Whitener] | None = None) -> tuple[float, Array, Array]:
        """r·r, Jᵀr (p,) and JᵀJ (p, p) of the whitened residual, without the whole Jacobian."""
        return self.sums(whiteners).normal(theta)

    def sums(self, whiteners: Sequence[Whitener] | None = None) -> Compiled:
        """Residuals and their sums in C, under these whiteners; those of the last ones asked for are kept."""
        used = tuple(whiteners or (s.whitener for s in self.series))
        key = tuple(id(w) for w in used)
        if key not in self._kept:
            self._kept.clear()
            self._kept[key] = compiled(self.prepared, self.series, used, self.layout)
        return self._kept[key]

    @cached_property
    def _kept(self) -> dict[tuple[int, ...], Compiled]:
        return {}

    def problem(
        self,
        start: Array | None = None,
        whiteners: Sequence[Whitener] | None = None,
        constrained: bool = False,
    ) -> Problem:
        """The least-squares problem for any optimiser; `constrained` by the model's conditions."""
        from modelgen.fit.conditions import inequalities

        p = self.layout.parameters
        sums = self.sums(whiteners)
        begin = [np.nan if q.default is None else q.default for q in p] if start is None else start
        low, high = np.array([q.bounds[0] for q in p]), np.array([q.bounds[1] for q in p])
        return Problem(
            self.layout.names, tuple(q.unit for q in p), low, high,
            np.array(begin) if start is None else np.clip(begin, low, high),
            residual=lambda t: np.concatenate([w.ravel() for w in self.whitened(t, whiteners)]),
            linearise=lambda t: self.linearised(t, whiteners),
            normal=sums.normal,
            objective_batch=sums.values,
            compiled=sums,
            segments=self._segments(whiteners),
            constraints=inequalities(self) if constrained else (),
            n_data=sum(s.data.size for s in self.series),
        )  # fmt: skip

    def problem_of(self, free: NDArray[np.bool_], theta: Array) -> Problem:
        """The problem in which only the parameters marked by `free` (p,) move; the others stay at `theta`."""

        def whole(x: Array) -> Array:
            values = theta.copy()
            values[free] = x
            return values

        def linearise(x: Array) -> tuple[Array, Array]:
            r, J = self.linearised(whole(x))
            return r, J[:, free]

        p = [q for q, moves in zip(self.layout.parameters, free, strict=True) if moves]
        low, high = np.array([q.bounds[0] for q in p]), np.array([q.bounds[1] for q in p])
        return Problem(
            tuple(q.name for q in p), tuple(q.unit for q in p), low, high, np.clip(theta[free], low, high),
            residual=lambda x: linearise(x)[0], linearise=linearise,
            n_data=sum(s.data.size for s in self.series),
        )  # fmt: skip

    def _segments(self, whiteners: Sequence[Whitener] | None) -> Callable[[int], Segments] | None:
        """How the recordings are cut, where the model has states and the noise is independent."""
        used = whiteners or [s.whitener for s in self.series]
        if not self.model.states or any(w.root is not None or w.ar is not None for w in used):
            return None
        from modelgen.fit.segments import segments

        return lambda count: segments(self, count, whiteners)


def _difference(out: Array, s: Series) -> Array:
    e = out - s.data
    return e - 360.0 * np.round(e / 360.0) if s.measure == "phase" else e


def experiment(
    model: Model, case: Case, series: Sequence[Series], function: Function | None = None
) -> Experiment:
    """Put model, case and recordings together; compiles the model for the case's free parameters.

    function: `model` compiled before, whose `wrt` then says what is free. Raises InputError when nothing is.
    """
    from modelgen.codegen import build

    layout = make_layout(model, case, series, function.wrt if function else None)
    if not layout.wrt:
        raise InputError(f"nothing to fit: every parameter of '{model.id}' is held by a constant")
    return Experiment(model, function or build(model, layout.wrt), layout, tuple(series), case.constants)
