"""Write the physics once; get fast C with exact derivatives, fits, and the physics that you left out.

import modelgen as mg
m = mg.models.magnetostrictive_transducer
f = mg.build(m)
fit = mg.fit(m, mg.read_case("case.toml"), method=mg.PSO(40) >> mg.IPOPT())
"""

from __future__ import annotations

import sys
from importlib import import_module
from inspect import signature
from types import ModuleType
from typing import TYPE_CHECKING, Any

from modelgen.errors import InputError, ModelgenError, ToolError, did_you_mean

if TYPE_CHECKING:
    from modelgen import diagnose, fit, models
    from modelgen.api import open_case, read_case
    from modelgen.codegen import build
    from modelgen.fit import IPOPT, PSO, Chain, GaussNewton, MultiStart, Recipe, Stage
    from modelgen.fit.modal import fit_modes
    from modelgen.language import Model
    from modelgen.papers.gmm.methods import METHOD_1, METHOD_2, METHOD_3
    from modelgen.recordings.frf import read_frf

__version__ = "0.1.0"

__all__ = [
    "IPOPT",
    "METHOD_1",
    "METHOD_2",
    "METHOD_3",
    "PSO",
    "Chain",
    "GaussNewton",
    "InputError",
    "Model",
    "ModelgenError",
    "MultiStart",
    "Recipe",
    "Stage",
    "ToolError",
    "__version__",
    "build",
    "diagnose",
    "fit",
    "fit_modes",
    "models",
    "open_case",
    "read_case",
    "read_frf",
]

_HOME = {
    "build": "codegen",
    "Model": "language",
    "read_case": "api",
    "open_case": "api",
    "fit_modes": "fit.modal",
    "read_frf": "recordings.frf",
    **dict.fromkeys(("IPOPT", "PSO", "Chain", "GaussNewton", "MultiStart", "Recipe", "Stage"), "fit"),
    **dict.fromkeys(("METHOD_1", "METHOD_2", "METHOD_3"), "papers.gmm.methods"),
}
_VERBS = {"fit": "modelgen.fit.fitting", "diagnose": "modelgen.diagnose"}


class _Verb(ModuleType):
    """A package that does what its name says when called: mg.fit(...), and still modelgen.fit.PSO."""

    @property
    def __wrapped__(self) -> Any:
        """The function that is called, whose arguments `inspect.signature` and editors show."""
        name = self.__name__.rpartition(".")[2]
        return getattr(import_module(_VERBS[name]), name)

    @property
    def __doc__(self) -> str:  # type: ignore[override]
        """What `help` shows first."""
        verb = self.__wrapped__
        return f"{verb.__name__}{signature(verb)}\n\n{verb.__doc__}"

    def __call__(self, *args: Any, **settings: Any) -> Any:
        return self.__wrapped__(*args, **settings)


class _Package(ModuleType):
    """This package; the import system sets a subpackage as its attribute, and verbs become callable then."""

    def __setattr__(self, name: str, value: Any) -> None:
        if name in _VERBS and isinstance(value, ModuleType):
            value.__class__ = _Verb
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(f"modelgen.{_HOME[name]}"), name)
    if name in _VERBS or name == "models":
        return import_module(f"modelgen.{name}")
    raise AttributeError(f"module 'modelgen' has no attribute '{name}'{did_you_mean(name, __all__)}")


def __dir__() -> list[str]:
    return __all__
