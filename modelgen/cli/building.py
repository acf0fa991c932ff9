"""`modelgen build` and `modelgen export`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from modelgen.cli.console import check_output, console, table
from modelgen.codegen import build, generate
from modelgen.errors import InputError
from modelgen.export import export
from modelgen.export.c99 import Settings
from modelgen.language import Model
from modelgen.models import SHIPPED, load


def build_models(specs: Sequence[str], out: Path) -> None:
    """Compile all models before anything is written, then write their C and say what it costs to run."""
    check_output(out, folder=True)
    models = [load(spec) for spec in specs or SHIPPED]
    _check_ids(models)
    functions = [build(model) for model in models]
    shown = table("model", "kernel", "operations per sample")
    shown.columns[1].justify = "left"
    for model, function in zip(models, functions, strict=True):
        generate(model, out)
        for k, kernel in enumerate(function.source.kernels):
            shown.add_row("" if k else model.id, kernel.name, str(kernel.operations), end_section=False)
    to = console()
    to.print(shown)
    to.print(f"C of {len(models)} model{'s' * (len(models) > 1)} in {out}")


def export_models(specs: Sequence[str], target: str, out: Path | None, settings: Settings) -> None:
    """Write models for `target`, all into one folder, and say which files there are."""
    models = [load(spec) for spec in specs]
    _check_ids(models)
    if settings.name and len(models) > 1:
        raise InputError(f"--name {settings.name} is one name, and there are {len(models)} models")
    folder = out or Path("export") / models[0].id
    check_output(folder, folder=True)
    to = console()
    files = dict.fromkeys(path for m in models for path in export(m, target, folder, settings))
    for path in files:
        to.print(str(path), soft_wrap=True)


def _check_ids(models: Sequence[Model]) -> None:
    ids = [m.id for m in models]
    for id in ids:
        if ids.count(id) > 1:
            raise InputError(f"two models are called '{id}', and one's C would overwrite the other's")
