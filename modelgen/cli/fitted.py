"""Models with the values that a fit has found."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import isfinite
from pathlib import Path
from statistics import median
from typing import Any

from modelgen.cli.console import note
from modelgen.errors import InputError, did_you_mean
from modelgen.language import Model
from modelgen.language.defaults import with_defaults

SCHEMA = "modelgen.fit/1"


def fitted(models: Sequence[Model], path: Path) -> list[Model]:
    """`models`, the one that the result of `modelgen fit --json` is of with its values as defaults.

    Of what each recording has its own value of, it has the median. What the fit has not determined keeps the
    model's own default, and a note says so. Raises InputError where the file is no such result, or of none of
    these models, or names what the model has not.
    """
    result = _read(path)
    ids = [m.id for m in models]
    if result["model"] not in ids:
        raise InputError(f"{path}: a fit of '{result['model']}', wanted one of {' or '.join(ids)}")
    return [_filled(m, result["parameters"], path) if m.id == result["model"] else m for m in models]


def _filled(model: Model, found: Mapping[str, Any], path: Path) -> Model:
    own: dict[str, list[float]] = {}
    for name, x in found.items():
        value = x.get("value") if isinstance(x, dict) else None
        if not isinstance(value, int | float) or not isfinite(value):
            raise InputError(f"{path}: {name}: a finite value wanted, found {value!r}")
        told = [float(value)] if x.get("determined", True) else []
        own.setdefault(name.partition("[")[0], []).extend(told)
    known = [p.name for p in model.scalar_parameters]
    for name in own:
        if name not in known:
            raise InputError(f"{path}: '{model.id}' has no parameter '{name}'{did_you_mean(name, known)}")
    values = {name: median(x) for name, x in own.items() if x}
    if open_ := [name for name in own if name not in values]:
        note([f"{path}: not determined by the fit, left at the model's own default: {', '.join(open_)}"])
    return replace(with_defaults(model, values), builder=None, options=())


def _read(path: Path) -> dict[str, Any]:
    if not path.is_file():
        found = "a folder" if path.is_dir() else "no such file"
        raise InputError(f"{path}: {found}, wanted a result of `modelgen fit --json`")
    try:
        result = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as why:
        raise InputError(f"{path}: no result of `modelgen fit --json`: {why}") from None
    if (
        not isinstance(result, dict)
        or result.get("schema") != SCHEMA
        or not isinstance(result.get("parameters"), dict)
    ):
        raise InputError(f"{path}: no result of `modelgen fit --json` of one case (schema {SCHEMA})")
    return result
