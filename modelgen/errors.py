"""What modelgen says when the user's input is wrong: one line, with the place and the nearest right name."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


class ModelgenError(Exception):
    """Base of all errors that modelgen raises on purpose."""


class InputError(ModelgenError):
    """The user's input is wrong. The message is one line: what, where, what was found, what was wanted."""


class ToolError(ModelgenError):
    """Something outside is missing or refused: no C compiler, an unwritable folder, a full disk."""


def did_you_mean(name: str, names: Iterable[str]) -> str:
    """Return ", did you mean 'k_D'?" for the nearest of `names`, or ""."""
    lower = {n.lower(): n for n in names}
    near = get_close_matches(name.lower(), lower, n=1, cutoff=0.5)
    return f", did you mean '{lower[near[0]]}'?" if near else ""


def one_of(name: str, names: Iterable[str]) -> str:
    """Return what goes on after "no NAME" where there is a short list: the nearest, and the list."""
    known = tuple(names)
    return f"{did_you_mean(name, known) or ';'} it is one of {', '.join(known)}"
