"""Effects of the user's own, from a Python file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from modelgen.effects.effect import Effect
from modelgen.errors import InputError, did_you_mean
from modelgen.userfile import run_user_file


def load_effects(spec: str | Path, folder: Path | str = ".") -> tuple[Effect, ...]:
    """All effects in "path/to/file.py", or the one (or the tuple of them) in "path/to/file.py:NAME".

    A relative path is relative to `folder`. Raises InputError when the file cannot be read or run, or has
    no effect.
    """
    text = str(spec)
    path, _, name = text.rpartition(":") if ".py:" in text else (text, "", "")
    if not path.endswith(".py"):
        raise InputError(f"'{text}' is no file with effects, wanted path/to/file.py or path/to/file.py:NAME")
    return _pick(path, name, run_user_file(path, Path(folder) / path, "effects"))


def _pick(shown: str, name: str, names: dict[str, Any]) -> tuple[Effect, ...]:
    """The effects of the user's file, each once, in the order in which they stand."""
    found = {n: e for n, e in ((n, _effects(shown, n, v)) for n, v in names.items()) if e}
    if name:
        if name not in names:
            raise InputError(f"'{shown}' has no '{name}'{did_you_mean(name, found)}")
        if name not in found:
            raise InputError(
                f"'{name}' in '{shown}' is of type {type(names[name]).__name__}, wanted an Effect"
            )
        return found[name]
    if not found:
        raise InputError(f"'{shown}' has no effect in it, wanted at least one value of type Effect")
    unique: list[Effect] = []
    for effects in found.values():
        unique += [e for e in effects if not any(e is u for u in unique)]
    return tuple(unique)


def _effects(shown: str, name: str, value: Any) -> tuple[Effect, ...]:
    """The effects in a value of the user's file; none in what has nothing to do with them."""
    if isinstance(value, Effect):
        return (value,)
    if not isinstance(value, tuple | list) or not any(isinstance(e, Effect) for e in value):
        return ()
    for k, e in enumerate(value):
        if not isinstance(e, Effect):
            raise InputError(f"'{name}[{k}]' in '{shown}' is of type {type(e).__name__}, wanted an Effect")
    return tuple(value)
