"""One recording as the fitters in C see it: the model's kernels, data, places in θ, and what whitens."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from modelgen.codegen.fitters import Noise, Recording, address, library
from modelgen.codegen.function import Prepared
from modelgen.fit.whitener import Whitener

Array = np.ndarray[Any, np.dtype[Any]]
LANES = 8  # numbers of a cache line; MG_LANES


@dataclass(frozen=True, eq=False)
class Recorded:
    """One recording for C. data, weight: (channels, stride), zero behind the last sample.

    row: which of the model's outputs the channels are. place: position of each column in θ, −1 where the
    value in `held` stands. fused: the model has kernels that sum by themselves, and the noise is independent.
    """

    prepared: Prepared
    measure: str
    data: Array
    weight: Array
    whitener: Whitener
    row: Array
    place: Array
    held: Array
    fused: bool

    def table(self, local: Array, fused: bool) -> Recording:
        """The C structure; arrays stay ours. Unless it is `fused`, `begun` completes it."""
        f, ready = self.prepared.function, self.prepared
        arrays = (ready.p, self.data, self.weight, f.free, self.place, self.held, local)
        if fused:
            kernels, work = [self._kernel(k) for k in ("normal", "sumsq")], address(ready.work)
        else:
            called = library().mg_noise_normal, library().mg_noise_sumsq
            kernels, work = [ctypes.cast(k, ctypes.c_void_p).value for k in called], 0
        return Recording(
            *kernels, ready.n, ready.stride, len(f.wrt), len(ready.p), work, *(address(a) for a in arrays)
        )

    def _kernel(self, kind: str) -> int | None:
        """The address of one of the model's kernels, if it has it."""
        found = self.prepared.code.addresses.get(f"{kind}_{self.measure}")
        return found and ctypes.cast(found, ctypes.c_void_p).value

    @cached_property
    def _arrays(self) -> Mapping[str, Array]:
        """What the C structure of the noise points to."""
        w = self.whitener
        given: dict[str, Array | None] = {"row": self.row, "column": self.prepared.function.free}
        turned = np.iscomplexobj(w.weight)
        given |= {"re": w.weight.real, "im": w.weight.imag} if turned else {"re": self.weight}
        given |= {} if w.root is None else {"modes": w.root.modes.T, "less": w.root.less}
        given |= {} if w.ar is None else {"ar": w.ar, "undo": w.undo, "share": w.share}
        given |= {} if w.ar is None or w.band is None else {"band": w.band.T, "reach": w.reach}
        return {n: np.ascontiguousarray(a) for n, a in given.items() if a is not None}

    @cached_property
    def _noise(self) -> Noise:
        """The C structure of the noise, but for its block."""
        ready, kept = self.prepared, self._arrays
        return Noise(
            values=self._kernel("values"), jacobian=self._kernel("jacobian"), work=address(ready.work),
            outputs=ready.code.channels(self.measure), channels=len(self.row),
            columns=len(ready.function.wrt), parameters=len(ready.p),
            period=360.0 if self.measure == "phase" else 0.0,
            shared=len(kept["less"]) if "less" in kept else 0,
            order=len(kept["ar"]) - 1 if "ar" in kept else 0,
            bands=kept["band"].shape[1] - 1 if "band" in kept else 0,
            **{n: address(a) for n, a in kept.items()},
        )  # fmt: skip

    @cached_property
    def room(self) -> int:
        """Numbers that whitening works in."""
        noise, ready = self._noise, self.prepared
        return int(noise.outputs * (noise.columns + 1) + LANES) * ready.stride + len(ready.p) + LANES

    @property
    def size(self) -> int:
        """Residuals."""
        return len(self.row) * self.prepared.n

    def begun(self, row: Recording, block: Array) -> Noise:
        """Complete the table of one run: its own noise, which works in `block`; to be kept meanwhile."""
        own = Noise()
        ctypes.memmove(ctypes.addressof(own), ctypes.addressof(self._noise), ctypes.sizeof(own))
        if self.prepared.code.rise is not None:  # a library may be there by now
            own.values, own.jacobian = self._kernel("values"), self._kernel("jacobian")
        own.block = -(-address(block) // (8 * LANES)) * 8 * LANES
        row.work = ctypes.addressof(own)
        return own
