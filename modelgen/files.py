"""Files are written whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

from modelgen.errors import InputError, ToolError


def write_atomically(path: str | Path, content: str | bytes, *, parents: bool = False) -> None:
    """Write text (as UTF-8) or bytes to a neighbouring file, then rename it: a reader sees the old file or
    the new one, whole.

    A file that holds just that is not touched. parents: make the folder if it is missing.
    Raises InputError when `path` is a folder or its own folder is missing, ToolError when the system refuses.
    """
    path = Path(path)
    data = content.encode() if isinstance(content, str) else content
    if path.is_dir():
        raise InputError(f"cannot write {path}: it is a folder, a file name is wanted")
    if not parents and not path.parent.is_dir():
        raise InputError(f"cannot write {path}: the folder {path.parent} does not exist")
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.is_file() and path.read_bytes() == data:
            return
        try:
            with open(part, "wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())  # a full disk may say so only here
            os.replace(part, path)
        finally:
            part.unlink(missing_ok=True)
    except OSError as why:
        raise ToolError(f"cannot write {path}: {why.strerror or why}") from why
