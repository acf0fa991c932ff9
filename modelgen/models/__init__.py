"""The models that ship, one file each, and `load`, which also reads a model from a file of the user's."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from modelgen.errors import InputError, did_you_mean, one_of
from modelgen.userfile import run_user_file

if TYPE_CHECKING:
    from modelgen.language import Model

SHIPPED = (
    "magnetostrictive_transducer",
    "contact_damping",
    "modified_dahl",
    "complex_stiffness",
    "electrodynamic_transducer",
    "piezoelectric_transducer",
    "kelvin_voigt",
    "bouc_wen",
    "lugre",
    "four_parameter_viscoelastic",
    "fractional_kelvin_voigt",
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
    if not spec.strip():
        raise InputError("unknown model '', wanted an id, or path/to/file.py:NAME")
    if (Path(folder) / path).is_dir():
        raise InputError(f"'{spec}' is a folder; wanted a model's id, or path/to/file.py:NAME")
    if not path.endswith(".py"):
        raise InputError(f"unknown model '{spec}'{one_of(spec, SHIPPED)}, or path/to/file.py:NAME")
    return _pick(path, name, run_user_file(path, Path(folder) / path, "a model"))


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
