"""Models with the values that a fit has found."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from math import isfinite
from pathlib import Path
from statistics import median
from typing import Any

from modelgen.cli.console import note
from modelgen.errors import InputError, did_you_mean
from modelgen.fit.uncertainty import NOTHING
from modelgen.language import Model
from modelgen.language.defaults import with_defaults

SCHEMA = "modelgen.fit/1"


def fitted(models: Sequence[Model], path: Path) -> list[Model]:
    """`models`, the one that the result of `modelgen fit --json` is of with its values as defaults.

    Of what each recording has its own value of, it has the median. What the data said nothing about keeps the
    model's own default, and a note says so; what they determine together with others is as good as they are.
    Raises InputError where the file is no such result, or of none of these models, or names what the model
    has not.
    """
    result = _read(path)
    ids = [m.id for m in models]
    if result["model"] not in ids:
        raise InputError(f"{path}: a fit of '{result['model']}', wanted one of {' or '.join(ids)}")
    hidden = {n for x in map(str, result.get("undetermined", ())) if x.startswith(NOTHING) for n in _names(x)}
    found = result["parameters"]
    return [_filled(m, found, hidden, path) if m.id == result["model"] else m for m in models]


def _names(sentence: str) -> list[str]:
    return re.findall(r"[^\s,]+", sentence.removeprefix(NOTHING))


def _filled(model: Model, found: Mapping[str, Any], hidden: Collection[str], path: Path) -> Model:
    own: dict[str, list[float]] = {}
    for name, x in found.items():
        value = x.get("value") if isinstance(x, dict) else None
        if not isinstance(value, int | float) or not isfinite(value):
            raise InputError(f"{path}: {name}: a finite value wanted, found {value!r}")
        own.setdefault(name.partition("[")[0], []).extend([] if name in hidden else [float(value)])
    known = [p.name for p in model.scalar_parameters]
    for name in own:
        if name not in known:
            raise InputError(f"{path}: '{model.id}' has no parameter '{name}'{did_you_mean(name, known)}")
    values = {name: median(x) for name, x in own.items() if x}
    if open_ := [name for name in own if name not in values]:
        note([f"{path}: the data had said nothing about {', '.join(open_)}: left at the model's own default"])
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
        or not isinstance(result.get("undetermined", []), list)
    ):
        raise InputError(f"{path}: no result of `modelgen fit --json` of one case (schema {SCHEMA})")
    return result
