"""Files are written whole or not at all; and where what is made once is kept."""

from __future__ import annotations

import os
import tempfile
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from modelgen.errors import InputError, ToolError


def write_atomically(
    path: str | Path, content: str | bytes, *, parents: bool = False, lasting: bool = True
) -> None:
    """Write text (as UTF-8) or bytes to a neighbouring file, then rename it: a reader sees the old file or
    the new one, whole.

    A file that holds just that is not touched. A link is followed; a device or a FIFO is written to, as
    nothing can be renamed over it. parents: make the folder if it is missing.
    lasting: False for what can be made again: a machine that loses power may leave it empty.
    Raises InputError when `path` is a folder or its own folder is missing, ToolError when the system refuses.
    """
    path = destination(Path(path))
    data = content.encode() if isinstance(content, str) else content
    if path.is_dir():
        raise InputError(f"cannot write {path}: it is a folder, a file name is wanted")
    if not parents and not path.parent.is_dir():
        raise InputError(f"cannot write {path}: the folder {path.parent} does not exist")
    part = path.with_name(f".{path.name}.{os.getpid()}.{threading.get_ident()}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if is_special(path):
            with open(path, "wb") as file:
                file.write(data)
            return
        if path.is_file() and path.read_bytes() == data:
            return
        try:
            with open(part, "wb") as file:
                file.write(data)
                file.flush()
                if lasting:
                    os.fsync(file.fileno())  # a full disk may say so only here
            os.replace(part, path)
        finally:
            part.unlink(missing_ok=True)
    except OSError as why:
        raise ToolError(f"cannot write {path}: {why.strerror or why}") from why


def destination(path: Path) -> Path:
    """Where what is written to `path` goes: a link to a file, or to none yet, stands for what it leads to.

    Raises InputError for one that leads back to itself.
    """
    if not path.is_symlink() or is_special(path):  # a pipe behind /dev/stdout has no other name
        return path
    end = Path(os.path.realpath(path))
    if end.is_symlink():
        raise InputError(f"cannot write {path}: it is a link that leads nowhere")
    return end


def leads_nowhere(path: Path) -> bool:
    """Whether `path` is a link to what is not there, or to itself."""
    return path.is_symlink() and not path.exists()


def is_special(path: Path) -> bool:
    """Whether `path` is there and neither a file nor a folder: a device, a FIFO, a socket."""
    return path.exists() and not path.is_file() and not path.is_dir()


def made_whole(folder: Path, make: Callable[[Path], object]) -> Path:
    """`folder`, filled by `make` where it isn't there yet: aside, then renamed, so that processes that begin
    at once never see part of it."""
    if not folder.is_dir():
        prefix, at = f".{folder.name}.", folder.parent
        # another may be first, or the disk full
        with suppress(OSError), tempfile.TemporaryDirectory("", prefix, at, True) as name:
            make(Path(name))
            os.rename(name, folder)
    return folder


def cache_folder() -> Path:
    """$MODELGEN_CACHE, or the user's cache folder, or a temporary one when that can't be written."""
    chosen = os.environ.get("MODELGEN_CACHE")
    base = (
        Path(chosen)
        if chosen
        else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "modelgen"
    )
    try:
        base.mkdir(parents=True, exist_ok=True)
        if os.access(base, os.W_OK):
            return base
    except OSError:
        pass
    if chosen:
        raise ToolError(f"cache folder '{base}' (MODELGEN_CACHE) can't be written")
    fallback = Path(tempfile.gettempdir()) / f"modelgen-{os.getuid() if hasattr(os, 'getuid') else 'cache'}"
    fallback.mkdir(parents=True, exist_ok=True)
    return fallback
