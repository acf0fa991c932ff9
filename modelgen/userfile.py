"""Runs a Python file of the user's; what goes wrong in it becomes one line that says where."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from modelgen.errors import InputError, did_you_mean
from modelgen.files import leads_nowhere


def run_user_file(shown: str, file: Path, wanted: str) -> dict[str, Any]:
    """The global names of `file` after running it; `shown` is its name in messages, `wanted` what should be
    in it.

    Raises InputError with file, line and cause when it is not there, cannot be read, or fails.
    """
    import runpy

    if file.is_dir():
        raise InputError(f"'{shown}' is a folder, a Python file with {wanted} in it is wanted")
    if leads_nowhere(file):
        raise InputError(f"'{shown}' is a link that leads nowhere")
    if not file.exists():
        near = did_you_mean(file.name, [p.name for p in file.parent.glob("*.py")])
        wish = near or f", wanted a Python file with {wanted} in it"
        raise InputError(f"no file '{shown}' in {file.parent.resolve()}{wish}")
    try:
        # under a name of its own: it may be called as a module is that others import meanwhile
        return runpy.run_path(str(file), run_name=f"user_file_{file.stem}")
    except SyntaxError as why:
        where = shown if why.filename in (None, str(file)) else why.filename
        raise InputError(f"{where}, line {why.lineno or 1}: {why.msg}") from why
    except OSError as why:
        if why.filename == str(file):
            raise InputError(f"'{shown}' can't be read: {why.strerror}") from why
        raise InputError(_failure(shown, file, why)) from why
    except (Exception, SystemExit) as why:
        raise InputError(_failure(shown, file, why)) from why


def _failure(shown: str, file: Path, why: BaseException) -> str:
    """Where in the user's file it went wrong, and how, in one line."""
    line, frame = 0, why.__traceback__
    while frame is not None:
        if frame.tb_frame.f_code.co_filename == str(file):
            line = frame.tb_lineno
        frame = frame.tb_next
    return f"{shown}, line {line}: {told(why)}" if line else f"{shown}: {told(why)}"


def told(why: BaseException) -> str:
    """An error of the user's code in one line, with a hint where symbols were taken for numbers."""
    text = " ".join(str(why).split())
    if isinstance(why, InputError):
        return text
    hint = next((hint for says, hint in HINTS if isinstance(why, TypeError) and re.search(says, text)), "")
    return f"{type(why).__name__}: {text}".rstrip(": ") + hint


HINTS = (
    (
        "real number, not '?(Input|Parameter|Equation|Implicit|State)|expression to float|loop of ufunc",
        "; quantities are symbols: wanted sin, exp, … of modelgen.language, not of math or numpy",
    ),
    (
        "truth value of Relational",
        "; quantities are symbols: wanted Piecewise((a, x > 0), (b, True)), Max or Min of modelgen.language",
    ),
)
"""What Python, sympy and numpy say of a symbol in the place of a number, and what helps."""
