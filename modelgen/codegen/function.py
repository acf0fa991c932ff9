"""A compiled model: callable from Python, with exact derivatives."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from modelgen.codegen.loops import PADDED
from modelgen.codegen.tiers import Code, Tiers
from modelgen.errors import InputError, did_you_mean
from modelgen.language import Model

Array = np.ndarray[Any, np.dtype[Any]]
LINE = 64  # bytes
PAGE = 512  # numbers


@dataclass(frozen=True)
class Prepared:
    """A recording made ready: what depends on the samples and on fixed parameters is computed.

    Evaluate it for any values `theta` of the parameters that the function was built `wrt`.
    """

    function: Function
    code: Code
    n: int
    stride: int
    work: Array
    p: Array
    inputs: tuple[Array, ...]

    @cached_property
    def _work(self) -> int:
        """Address of `work`."""
        return int(self.work.ctypes.data)

    def _with(self, theta: Sequence[float] | Array) -> Array:
        p = self.p.copy()
        p[self.function.free] = theta
        return p

    def values(self, theta: Sequence[float] | Array, measure: str) -> Array:
        """Channels of `measure`, shape (channels, n)."""
        if f"values_{measure}" not in self.code.addresses:
            return self.jacobian(theta, measure)[0]
        p, out = self._with(theta), aligned(self.code.channels(measure), self.stride, fill=None)
        self.code.call(f"values_{measure}", self.n, self.stride, self._work, p, out)
        return out[:, : self.n]

    def jacobian(self, theta: Sequence[float] | Array, measure: str) -> tuple[Array, Array]:
        """Channels (channels, n) and their derivatives (channels, columns, n)."""
        channels, columns = self.code.channels(measure), len(self.function.wrt)
        # one block, since an address costs as much as 100 samples
        both = aligned(1 + columns, channels, self.stride, fill=None)
        at = both.ctypes.data
        jac_at = at + both[0].nbytes
        self.code.call(f"jacobian_{measure}", self.n, self.stride, self._work, self._with(theta), at, jac_at)
        jac = both[1:].reshape(channels, columns, self.stride)
        return both[0, :, : self.n], jac[:, :, : self.n]

    def pad(self, rows: Array) -> Array:
        """Data or weights (channels, n) laid out for `sumsq` and `normal`; padding is zero."""
        full = aligned(rows.shape[0], self.stride)
        full[:, : self.n] = rows
        return full

    def sumsq(self, thetas: Array, measure: str, data: Array, weight: Array) -> Array:
        """Σ (weight (model − data))² for each row of `thetas` (sets, columns). `data`, `weight` come from
        `pad`."""
        thetas = np.ascontiguousarray(thetas, dtype=float)
        ssq = np.empty(len(thetas))
        self.code.call(
            f"sumsq_{measure}", len(thetas), self.n, self.stride, self.work, self.p, thetas, data, weight, ssq
        )
        return ssq

    def normal(
        self, theta: Sequence[float] | Array, measure: str, data: Array, weight: Array
    ) -> tuple[float, Array, Array]:
        """e·e, Jᵀe and JᵀJ of the weighted residual e = weight (model − data)."""
        columns = len(self.function.wrt)
        flat = np.empty(columns * (columns + 1) // 2 + columns + 1)
        self.code.call(
            f"normal_{measure}", self.n, self.stride, self.work, self._with(theta), data, weight, flat
        )
        full = np.zeros((columns, columns))
        upper = np.triu_indices(columns)
        full[upper] = flat[: len(upper[0])]
        full.T[upper] = full[upper]
        return float(flat[-1]), flat[len(upper[0]) : -1], full


@dataclass(frozen=True, eq=False)
class Function:
    """A compiled model.

    Call it with inputs and parameters by name (parameters left out take their defaults) for the first output,
    or the tuple of outputs when there are several real ones.
    `wrt`: parameters by which `jacobian` has columns, in order.

    Calls, `jacobian` and `all` are answered by what is there: the optimised library or, as long as that is
    being compiled, the same C compiled in memory (equal but for rounding, and slower). `prepare`, and with it
    every fit, waits for the library, as does `code`; models built together, whose code in memory is equal bit
    for bit, are fitted in that meanwhile. What the compiler complains of, the next call raises.
    """

    model: Model
    wrt: tuple[str, ...]
    free: Array
    tiers: Tiers

    @property
    def code(self) -> Code:
        """The optimised library, waited for. Raises ToolError when the compiler refused."""
        return self.tiers.library()

    def _arguments(self, given: Mapping[str, Any]) -> tuple[dict[str, Array], Array, tuple[int, ...]]:
        model = self.model
        inputs = [i.name for i in model.inputs]
        names = {p.name: k for k, p in enumerate(model.scalar_parameters)}
        for name in given:
            if name not in names and name not in inputs:
                raise InputError(
                    f"model '{model.id}' has no parameter or input '{name}'"
                    f"{did_you_mean(name, [*names, *inputs])}"
                )
        values: dict[str, Any] = {}
        for p in model.scalar_parameters:
            value = given.get(p.name, p.default)
            if value is None:
                raise InputError(
                    f"model '{model.id}': parameter '{p.name}' [{p.unit}] has no default and was not given"
                )
            if isinstance(value, complex | str):
                raise InputError(f"parameter '{p.name}' of model '{model.id}' is {value!r}, wanted a number")
            values[p.name] = value
        if not model.inputs:
            arrays = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in values.values()))
            shape = arrays[0].shape
            return (
                {n: np.ascontiguousarray(a).ravel() for n, a in zip(values, arrays, strict=True)},
                np.zeros(0),
                shape,
            )
        for name, value in values.items():
            if np.ndim(value):
                raise InputError(
                    f"parameter '{name}' of model '{model.id}' must be one number, "
                    f"found shape {np.shape(value)}"
                )
        from modelgen.codegen.inputs import complete_inputs

        sampled, shape = complete_inputs(model, {n: given[n] for n in inputs if n in given})
        return sampled, np.array([float(v) for v in values.values()]), shape

    def prepare(self, /, **given: Any) -> Prepared:
        """Make a recording (inputs, values of parameters by name) ready for many evaluations."""
        return self._prepared(self.code, *self._arguments(given)[:2])

    def _prepared(self, code: Code, inputs: dict[str, Array], p: Array) -> Prepared:
        arrays = tuple(inputs.values())
        n = len(arrays[0])
        stride = padded(n)
        work = aligned(max(1, code.source.staged), stride)
        if self.model.inputs:
            code.call("prepare", n, stride, _pointers(arrays), p, work)
        return Prepared(self, code, n, stride, work, p, arrays)

    def _evaluate(
        self, given: Mapping[str, Any], jacobian: bool
    ) -> tuple[list[Array], list[Array], tuple[int, ...]]:
        inputs, p, shape = self._arguments(given)
        kernel = "jacobian" if jacobian else "values"
        with self.tiers.answer(kernel) as code:
            measure = "complex" if any(code.source.complex_outputs) else "real"
            jac = None
            if self.model.inputs:
                prepared, theta = self._prepared(code, inputs, p), p[self.free]
                if jacobian:
                    out, jac = prepared.jacobian(theta, measure)
                else:
                    out = prepared.values(theta, measure)
            else:
                arrays, n = tuple(inputs.values()), len(next(iter(inputs.values())))
                out = np.empty((code.channels(measure), n))
                jac = np.empty((len(out), len(self.wrt), n)) if jacobian else None
                results = (out,) if jac is None else (out, jac)
                code.call(f"{kernel}_{measure}", n, n, _pointers(arrays), *results)
        return _joined(out, measure), [] if jac is None else _joined(jac, measure), shape

    def __call__(self, /, **given: Any) -> Any:
        """Outputs at the inputs' shape: one array, or a tuple when several real outputs are declared."""
        values, _, shape = self._evaluate(given, jacobian=False)
        shaped = [v.reshape(shape) for v in values]
        return shaped[0] if len(shaped) == 1 else tuple(shaped)

    def jacobian(self, /, **given: Any) -> Any:
        """d(output)/d(parameter) with one column, last, for each of `wrt`: shape (..., len(wrt))."""
        _, slopes, shape = self._evaluate(given, jacobian=True)
        shaped = [s.T.reshape(*shape, len(self.wrt)) for s in slopes]
        return shaped[0] if len(shaped) == 1 else tuple(shaped)

    def all(self, /, **given: Any) -> dict[str, Array]:
        """Every equation of the model by name."""
        inputs, p, shape = self._arguments(given)
        arrays = tuple(inputs.values())
        n = len(arrays[0])
        with self.tiers.answer("all") as code:
            equations = code.source.equations
            out = np.empty((sum(2 if c else 1 for _, c in equations), n))
            code.call("all", n, n, _pointers(arrays), *([p] if self.model.inputs else []), out)
        result: dict[str, Array] = {}
        at = 0
        for name, is_complex in equations:
            result[name] = (out[at] + 1j * out[at + 1] if is_complex else out[at]).reshape(shape)
            at += 2 if is_complex else 1
        return result


def _joined(rows: Array, measure: str) -> list[Array]:
    """Channels as they are, or two each as one complex."""
    if measure != "complex":
        return list(rows)
    return [rows[2 * k] + 1j * rows[2 * k + 1] for k in range(len(rows) // 2)]


def padded(n: int) -> int:
    """Numbers from row to row of n: whole vectors, but no page, which would push rows out of the cache."""
    whole = -(-n // PADDED) * PADDED
    return whole + PADDED if whole % PAGE == 0 else whole


def aligned(*shape: int, fill: float | None = 0.0) -> Array:
    """Numbers that begin at a cache line, as vector loads like them; not set at all where `fill` is None."""
    size = math.prod(shape)
    room = np.empty(size + LINE // 8)
    if fill is not None:
        room.fill(fill)
    start = -(int(room.ctypes.data) // 8) % (LINE // 8)
    return room[start : start + size].reshape(shape)


def _pointers(arrays: Sequence[Array]) -> Any:
    return (ctypes.c_void_p * max(1, len(arrays)))(*(a.ctypes.data for a in arrays))
