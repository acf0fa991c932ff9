"""The models that ship, one file each, and `load`, which also reads a model from a file of the user's."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from modelgen.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from modelgen.language import Model

SHIPPED = (
    "magnetostrictive_transducer",
    "contact_damping",
    "modified_dahl",
    "complex_stiffness",
    "electrodynamic_transducer",
)
"""Ids of the models that ship; each is also an attribute of this package, made when first asked for."""


class _Package(ModuleType):
    """This package, in which a model hides the file of the same name that it stands in."""

    def __setattr__(self, name: str, value: Any) -> None:
        super().__setattr__(name, getattr(value, name, value) if name in SHIPPED else value)


# The import system sets a submodule as an attribute of its package.
sys.modules[__name__].__class__ = _Package


def __getattr__(name: str) -> Any:
    if name in SHIPPED:
        import_module(f"{__name__}.{name}")
        return globals()[name]
    raise AttributeError(f"module 'modelgen.models' has no attribute '{name}'{did_you_mean(name, SHIPPED)}")


def load(spec: str, folder: Path | str = ".") -> Model:
    """The model called `spec`: an id that ships, or "path/to/file.py:NAME", the path relative to `folder`.

    Raises InputError when there is no such model, and when the file cannot be read or run.
    """
    if spec in SHIPPED:
        return getattr(sys.modules[__name__], spec)
    path, _, name = spec.rpartition(":") if ".py:" in spec else (spec, "", "")
    if not path.endswith(".py"):
        raise InputError(
            f"unknown model '{spec}'{did_you_mean(spec, SHIPPED) or ';'} "
            f"it is one of {', '.join(SHIPPED)}, or path/to/file.py:NAME"
        )
    return _pick(path, name, _run(path, Path(folder) / path))


def _run(shown: str, file: Path) -> dict[str, Any]:
    """The global names of the user's file after running it."""
    import runpy

    if file.is_dir():
        raise InputError(f"'{shown}' is a folder, a Python file with a model in it is wanted")
    if not file.exists():
        near = did_you_mean(file.name, [p.name for p in file.parent.glob("*.py")])
        raise InputError(f"no file '{shown}'{near or ', wanted a Python file with a model in it'}")
    try:
        return runpy.run_path(str(file), run_name=file.stem)
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
    text = " ".join(str(why).split())
    says = text if isinstance(why, InputError) else f"{type(why).__name__}: {text}".rstrip(": ")
    return f"{shown}, line {line}: {says}" if line else f"{shown}: {says}"


def _pick(shown: str, name: str, names: dict[str, Any]) -> Model:
    """The model called `name` in the user's file; without a name, the only one."""
    from modelgen.language import Model

    models = [n for n, value in names.items() if isinstance(value, Model)]
    there = f"models in it: {', '.join(models)}" if models else "there is no Model in it"
    if not name and len(models) == 1:
        name = models[0]
    if not name:
        raise InputError(f"'{shown}' does not say which model; write {shown}:NAME, {there}")
    if name not in names:
        raise InputError(f"'{shown}' has no '{name}'{did_you_mean(name, models) or ';'} {there}")
    found = names[name]
    if not isinstance(found, Model):
        raise InputError(f"'{name}' in '{shown}' is of type {type(found).__name__}, not a Model; {there}")
    return found
