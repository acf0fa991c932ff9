"""`modelgen diagnose`."""

from __future__ import annotations

from pathlib import Path

from modelgen.api import open_case
from modelgen.cli.console import (
    check_output,
    check_outputs,
    check_page,
    console,
    progress_bar,
    spare,
)
from modelgen.diagnose import diagnose
from modelgen.report import print_verdict, write_html


def diagnose_case(
    path: Path, json: Path | None, report: Path | None, effects: str, out: Path, seed: int
) -> None:
    """Diagnose, print, and write what was asked for."""
    from modelgen.effects import load_effects

    check_outputs(json, report)
    check_page(report, "--report")
    check_output(out, folder=True)
    more = load_effects(effects) if effects else None
    model, case = open_case(path)
    spare(case.files, json, report)
    with progress_bar(f"diagnosing {model.id}") as show:
        verdict = diagnose(case, model, effects=more, progress=show, out=out, seed=seed)
    if json is not None:
        verdict.write_json(json)
    if report is not None:
        write_html(verdict, report, case, model)
    print_verdict(verdict, console())
