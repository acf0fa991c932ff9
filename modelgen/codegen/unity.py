"""Several generated sources as one translation unit: headers are read, shared functions compiled, once."""

from __future__ import annotations

import re
from collections.abc import Sequence

from modelgen.codegen.emit import Source

_SHARED = re.compile(r"^(?:static|typedef)\b[^\n]*(?:[;}]|\n\{\n.*?\n\})$", re.M | re.S)
_ROOT = re.compile(r"\bsolve_(?=\w+\()")


def unite(sources: Sequence[Source]) -> dict[str, str]:
    """Files (name → text): the headers, and one C file with every source's kernels.

    Functions of the same text are written once. Solvers of implicit equations, which may differ by model
    under one name, take their model's prefix.
    """
    seen: set[str] = set()

    def once(found: re.Match[str]) -> str:
        text = "" if found[0] in seen else found[0]
        seen.add(found[0])
        return text

    parts = [_SHARED.sub(once, _ROOT.sub(f"{s.prefix}_solve_", s.source)) for s in sources]
    return {f"{s.prefix}.h": s.header for s in sources} | {f"{sources[0].prefix}.c": "\n".join(parts)}
