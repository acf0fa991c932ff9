"""Models outside of Python: C for a controller, units for a simulator."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from modelgen.errors import InputError, one_of

if TYPE_CHECKING:
    from modelgen.export.c99 import Settings
    from modelgen.language import Model

TARGETS = ("c99", "fmu")


def export(model: Model, target: str, folder: Path, settings: Settings | None = None) -> tuple[Path, ...]:
    """Write `model` for `target` into `folder` and return the paths of its files.

    Raises InputError for an unknown target or a wrong setting, ToolError when the folder can't be written.
    """
    if target not in TARGETS:
        raise InputError(f"unknown target '{target}'{one_of(target, TARGETS)}")
    from modelgen.export.c99 import Settings, export_c99

    settings = settings or Settings()
    if target == "fmu":
        from modelgen.export.fmu import export_fmu

        _check_for_unit(settings)
        return export_fmu(model, folder, settings)
    return export_c99(model, folder, settings)


def _check_for_unit(settings: Settings) -> None:
    """Raise InputError for what a unit for a simulator does not have."""
    wrong = {
        "--fitter": settings.fitter and "units are tuned by the tool that runs them",
        f"--real {settings.real}": settings.real != "double" and "variables of a unit are doubles",
        "--range": settings.ranges and "units come without a self-test",
    }
    for option, why in wrong.items():
        if why:
            raise InputError(f"{option} belongs to --target c99: {why}")
