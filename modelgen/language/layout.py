"""Python text laid out in lines that can be read."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Iterable, Sequence

WIDTH = 110


def quoted(text: str) -> str:
    """A string literal; JSON's are Python's, too."""
    return json.dumps(text, ensure_ascii=False)


def row(items: Iterable[str]) -> str:
    """A tuple."""
    items = list(items)
    return f"({items[0]},)" if len(items) == 1 else f"({', '.join(items)})"


def arguments(given: Sequence[str], optional: Sequence[tuple[str, str, bool]], positional: int) -> list[str]:
    """`given`, then `optional` ones (keyword, text, left out).

    The first `positional` of these go without keyword, until one is left out.
    """
    texts = list(given)
    for k, (key, text, left_out) in enumerate(optional):
        if left_out:
            positional = min(positional, k)
        else:
            texts.append(text if k < positional else f"{key}={text}")
    return texts


def fill(function: str, items: Iterable[str], before: int = 8, always: bool = False) -> str:
    """A call (a tuple, for function ""): in one line if it fits, else as many items a line as fit.

    before: characters that stand in front of it. always: one item a line in any case.
    """
    items = list(items)
    line = f"{function}({', '.join(items)})" if function else row(items)
    if not items or (len(line) <= WIDTH - before and not always):
        return line
    lines = [""]
    for item in items:
        joined = f"{lines[-1]} {item}," if lines[-1] else f"{item},"
        if len(joined) <= WIDTH - 8 and not (always and lines[-1]):
            lines[-1] = joined
        else:
            lines += ["\n".join(_broken(f"{item},"))]
    body = "".join(textwrap.indent(x, "    ") + "\n" for x in lines if x)
    return f"{function}(\n{body})"


def assigned(variable: str, value: str) -> str:
    """`variable = value`; a long tuple is broken."""
    line = f"{variable} = {value}"
    if len(line) <= WIDTH or "\n" in line or not value.startswith("("):
        return line
    return f"{variable} = (\n{textwrap.indent(chr(10).join(_broken(value[1:-1], hang='')), '    ')}\n)"


def imported(module: str, names: Sequence[str]) -> str:
    """An import, one name a line where they don't fit into one."""
    line = f"from {module} import {', '.join(names)}"
    if len(line) <= WIDTH:
        return line
    return f"from {module} import (\n{''.join(f'    {n},{chr(10)}' for n in names)})"


def _broken(text: str, hang: str = "    ") -> list[str]:
    """Lines of an expression; one with a string of words in it stays whole."""
    if "\n" in text or len(text) <= WIDTH - 8 or _has_words(text):
        return text.split("\n")
    return textwrap.wrap(
        text, WIDTH - 8, subsequent_indent=hang, break_long_words=False, break_on_hyphens=False
    )


def _has_words(text: str) -> bool:
    """Whether a string in the text holds a space, where a line must not be broken."""
    return any(" " in part for part in text.split('"')[1::2])
