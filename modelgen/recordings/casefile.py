"""The text of `case.toml`: syntax, structure and plain numbers, before any model is known."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from modelgen.errors import did_you_mean
from modelgen.recordings.table import HUGE, fail, read_text, show

ROLES = ("fit", "holdout")


@dataclass(frozen=True)
class RecordingSpec:
    """One [[recording]]: its file relative to the case, its role, and what is known for it alone."""

    file: str
    role: str
    constants: Mapping[str, float]
    noise: Mapping[str, float | tuple[float, float]] = field(default_factory=dict)


@dataclass(frozen=True)
class CaseFile:
    """A case as written. `options` go to the model's builder; numbers are in the units of the model."""

    path: Path
    model: str
    options: Mapping[str, Any]
    per_recording: tuple[str, ...]
    constants: Mapping[str, float]
    bounds: Mapping[str, tuple[float, float]]
    noise: Mapping[str, float | tuple[float, float]]
    recordings: tuple[RecordingSpec, ...]


def read_case_file(path: str | Path) -> CaseFile:
    """Read a case's TOML, without its tables. Raises InputError (one line, with the place) when malformed."""
    path = Path(path)
    text = read_text(path).replace("\r\n", "\n")
    try:
        data = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as why:
        if path.suffix.lower() != ".toml":
            raise fail(f"{path}: no case, wanted a .toml file that names a model and recordings") from why
        raise fail(_syntax(path, str(why), text)) from why
    where = str(path)
    keys = ("model", "options", "per_recording", "constants", "bounds", "noise", "recording")
    _check_keys(where, data, keys)
    return CaseFile(
        path=path,
        model=_text(f"{where}, model", data.get("model")),
        options=_table(f"{where}, [options]", data.get("options", {})),
        per_recording=_names(f"{where}, per_recording", data.get("per_recording", [])),
        constants=_numbers(f"{where}, [constants]", data.get("constants", {})),
        bounds=_bounds(f"{where}, [bounds]", data.get("bounds", {})),
        noise=_noise(f"{where}, [noise]", data.get("noise", {})),
        recordings=_recordings(path, data.get("recording")),
    )


def _syntax(path: Path, why: str, text: str) -> str:
    """tomllib says "what (at line 3, column 5)" or "what (at end of document)"; the place goes first."""
    found = re.fullmatch(r"(.*) \(at ((?:line (\d+))?.*)\)", why, re.DOTALL)
    if not found:
        return f"{path}: {why}"
    if found[3] and re.match(r"Cannot (declare|overwrite|mutate)|Duplicate", why):
        return f"{path}, line {found[3]}: {_twice(text.splitlines(), int(found[3]), found[1])}"
    quotes = ', text stands in quotes: "…"' if found[1] == "Invalid value" else ""
    return f"{path}, {found[2]}: {found[1]}{quotes}"


def _twice(lines: list[str], at: int, why: str) -> str:
    """What stands a second time in line `at`, counted from 1, and where it stood first."""
    if inline := re.search(r"inline table key (.+)", why):
        return f"{inline[1]} is given twice"
    names = [_named(line) for line in lines]
    while at > 1 and not names[at - 1]:  # a value may end some lines below its name
        at -= 1
    name, begin = names[at - 1], 0
    if not name.startswith("["):  # a key, of the table that it stands in
        begin = max((k for k, other in enumerate(names[: at - 1]) if other.startswith("[")), default=0)
    bare = name.strip("[]")
    first = next((k for k in range(begin, at - 1) if names[k].strip("[]") == bare), None)
    where = "" if first is None else f", first in line {first + 1}"
    if bare == "recording":
        return f"{name} stands beside another '{bare}'{where}: wanted [[recording]] for each"
    if name.startswith("["):
        return f"a second {name}{where}: wanted one, with all that is in both"
    return f"'{name}' is given twice{where}"


def _named(line: str) -> str:
    """The table that a line begins, in its brackets, or the key that it sets; "" for neither."""
    found = re.match(r"\s*(?:(\[+)\s*([^\[\]]+?)\s*(\]+)|([^=#\[\]]+?)\s*=)", line)
    return "".join(part or "" for part in found.groups()) if found else ""


def _check_keys(where: str, table: Mapping[str, Any], known: Iterable[str]) -> None:
    known = tuple(known)
    for key in table:
        if key not in known:
            hint = did_you_mean(key, known) or f", wanted one of {', '.join(known)}"
            raise fail(f"{where}: unknown key '{key}'{hint}")


def _text(where: str, value: object) -> str:
    if value is None:
        raise fail(f"{where}: missing")
    if not isinstance(value, str) or not value.strip():
        quotes = "" if isinstance(value, str) else " in quotes"
        raise fail(f"{where}: {show(value)} found, wanted text{quotes}")
    return value


def _table(where: str, value: object) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise fail(f"{where}: {show(value)} found, wanted a table of 'name = value'")
    return value


def _names(where: str, value: object) -> tuple[str, ...]:
    if not isinstance(value, list) or not all(isinstance(v, str) for v in value):
        raise fail(f"{where}: {show(value)} found, wanted a list of parameter names")
    for name in value:
        if value.count(name) > 1:
            raise fail(f"{where}: '{name}' occurs twice")
    return tuple(value)


def _number(where: str, value: object) -> float:
    if isinstance(value, str):
        hint = " (choices of a model belong in [options])" if "constants" in where else ""
        raise fail(f"{where} = {show(value)}: wanted a number{hint}")
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise fail(f"{where} = {show(value)}: wanted a number")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise fail(f"{where} = {show(value)}: wanted a finite number")
    if abs(number) > HUGE:
        raise fail(f"{where} = {show(value)}: too large for any unit")
    return number


def _numbers(where: str, value: object) -> dict[str, float]:
    return {k: _number(f"{where} {k}", v) for k, v in _table(where, value).items()}


def _pair(where: str, value: object, meaning: str) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise fail(f"{where} = {show(value)}: wanted {meaning}")
    return _number(where, value[0]), _number(where, value[1])


def _bounds(where: str, value: object) -> dict[str, tuple[float, float]]:
    bounds = {}
    for name, pair in _table(where, value).items():
        low, high = _pair(f"{where} {name}", pair, "[low, high]")
        if not low < high:
            raise fail(f"{where} {name} = [{low:g}, {high:g}]: wanted low below high")
        bounds[name] = (low, high)
    return bounds


def _noise(where: str, value: object) -> dict[str, float | tuple[float, float]]:
    noise: dict[str, float | tuple[float, float]] = {}
    for key, entry in _table(where, value).items():
        here = f"{where} {key}"
        pair = isinstance(entry, list)
        noise[key] = found = _pair(here, entry, "[rms, length in ln f]") if pair else _number(here, entry)
        if isinstance(found, tuple) and min(found) <= 0:
            raise fail(f"{here} = {list(found)}: wanted two numbers above zero")
        if isinstance(found, float) and found < 0:
            raise fail(f"{here} = {found:g}: a standard deviation can't be negative")
        levels = found if isinstance(found, tuple) else (found,)
        if not all(level == 0 or 1 / HUGE <= level <= HUGE for level in levels):
            raise fail(f"{here} = {show(entry)}: no such noise was ever measured")
    return noise


def _recordings(path: Path, value: object) -> tuple[RecordingSpec, ...]:
    if isinstance(value, dict):
        raise fail(f"{path}: [recording] stands in single brackets, wanted [[recording]] for each")
    if value is not None and not isinstance(value, list):
        raise fail(f"{path}: recording = {show(value)}, wanted [[recording]] and below it file = …")
    if not value:
        raise fail(f'{path}: no [[recording]], wanted at least one with role = "fit"')
    specs: list[RecordingSpec] = []
    seen: dict[Path, str] = {}
    for number, entry in enumerate(value, 1):
        where = f"{path}, recording {number}"
        _check_keys(where, _table(where, entry), ("file", "role", "constants", "noise"))
        file = _text(f"{where}, file", entry.get("file"))
        role = _text(f"{where} ('{file}'), role", entry.get("role", "fit"))
        if role not in ROLES:
            raise fail(f'{where} (\'{file}\'): unknown role {show(role)}, wanted "fit" or "holdout"')
        twin = seen.setdefault(Path(file), where)
        if twin != where:
            raise fail(f"{where}: file '{file}' is given twice")
        constants = _numbers(f"{where} ('{file}'), constants", entry.get("constants", {}))
        noise = _noise(f"{where} ('{file}'), noise", entry.get("noise", {}))
        specs.append(RecordingSpec(file, role, constants, noise))
    if all(spec.role != "fit" for spec in specs):
        raise fail(f'{path}: no recording has role = "fit", so there is nothing to fit')
    return tuple(specs)
