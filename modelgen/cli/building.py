"""`modelgen build` and `modelgen export`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from modelgen.cli.console import check_output, console, note, progress_bar
from modelgen.cli.fitted import fitted
from modelgen.codegen import Function, build, generate
from modelgen.codegen.roofline import Roof, roofline
from modelgen.errors import InputError
from modelgen.export import export
from modelgen.export.c99 import Settings
from modelgen.language import Model
from modelgen.models import SHIPPED, load
from modelgen.report.table import table

if TYPE_CHECKING:
    from rich.table import Table


def build_models(specs: Sequence[str], out: Path) -> None:
    """Compile all models before anything is written, then write their C and say what it costs to run."""
    check_output(out, folder=True)
    models = [load(spec) for spec in specs or SHIPPED]
    _check_ids(models)
    functions = [build(model) for model in models]  # the compiler works on several at a time
    for function in functions:
        function.tiers.library()  # a compiler that refuses says so before anything is written
    for model in models:
        generate(model, out)
    to = console()
    to.print(_rooflines(functions))
    to.print(f"C of {len(models)} model{'s' * (len(models) > 1)} in {out}")
    _note_kinds(models)


def _rooflines(functions: Sequence[Function]) -> Table:
    """What a point costs in each kernel, and how much of what the machine can do that is."""
    shown = table("model", "kernel", "operations", "ns a point", "limit [ns]", "limited by", "reached")
    shown.columns[1].justify = shown.columns[5].justify = "left"
    for function in functions:
        for k, roof in enumerate(roofline(function)):
            limit = "–" if roof.limit is None else f"{roof.limit:.2g}"
            name = "" if k else function.model.id
            cost = (str(roof.operations), f"{roof.reached:.3g}")
            shown.add_row(name, roof.kernel, *cost, limit, roof.by, _share(roof))
    return shown


def _share(roof: Roof) -> str:
    """Of the limit. Both are measured: what seems quicker than it can be is at the limit, within noise."""
    if roof.share is None:
        return "–"
    return f"{roof.share:.0%}" if roof.share < 1 else "at the limit"


def export_models(
    specs: Sequence[str], target: str, out: Path | None, settings: Settings, inverted: bool, fit: Path | None
) -> None:
    """Write models for `target`, all into one folder, and say which files there are.

    inverted: write the inverse of each beside it. fit: a result whose values are their defaults.
    """
    models = [load(spec) for spec in specs]
    models = models if fit is None else fitted(models, fit)
    if inverted:
        from modelgen.export.inverse import inverse

        models = [x for m in models for x in (m, inverse(m))]
    _check_ids(models)
    if settings.name and len(specs) > 1:
        raise InputError(f"--name {settings.name} is one name, and there are {len(specs)} models")
    folder = out or Path("export") / models[0].id
    check_output(folder, folder=True)
    each = settings_of(models, settings)
    to, files = console(), set[Path]()
    for m, s in zip(models, each, strict=True):
        with progress_bar(m.id) as show:
            show(0.0, "with exact values for its test")
            written = export(m, target, folder, s)
        for path in written:
            if path not in files:
                to.print(str(path), soft_wrap=True)
        files.update(written)
    _note_kinds(models)


def _note_kinds(models: Sequence[Model]) -> None:
    """Say where a port's kind is probably misspelt; in our own models none is."""
    if own := [model for model in models if not model.checked]:
        from modelgen.effects.kinds import unknown_kinds

        note(f"{model.id}, {text}" for model in own for text in unknown_kinds(model))


def settings_of(models: Sequence[Model], settings: Settings) -> list[Settings]:
    """Each model's part of the settings: a name that one of several models knows is meant for it.

    What none knows is left with the first, which says so. An inverse has its model's name with "_inverse".
    """
    found = []
    for k, m in enumerate(models):
        own = {p.name for p in m.scalar_parameters} | {i.name for i in m.inputs}
        others = {p.name for x in models for p in (*x.scalar_parameters, *x.inputs)} - own

        def mine(texts: Sequence[str], others: set[str] = others) -> list[str]:
            names = [t.partition("=")[0].strip() for t in texts]
            return [t for t, n in zip(texts, names, strict=True) if n not in others]

        name = f"{settings.name}_inverse" if settings.name and k else settings.name
        found.append(replace(settings, name=name, fix=mine(settings.fix), ranges=mine(settings.ranges)))
    return found


def _check_ids(models: Sequence[Model]) -> None:
    ids = [m.id for m in models]
    for id in ids:
        if ids.count(id) > 1:
            raise InputError(f"two models are called '{id}', and one's C would overwrite the other's")
