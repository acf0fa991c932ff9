"""What a proof was run with: versions, and a fingerprint of the code."""

from __future__ import annotations

import hashlib
import os
import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import modelgen

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
    """The first 12 digits of the SHA-256 of all of modelgen's own Python."""
    root = Path(modelgen.__file__).parent
    whole = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        whole.update(str(path.relative_to(root)).encode() + b"\0" + path.read_bytes())
    return whole.hexdigest()[:12]


def machine() -> str:
    """What it ran on, in a few words."""
    return f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores"
