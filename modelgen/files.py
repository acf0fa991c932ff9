"""Files are written whole or not at all; and where what is made once is kept."""

from __future__ import annotations

import os
import tempfile
import threading
from collections.abc import Callable, Mapping
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
    write_together({Path(path): content}, parents=parents, lasting=lasting)


def write_together(
    contents: Mapping[Path, str | bytes], *, parents: bool = False, lasting: bool = True
) -> None:
    """`write_atomically` for files that belong together: all or, where the disk is full, none."""
    aside: dict[Path, Path] = {}
    path = Path()
    try:
        try:
            for path, content in contents.items():
                end = _checked(path, parents)
                data = content.encode() if isinstance(content, str) else content
                if is_special(end):
                    end.write_bytes(data)
                elif not (end.is_file() and end.read_bytes() == data):
                    part = end.with_name(f".{end.name}.{os.getpid()}.{threading.get_ident()}.part")
                    aside[end] = part
                    _fill(part, data, lasting)
            for path, part in aside.items():
                os.replace(part, path)
        finally:
            for part in aside.values():
                part.unlink(missing_ok=True)
    except OSError as why:
        raise ToolError(f"cannot write {path}: {why.strerror or why}") from why


def _checked(path: Path, parents: bool) -> Path:
    """Where what is written to `path` goes, in a folder that is there."""
    end = destination(path)
    if end.is_dir():
        raise InputError(f"cannot write {end}: it is a folder, a file name is wanted")
    if not parents and not end.parent.is_dir():
        raise InputError(f"cannot write {end}: the folder {end.parent} does not exist")
    end.parent.mkdir(parents=True, exist_ok=True)
    return end


def _fill(part: Path, data: bytes, lasting: bool) -> None:
    with open(part, "wb") as file:
        file.write(data)
        file.flush()
        if lasting:
            os.fsync(file.fileno())  # a full disk may say so only here


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
