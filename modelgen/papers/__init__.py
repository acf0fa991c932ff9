"""Published papers computed anew, number by number.

found = reproduce(papers())
found.write_json("numbers.json")
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING

from modelgen.errors import InputError, one_of

if TYPE_CHECKING:
    from modelgen.papers.paper import Paper

IDS = ("gmm", "mre")
"""Each a subpackage with a `PAPER`."""


def papers(wanted: Sequence[str] = ()) -> tuple[Paper, ...]:
    """The papers called `wanted`, all for none. Raises InputError for an unknown one."""
    for name in wanted:
        if name not in IDS:
            raise InputError(f"no paper '{name}'{one_of(name, IDS)}")
    return tuple(import_module(f"modelgen.papers.{name}").PAPER for name in wanted or IDS)
