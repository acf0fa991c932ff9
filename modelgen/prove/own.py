"""A secret of one's own: a case that somebody else made, and what is concealed in it."""

from __future__ import annotations

import hashlib
import json
import shutil
import tomllib
from pathlib import Path
from typing import Any

from modelgen.errors import InputError, did_you_mean
from modelgen.prove.diagnoser import Diagnoser
from modelgen.prove.keeper import Row, reveal
from modelgen.truths import Secret, write_case
from modelgen.truths.secret import DOMAINS

FIELDS = ("schema", "case", "effects", "base", "identifiable", "nonce", "note")
SCHEMA = "modelgen.secret/1"


def read_secret(path: Path) -> tuple[Secret, str, Path | None]:
    """The secret of a file, the file's text as it is sealed, and the case that goes with it.

    Two kinds of file are understood: {"schema": "modelgen.secret/1", "case": "case.toml", "effects": [ids],
    "base": {parameter: true value}, "nonce": "..."} with somebody's own case, and a secret that a run of
    `modelgen prove` has revealed, whose case is written anew. Raises InputError.
    """
    try:
        text = path.read_text(encoding="utf-8").rstrip("\n")
        data = json.loads(text)
    except (OSError, UnicodeDecodeError) as why:
        raise InputError(f"cannot read {path}: {why}") from None
    except json.JSONDecodeError as why:
        raise InputError(f"{path}, line {why.lineno}: no JSON: {why.msg}") from None
    if not isinstance(data, dict):
        raise InputError(f"{path}: holds {type(data).__name__}, a JSON object is wanted")
    if data.get("domain") in DOMAINS:
        return _drawn(path, text), text, None
    return _own(path, data), text, path.parent / data["case"]


def _drawn(path: Path, text: str) -> Secret:
    try:
        return Secret.from_json(text)
    except (TypeError, KeyError) as why:
        raise InputError(f"{path}: no secret that `modelgen prove` has revealed: {why}") from None


def _own(path: Path, data: dict[str, Any]) -> Secret:
    for name in data:
        if name not in FIELDS:
            raise InputError(
                f"{path}: no field '{name}'{did_you_mean(name, FIELDS)}; have {', '.join(FIELDS)}"
            )
    if data.get("schema") != SCHEMA:
        raise InputError(f'{path}: schema is {data.get("schema")!r}, "{SCHEMA}" is wanted')
    effects, base = data.get("effects"), data.get("base", {})
    if not isinstance(effects, list) or not all(isinstance(e, str) for e in effects):
        raise InputError(
            f"{path}: effects is {effects!r}, a list of ids is wanted ([] where nothing is missing)"
        )
    numbers = isinstance(base, dict) and all(isinstance(v, int | float) for v in base.values())
    if not numbers:
        raise InputError(f"{path}: base is {base!r}, a table of true parameter values is wanted")
    case = data.get("case")
    if not isinstance(case, str) or not (path.parent / case).is_file():
        raise InputError(f"{path}: case is {case!r}, the path of a case.toml relative to this file is wanted")
    told = tuple(data.get("identifiable", base))
    return Secret("own", tuple(effects), {}, base, "own", 0, kind="own", identifiable=told)


def prove_own(path: Path, scratch: Path, limit: float, announce: Any) -> Row:
    """Seal, diagnose elsewhere, reveal, score. `announce(digest)` is called before the diagnosis begins."""
    secret, text, case = read_secret(path)
    folder = scratch / "case"
    if case is None:
        write_case(secret, folder)
    else:
        _copy(case, folder)
    digest = hashlib.sha256(text.encode()).hexdigest()
    announce(digest)
    with Diagnoser(limit) as diagnoser:
        answer = diagnoser.diagnose(folder / "case.toml")
    return reveal(0, text, digest, folder, answer, secret) | {"followed": None}


def _copy(case: Path, folder: Path) -> None:
    """The case and the recordings that it names, and nothing else that may lie beside them."""
    folder.mkdir(parents=True)
    try:
        data = tomllib.loads(case.read_text(encoding="utf-8"))
        names = [str(r["file"]) for r in data["recording"]]
        models = [data["model"].rpartition(":")[0]] if ".py:" in data["model"] else []
    except (tomllib.TOMLDecodeError, KeyError, TypeError, AttributeError) as why:
        raise InputError(f"{case}: no case that can be read: {why}") from None
    shutil.copyfile(case, folder / "case.toml")
    for name in (*names, *models):
        target = folder / name
        if not (case.parent / name).is_file():
            raise InputError(f"{case}: there is no file '{name}'")
        if not target.resolve().is_relative_to(folder.resolve()):
            raise InputError(
                f"{case}: '{name}' is not in the folder of the case, where a secret's files must be"
            )
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(case.parent / name, target)
