"""`modelgen diagnose`."""

from __future__ import annotations

from pathlib import Path

from modelgen.api import open_case
from modelgen.cli.console import check_output, console, progress_bar
from modelgen.diagnose import diagnose
from modelgen.errors import InputError
from modelgen.report import print_verdict, write_html

NO_PAGE = (".pdf", ".png", ".svg", ".jpg", ".jpeg", ".md", ".docx", ".json", ".csv")


def diagnose_case(
    path: Path, json: Path | None, report: Path | None, effects: str, out: Path, seed: int
) -> None:
    """Diagnose, print, and write what was asked for."""
    from modelgen.effects import load_effects

    check_output(json)
    check_output(report)
    if report is not None and report.suffix.lower() in NO_PAGE:
        raise InputError(f"--report {report}: the page is HTML, a name that ends in .html is wanted")
    check_output(out, folder=True)
    more = load_effects(effects) if effects else None
    model, case = open_case(path)
    with progress_bar(f"diagnosing {model.id}") as show:
        verdict = diagnose(case, model, effects=more, progress=show, out=out, seed=seed)
    if json is not None:
        verdict.write_json(json)
    if report is not None:
        write_html(verdict, report, case)
    print_verdict(verdict, console())
