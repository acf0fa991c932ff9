"""What a proof was run with: versions, and a fingerprint of the code."""

from __future__ import annotations

import hashlib
import os
import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import modelgen

PAGES = ("about", "gallery", "leave_out", "note", "page", "pictures", "real", "scores", "studies")
SHOWING = {"cli", "export", "papers", "report", *(f"prove/{name}.py" for name in PAGES)}
"""What only shows an outcome, so that a run can go on after it was improved."""
PACKAGES = ("numpy", "scipy", "sympy", "casadi", "pysindy")


def versions() -> dict[str, str]:
    """Name -> version of what takes part; a package that isn't installed is left out."""
    found = {"modelgen": modelgen.__version__, "python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


@cache
def fingerprint() -> str:
    """The first 12 digits of the SHA-256 of the Python that a trial's outcome depends on."""
    root = Path(modelgen.__file__).parent
    whole = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        name = path.relative_to(root)
        if name.parts[0] not in SHOWING and name.as_posix() not in SHOWING:
            whole.update(name.as_posix().encode() + b"\0" + path.read_bytes())
    return whole.hexdigest()[:12]


def machine() -> str:
    """What it ran on, in a few words."""
    return f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores"


def facts() -> dict[str, Any]:
    """All of it, for a page."""
    return {"code": fingerprint(), "versions": versions(), "machine": machine()}
