"""What a process reads: files that Python opens besides its own, the system's, and its folder's.

An audit hook (PEP 578) can't be taken away again by the code that it watches. It doesn't see what C opens;
the only C in a diagnosis are kernels, which open nothing, and the compiler's, which is given their source.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import modelgen
from modelgen.files import cache_folder

SYSTEM = ("/usr", "/lib", "/etc", "/proc", "/sys", "/dev")


class Watch:
    """Notes the paths that are opened for reading while it is `on`; made once a process."""

    def __init__(self) -> None:
        cache = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
        package = Path(modelgen.__file__).parent
        around = {os.path.realpath(p) for p in ("", package.parent, tempfile.gettempdir())}
        parts = (package, package.parent / "templates", package.parent / "generated")
        places = (sys.prefix, sys.base_prefix, *sys.path, *parts, cache, cache_folder(), *SYSTEM)
        self._own = {os.path.realpath(p) for p in places} - around
        self._seen: set[str] | None = None
        sys.addaudithook(self._hook)

    @contextmanager
    def on(self, folder: Path) -> Iterator[set[str]]:
        """The set of foreign files that are read, filled while the block runs."""
        given, self._seen = os.path.realpath(folder), set()
        seen = self._seen
        try:
            yield seen
        finally:
            self._seen = None
            seen -= {p for p in seen if self._ours(p, given)}

    def _hook(self, event: str, args: tuple[Any, ...]) -> None:
        if self._seen is None:
            return
        if event == "open" and isinstance(args[0], str | bytes):
            writes = isinstance(args[1], str) and not {"r", "+"} & set(args[1])
            if not writes:
                self._seen.add(os.fsdecode(args[0]))
        elif event == "tempfile.mkdtemp":  # what it makes for itself
            self._own.add(os.path.realpath(os.fsdecode(args[0])))

    def _ours(self, path: str, given: str) -> bool:
        real = Path(os.path.realpath(path))
        return any(str(p) in self._own or str(p) == given for p in (real, *real.parents))
