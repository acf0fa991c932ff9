"""`modelgen fit` and `modelgen diagnose` of a folder of cases, here or on a cluster."""

from __future__ import annotations

import json
from collections.abc import Mapping
from concurrent.futures import Executor
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from modelgen.api import open_case
from modelgen.cli.console import check_output, console, spare
from modelgen.cli.methods import read_method
from modelgen.errors import InputError
from modelgen.files import write_atomically
from modelgen.fit.farm import dask_executor, fit_cases, process_executor
from modelgen.language import Model
from modelgen.recordings import Case
from modelgen.report.table import table

Opened = dict[str, tuple[Model, Case]]


def fit_folder(
    folder: Path, file: Path | None, method: str, seed: int, dask: str, of_one: Mapping[str, Any]
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
    for name, result in zip(cases, results, strict=True):
        if isinstance(result, InputError):
            wrong[name] = str(result)
            continue
        found[name] = result.to_dict()
        over = result.rms_over_noise
        figures = [f"{over[k]:.3g}" if over[k] == over[k] else "" for k in ("fit", "holdout")]
        shown.add_row(name, result.model, *figures, f"{result.seconds:.2f}")
    console().print(shown)
    _finish(found, wrong, file, "modelgen.fits/1")


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
    for name, verdict in verdicts.items():
        if isinstance(verdict, InputError):
            wrong[name] = str(verdict)
            continue
        found[name] = verdict
        effects_found = ", ".join(e["id"] for e in verdict["effects"])
        over = verdict["fit"]["after"]["fit_rms_over_noise"]
        says = "adequate" if verdict["adequate"] else effects_found or "inadequate"
        shown.add_row(name, verdict["model"], says, "" if over is None else f"{over:.3g}")
    console().print(shown)
    _finish(found, wrong, file, "modelgen.verdicts/1")


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


def _executor(dask: str, tasks: int) -> AbstractContextManager[Executor]:
    """The cluster's, or processes on this machine."""
    return dask_executor(dask) if dask else process_executor(tasks)


def _finish(found: Mapping[str, Any], wrong: Mapping[str, str], file: Path | None, schema: str) -> None:
    """Write the JSON. Raises InputError when a case was wrong, after the others are safe."""
    if file is not None:
        cases = {**found, **{name: {"error": text} for name, text in wrong.items()}}
        text = json.dumps({"schema": schema, "cases": cases}, indent=1, ensure_ascii=False)
        write_atomically(file, text + "\n")
    if wrong:
        name, text = next(iter(wrong.items()))
        more = f" ({len(wrong) - 1} more cases failed)" if len(wrong) > 1 else ""
        raise InputError(f"{name}: {text}{more}")
