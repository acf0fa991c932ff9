"""The machine that runs tapes: vector operations of C (templates/tape.c.j2), compiled once for all models.

A search fits hundreds of models, each for less time than a compiler takes. Their loops over samples are tapes
instead: lists of operations, each on a block of samples, which run nearly as fast as compiled loops. Every
operation rounds as in the C of the model's library, so both give the same numbers, bit by bit.
"""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any

from modelgen.codegen.compiler import WIDE, compile_library
from modelgen.codegen.emit import environment
from modelgen.codegen.loops import LANES
from modelgen.codegen.tape import CALLS, OPERATIONS, PAIRS

ENTRIES = ("mg_tape", "mg_tape_products", "mg_tape_sum", "mg_tape_any", "mg_scan")


def source() -> str:
    """The machine's C."""
    used = {*(f for f, _ in CALLS), "mg_eddy_deficit", "mg_complex", "mg_min", "mg_max", "mg_sign"}
    used |= {f"mg_{f}" for f in ("exp", "log", "sin", "cos", "atan2")}
    parts = {"operations": OPERATIONS, "calls": CALLS, "pairs": PAIRS, "used": used, "lanes": LANES}
    return str(environment().get_template("tape.c.j2").render(parts))


@cache
def machine() -> dict[bytes, Any]:
    """Addresses of the machine's entries by name. Raises ToolError when there is no compiler."""
    library = ctypes.CDLL(str(compile_library({"tape.c": source()}, WIDE)))
    return {n.encode(): ctypes.cast(getattr(library, n), ctypes.c_void_p) for n in ENTRIES}
