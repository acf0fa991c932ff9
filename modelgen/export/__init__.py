"""Models outside of Python: C for a controller, units for a simulator."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from modelgen.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from modelgen.export.c99 import Settings
    from modelgen.language import Model

TARGETS = ("c99", "fmu")


def export(model: Model, target: str, folder: Path, settings: Settings | None = None) -> tuple[Path, ...]:
    """Write `model` for `target` into `folder` and return the paths of its files.

    Raises InputError for an unknown target or a wrong setting, ToolError when the folder can't be written.
    """
    if target not in TARGETS:
        near = did_you_mean(target, TARGETS) or ";"
        raise InputError(f"unknown target '{target}'{near} it is one of {', '.join(TARGETS)}")
    from modelgen.export.c99 import Settings, export_c99

    if target == "fmu" and settings and settings.fitter:
        raise InputError("--fitter belongs to --target c99: units are tuned by the tool that runs them")
    if target == "fmu":
        from modelgen.export.fmu import export_fmu

        return export_fmu(model, folder, settings or Settings())
    return export_c99(model, folder, settings or Settings())
