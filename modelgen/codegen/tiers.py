"""Compiled code in two tiers: the optimised library, and what answers until the compiler is done."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np

from modelgen.codegen.emit import Source
from modelgen.codegen.instant import Memory
from modelgen.errors import ToolError

GRACE = 0.1
"""Seconds that the library waits for a first answer, whose time it would take away."""
WORTH = {"none": 0.4, "some": 2.0}
"""Seconds that fits may work in code in memory before the compiler's time is worth it: what it takes itself,
and more where some loops are tapes. Where all are, a library is hardly faster."""
_SIZE, _POINTER = ctypes.c_size_t, ctypes.c_void_p


class Rise:
    """The library that code in memory gives way to, compiled in a thread of its own once fits have worked in
    that code for long. Both must round alike, bit by bit, so that no number depends on when."""

    def __init__(self, make: Callable[[], Code], worth: float):
        self._make, self._left = make, worth
        self._library: Future[Code] | None = None

    def worked(self, seconds: float) -> None:
        """Fits have worked for so long."""
        self._left -= seconds
        if self._left < 0 and self._library is None:
            self._library = compilers().submit(self._make)

    def there(self) -> Code | None:
        """The library, if it is done. Raises what the compiler complained of."""
        return self._library.result() if self._library is not None and self._library.done() else None


@dataclass(frozen=True, eq=False)
class Code:
    """Kernels of a model, loaded: what they are, and the library (a file, or memory) that holds them.

    rise: what it gives way to.
    """

    source: Source
    library: Path | Memory
    rise: Rise | None = None

    @property
    def addresses(self) -> dict[str, Any]:
        """Kernels by name, ready to be called. They are there as long as this object."""
        return self.best._own

    @property
    def best(self) -> Code:
        """The library that this gives way to, if it is there, else this."""
        return (self.rise and self.rise.there()) or self

    @cached_property
    def _own(self) -> dict[str, Any]:
        home = ctypes.CDLL(str(self.library)) if isinstance(self.library, Path) else self.library
        found = {}
        for k in self.source.kernels:
            f = getattr(home, f"{self.source.prefix}_{k.name}")
            f.restype = None
            arguments = k.signature[k.signature.index("(") :].split(",")
            f.argtypes = [_SIZE if "size_t" in a else _POINTER for a in arguments]
            found[k.name] = f
        return found

    def call(self, kernel: str, *args: Any) -> None:
        """Call a kernel; arrays go by address."""
        self.addresses[kernel](*(a.ctypes.data if isinstance(a, np.ndarray) else a for a in args))

    def channels(self, measure: str) -> int:
        return len(self.source.outputs) * (2 if measure == "complex" else 1)


class Tiers:
    """A model's code, now and as fast as can be.

    make: gives the library, in a thread of its own; at_once: gives the code of one kind of kernel right away
    (None: `make` is quick itself). What `make` raises, the next call raises. A process that ends lets the
    compiler finish, so that the next one finds the library.
    """

    def __init__(self, make: Callable[[], Code], at_once: Callable[[str], Code] | None = None):
        self._make, self._at_once = make, at_once
        self._kept: dict[str, Code] = {}
        self._answered = Event()
        self._process = os.getpid()
        self._library = _done(make()) if at_once is None else compilers().submit(self._work)

    def _work(self) -> Code:
        self._answered.wait(GRACE)
        return self._make()

    def library(self) -> Code:
        """The optimised library; waits for it."""
        self._answered.set()
        if not self._library.done() and os.getpid() != self._process:  # forked: the thread stayed behind
            self._library, self._process = _done(self._make()), os.getpid()
        return self._library.result()

    @contextmanager
    def answer(self, kernel: str) -> Iterator[Code]:
        """What is there to answer with: code that has this kind of kernel."""
        yield self._there(kernel)
        self._answered.set()

    def _there(self, kernel: str) -> Code:
        if self._at_once is None or self._library.done():
            return self.library()
        if kernel not in self._kept:
            try:
                self._kept[kernel] = self._at_once(kernel)
            except ToolError:  # not on this machine, or a system that lets nobody write code to memory
                return self.library()
        return self._kept[kernel]


def _done(code: Code) -> Future[Code]:
    future: Future[Code] = Future()
    future.set_result(code)
    return future


@cache
def compilers() -> ThreadPoolExecutor:
    """Threads that compilers run in."""
    return ThreadPoolExecutor(os.cpu_count() or 1, "compiler")


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=compilers.cache_clear)  # a child has none of its parent's threads
