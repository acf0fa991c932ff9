"""How a routine ends: its results are stored if all of them are finite, in lines of a width that is read."""

from __future__ import annotations

import re
from collections.abc import Sequence

WIDTH, INDENT = 120, " " * 8  # of a line; of its continuation


def guarded(checked: list[str], stores: list[str]) -> list[str]:
    """Nothing is written unless all results are finite."""
    names = [v for v in dict.fromkeys(checked) if re.match(r"\(*-?[A-Za-z_]", v)]  # numbers are finite
    test = broken([f"mg_finite({bare(v)})" for v in names], " && ", len("    if () {")) or "1"
    return ["int status = 1;", f"if ({test}) {{", *(f"    {s}" for s in stores), "    status = 0;", "}",
            "return status;"]  # fmt: skip


def broken(parts: Sequence[str], between: str, beside: int) -> str:
    """Parts of a list in C, over lines of at most WIDTH characters of which one has `beside` more."""
    lines, width = [""], beside
    for k, part in enumerate(parts):
        piece = part + (between if k < len(parts) - 1 else "")
        if lines[-1] and width + len(piece) > WIDTH:
            lines.append("")
            width = len(INDENT)
        lines[-1] += piece
        width += len(piece)
    return f"\n{INDENT}".join(line.rstrip() for line in lines)


def bare(text: str) -> str:
    """Without the parentheses around the whole."""
    if not (text.startswith("(") and text.endswith(")")):
        return text
    depth = 0
    for k, ch in enumerate(text):
        depth += (ch == "(") - (ch == ")")
        if depth == 0 and k < len(text) - 1:
            return text
    return text[1:-1]
