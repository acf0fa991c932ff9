"""Cases of one's own: recordings that somebody else made, by a simulator or at a bench, with a sealed answer.

A trial is a folder with `case.toml`, its recordings, and `secret.json`:

    {"schema": "modelgen.secret/1", "case": "case.toml", "effects": ["inertia"], "base": {"k_D": 1.2},
     "nonce": "any random text", "note": "free text"}

`effects` holds ids of the contract, "novel:<anything>" for physics that no catalogue holds, [] for nothing;
`base` the true values of the model's parameters, where they are to be compared. Whoever doesn't want the
answer to be on the machine at all leaves `secret.sha256` in its place (as `sha256sum secret.json` prints it):
the case is diagnosed, and scored when the secret is laid beside it and the command is run again.
"""

from __future__ import annotations

import hashlib
import json
import math
import re
import shutil
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from modelgen.errors import InputError, did_you_mean, one_of
from modelgen.truths import Secret, unseal
from modelgen.truths.secret import DOMAINS, KINDS, NOISES

FIELDS = ("schema", "case", "effects", "base", "identifiable", "nonce", "note")
SCHEMA = "modelgen.secret/1"
OPEN, WITHHELD = "secret.json", "secret.sha256"
OWN = "own"


@dataclass(frozen=True)
class Own:
    """Somebody's own trial. `index` is of its name and digest, whatever others there are; `text` is "" as
    long as the secret is withheld; `case` is None for a secret that a run has revealed, whose case is
    written anew."""

    index: int
    name: str
    text: str
    sha256: str
    case: Path | None


def own_trials(path: Path) -> list[Own]:
    """The trial of a secret's file, or all trials in the folders below a folder. Raises InputError."""
    if not path.exists():
        raise InputError(f"{path}: no such file or folder")
    if not path.is_dir():
        return [_of_file(path, path.stem)]
    folders = sorted({p.parent for name in (OPEN, WITHHELD) for p in path.rglob(name)})
    if not folders:
        raise InputError(f"{path}: no folder in it holds a {OPEN} or a {WITHHELD}")
    names = [f.relative_to(path).as_posix() if f != path else f.name for f in folders]
    return [
        _of_file(f / OPEN, name) if (f / OPEN).exists() else _withheld(f / WITHHELD, name)
        for f, name in zip(folders, names, strict=True)
    ]


def _of_file(path: Path, name: str) -> Own:
    """Understood are one's own secret beside its case, and one that `modelgen prove` has revealed."""
    try:
        raw = path.read_bytes()
        text = raw.decode()
        data = json.loads(text)
    except (OSError, UnicodeDecodeError) as why:
        raise InputError(f"cannot read {path}: {why}") from None
    except json.JSONDecodeError as why:
        raise InputError(f"{path}, line {why.lineno}: no JSON: {why.msg}") from None
    if not isinstance(data, dict):
        raise InputError(f"{path}: holds {type(data).__name__}, a JSON object is wanted")
    if data.get("domain") in DOMAINS:
        text = text.rstrip("\n")  # as it was sealed
        digest = hashlib.sha256(text.encode()).hexdigest()
        _drawn(path, text)
        return Own(_index(name, digest), name, text, digest, None)
    _check(path, data)
    digest = hashlib.sha256(raw).hexdigest()
    if (sealed := path.with_name(WITHHELD)).exists() and _digest(sealed) != digest:
        raise InputError(f"{path}: its SHA-256 is {digest}, {WITHHELD} beside it says {_digest(sealed)}")
    return Own(_index(name, digest), name, text, digest, path.parent / data["case"])


def _withheld(path: Path, name: str) -> Own:
    digest = _digest(path)
    if not (path.parent / "case.toml").is_file():
        raise InputError(f"{path}: there is no case.toml beside it")
    return Own(_index(name, digest), name, "", digest, path.parent / "case.toml")


def _digest(path: Path) -> str:
    try:
        words = path.read_text(encoding="utf-8").split()
    except (OSError, UnicodeDecodeError) as why:
        raise InputError(f"cannot read {path}: {why}") from None
    if not words or not re.fullmatch("[0-9a-fA-F]{64}", words[0]):
        raise InputError(f"{path}: no SHA-256 of 64 hexadecimal digits, as sha256sum prints it")
    return words[0].lower()


def _index(name: str, digest: str) -> int:
    return int(hashlib.sha256(f"{name} {digest}".encode()).hexdigest()[:8], 16)


def opened(text: str, digest: str) -> Secret:
    """The secret of a revealed text. Raises ValueError where it isn't the one that was sealed."""
    data = json.loads(text)
    if data.get("schema") != SCHEMA:
        return unseal(text, digest)
    if hashlib.sha256(text.encode()).hexdigest() != digest:
        raise ValueError("the revealed secret isn't the one that was sealed")
    effects, base = tuple(data["effects"]), data.get("base", {})
    novel = any(e.startswith("novel:") for e in effects)
    kind = "novel" if novel else ("none", "single", "pair")[min(len(effects), 2)]
    told = tuple(data.get("identifiable", base))
    return Secret(OWN, effects, {}, base, OWN, 0, kind=kind, identifiable=told)


def _drawn(path: Path, text: str) -> None:
    """Raise InputError for what is no secret that a run has revealed."""
    data = json.loads(text)
    for name, (fits, wanted) in DRAWN.items():
        if name in data and not fits(data[name]):
            raise InputError(f"{path}: {name} is {_short(data[name])}, {wanted} is wanted")
    try:
        Secret.from_json(text)
    except (TypeError, KeyError) as why:
        raise InputError(f"{path}: no secret that `modelgen prove` has revealed: {why}") from None


def _number(x: object) -> bool:
    return isinstance(x, int | float) and not isinstance(x, bool) and math.isfinite(x)


def _numbers(x: object) -> bool:
    return isinstance(x, dict) and all(map(_number, x.values()))


def _names(x: object) -> bool:
    return isinstance(x, list) and all(isinstance(name, str) for name in x)


def _tables(x: object) -> bool:
    return isinstance(x, dict) and all(isinstance(table, dict) for table in x.values())


def _short(value: object) -> str:
    """A value as a message can show it."""
    return text if len(text := repr(value)) <= 60 else text[:57] + "..."


Fits = tuple[Callable[[Any], bool], str]
DRAWN: dict[str, Fits] = (
    dict.fromkeys(("effects", "identifiable"), (_names, "a list of names"))
    | dict.fromkeys(("base", "levels", "d2", "bent", "bent_std"), (_numbers, "a table of finite numbers"))
    | dict.fromkeys(("ratio", "r2"), (_number, "a finite number"))
    | {
        "seed": (lambda x: isinstance(x, int) and x >= 0, "a whole number of at least 0"),
        "strength": (_tables, "a table of each effect's numbers"),
        "setup": (lambda x: isinstance(x, dict), "a table"),
        "variant": (lambda x: isinstance(x, str), "the name of a law"),
        "kind": (lambda x: x in KINDS, f"one of {', '.join(KINDS)}"),
        "noise": (lambda x: x in NOISES, f"one of {', '.join(NOISES)}"),
    }
)
"""What the fields of a revealed secret hold, and how that is said."""


def _check(path: Path, data: dict[str, Any]) -> None:
    """Raise InputError for what is no secret of one's own."""
    for name in data:
        if name not in FIELDS:
            raise InputError(f"{path}: no field '{name}'{one_of(name, FIELDS)}")
    if data.get("schema") != SCHEMA:
        raise InputError(f'{path}: schema is {data.get("schema")!r}, "{SCHEMA}" is wanted')
    effects, base = data.get("effects"), data.get("base", {})
    if not isinstance(effects, list) or not _names(effects):
        raise InputError(
            f"{path}: effects is {effects!r}, a list of ids is wanted ([] where nothing is missing)"
        )
    if twice := next((e for e in effects if effects.count(e) > 1), ""):
        raise InputError(f"{path}: effects names '{twice}' {effects.count(twice)} times, once is wanted")
    if not _numbers(base):
        raise InputError(f"{path}: base is {base!r}, a table of true parameter values, all finite, is wanted")
    told = data.get("identifiable", [])
    if not isinstance(told, list) or not set(told) <= set(base):
        raise InputError(f"{path}: identifiable is {told!r}, a list of names in base is wanted")
    case = data.get("case")
    if not isinstance(case, str) or not (path.parent / case).is_file():
        raise InputError(f"{path}: case is {case!r}, the path of a case.toml relative to this file is wanted")
    listed = known_ids()
    for e in effects:
        if not e.startswith("novel:") and e not in listed:
            raise InputError(
                f"{path}: no effect '{e}'{did_you_mean(e, listed)}; novel:{e} is physics of no catalogue"
            )
    if base:
        _check_parameters(path, path.parent / case, base)


def _check_parameters(path: Path, case: Path, base: Mapping[str, float]) -> None:
    """Raise InputError where a true value is of a parameter that the case's model does not have."""
    from modelgen.models import load
    from modelgen.recordings import read_case_file

    told = read_case_file(case)
    model = load(told.model, told.path.parent)
    model = model.variant(**told.options) if told.options else model
    names = [p.name for p in model.scalar_parameters]
    for name in base:
        if name not in names:
            raise InputError(f"{path}: base has no '{name}' in {told.model}{one_of(name, names)}")


def known_ids() -> list[str]:
    """Ids of the catalogue."""
    from modelgen.effects import CATALOGUE

    return [e.id for e in CATALOGUE]


def copy_case(case: Path, folder: Path) -> None:
    """The case and the recordings that it names, and nothing else that lies beside. Raises InputError."""
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
