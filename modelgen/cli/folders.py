"""`modelgen fit` and `modelgen diagnose` of a folder of cases, here or on a cluster."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from modelgen.api import open_case
from modelgen.cli.console import check_output, console, spare
from modelgen.cli.methods import read_method
from modelgen.errors import InputError
from modelgen.files import write_atomically
from modelgen.fit.farm import dask_executor, fit_cases, process_executor
from modelgen.language import Model
from modelgen.recordings import Case
from modelgen.report.table import table

if TYPE_CHECKING:
    from rich.table import Table

Opened = dict[str, tuple[Model, Case]]


def fit_folder(
    folder: Path, file: Path | None, method: str | None, seed: int, dask: str, of_one: Mapping[str, Any]
) -> None:
    """Fit each case in a folder; print a line for each, and write all results as one JSON.

    of_one: the options that make sense for one case alone. Raises InputError when one is given.
    """
    if given := [option for option, value in of_one.items() if value]:
        raise InputError(f"{given[0]} is for one case, and '{folder}' is a folder")
    check_output(file)
    chosen = read_method(method)
    cases, wrong = _opened(folder)
    spare((f for _, case in cases.values() for f in case.files), file)
    with _executor(dask, len(cases)) as executor:
        results = fit_cases(list(cases.values()), chosen, seed, executor=executor)
    shown = table("case", "model", "rms over noise", "held out", "seconds")
    found: dict[str, Any] = {}
    titles, remarks = _titles(cases), []
    for name, result in zip(cases, results, strict=True):
        if isinstance(result, InputError):
            wrong[name] = str(result)
            continue
        found[name] = result.to_dict()
        over = result.rms_over_noise
        figures = [_figure(over.get(k)) for k in ("fit", "holdout")]
        shown.add_row(titles[name], result.model, *figures, f"{result.seconds:.2f}")
        remarks += [f"{titles[name]}: {text}" for text in (*result.undetermined, *result.warnings)]
    _write(found, wrong, file, "modelgen.fits/1")
    _show(shown, remarks)
    _refuse(wrong)


def diagnose_folder(
    path: Path, file: Path | None, report: Path | None, effects: str, out: Path, seed: int, dask: str
) -> None:
    """Diagnose each case in a folder (or the one case); print a line for each, write all as one JSON."""
    from modelgen.diagnose.many import diagnose_cases
    from modelgen.effects import load_effects

    check_output(file)
    check_output(out, folder=True)
    if report is not None:
        raise InputError(f"--report {report} is of one case, diagnosed here; --json holds all")
    more = load_effects(effects) if effects else None
    cases, wrong = _opened(path)
    spare((f for _, case in cases.values() for f in case.files), file)
    with _executor(dask, len(cases)) as executor:
        verdicts = diagnose_cases(cases, out, effects=more, seed=seed, executor=executor)
    shown = table("case", "model", "verdict", "rms over noise")
    found: dict[str, Any] = {}
    titles = _titles(cases)
    for name, verdict in verdicts.items():
        if isinstance(verdict, InputError):
            wrong[name] = str(verdict)
            continue
        found[name] = verdict
        effects_found = ", ".join(e["id"] for e in verdict["effects"])
        over = verdict["fit"]["after"]["fit_rms_over_noise"]
        fits = "adequate" if verdict["judged"] else "too few values"
        says = fits if verdict["adequate"] else effects_found or "inadequate"
        shown.add_row(titles[name], verdict["model"], says, _figure(over))
    _write(found, wrong, file, "modelgen.verdicts/1")
    _show(shown)
    _refuse(wrong)


def _opened(path: Path) -> tuple[Opened, dict[str, str]]:
    """The cases in a folder by their paths in it without .toml, and what is wrong with others."""
    files = sorted(path.rglob("*.toml")) if path.is_dir() else [path]
    if not files:
        raise InputError(f"folder '{path}' holds no case: no file in it ends in .toml")
    cases: Opened = {}
    wrong: dict[str, str] = {}
    for file in files:
        name = str((file.relative_to(path) if path.is_dir() else Path(file.name)).with_suffix(""))
        try:
            cases[name] = open_case(file)
        except InputError as why:
            wrong[name] = str(why)
    return cases, wrong


def _titles(names: Iterable[str]) -> dict[str, str]:
    """What each case is called in a table: its folder where it is the one case in it, "01" for "01/case"."""
    names = tuple(names)
    folders = Counter(str(Path(name).parent) for name in names)
    alone = {name: str(Path(name).parent) for name in names if folders[str(Path(name).parent)] == 1}
    return {n: alone[n] if alone.get(n, ".") not in (".", *names) else n for n in names}


def _figure(value: float | None) -> str:
    return "–" if value is None or value != value else f"{value:.3g}"


def _show(shown: Table, remarks: Sequence[str] = ()) -> None:
    from rich.text import Text

    to = console()
    to.print(shown)
    for k, text in enumerate(remarks):
        to.print(Text("\n" * (k == 0) + text))


def _executor(dask: str, tasks: int) -> AbstractContextManager[Executor]:
    """The cluster's, or processes on this machine."""
    return dask_executor(dask) if dask else process_executor(tasks)


def _write(found: Mapping[str, Any], wrong: Mapping[str, str], file: Path | None, schema: str) -> None:
    if file is not None:
        cases = {**found, **{name: {"error": text} for name, text in wrong.items()}}
        text = json.dumps({"schema": schema, "cases": cases}, indent=1, ensure_ascii=False)
        write_atomically(file, text + "\n")


def _refuse(wrong: Mapping[str, str]) -> None:
    """Raise InputError when a case was wrong, once the others are safe."""
    if wrong:
        name, text = next(iter(wrong.items()))
        more = f" ({len(wrong) - 1} more cases failed)" if len(wrong) > 1 else ""
        raise InputError(f"{name}: {text}{more}")
