"""The verdict in the terminal: short, and plain text where there is no terminal."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from modelgen.diagnose.verdict import Finding, Rms, Verdict
from modelgen.fit.result import Estimate
from modelgen.report import words
from modelgen.report.table import table

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

PARAMETERS = 3  # an effect's parameters that are named in its line


def print_verdict(verdict: Verdict, console: Console) -> None:
    """Print the verdict, what was left out, the fit before and after, and what to record next."""
    from rich.text import Text

    style = "bold green" if verdict.adequate and verdict.judged else "bold yellow"
    console.print(Text(words.headline(verdict), style=style))
    console.print(Text(words.summary(verdict)))
    if verdict.effects:
        console.print(_effects(verdict.effects))
    console.print(_fits(verdict))
    for label, text in _lines(verdict):
        console.print(Text.assemble((f"{label}: ", "bold"), text))


def _effects(effects: tuple[Finding, ...]) -> Table:
    from rich.text import Text

    made = table("left out", "port", "probability", "parameters", left=(0, 3))
    for e in effects:
        shown = [_parameter(p, e) for p in e.parameters[:PARAMETERS]]
        shown += [f"… {len(e.parameters) - PARAMETERS} more"] * (len(e.parameters) > PARAMETERS)
        made.add_row(*(Text(x) for x in (e.id, e.port, words.percent(e.probability), "\n".join(shown))))
    return made


def _parameter(p: Estimate, effect: Finding) -> str:
    name = p.name.removeprefix(f"{effect.id}_")
    told = "" if math.isfinite(p.std) or p.at_bound else " (not determined)"
    return f"{name} = {words.measured(p.value, p.std)} {words.unit_text(p.unit)}".rstrip() + told


def _fits(verdict: Verdict) -> Table:
    from rich.text import Text

    unit = words.unit_cell(verdict.unit)
    made = table("residual, rms", f"fit [{unit}]", "fit / noise", f"hold-out [{unit}]", "hold-out / noise")
    rows: list[tuple[str, Rms]] = [("before", verdict.before)]
    if verdict.effects:
        rows.append(("after", verdict.after))
    for name, rms in rows:
        figures = (rms.fit, rms.fit_over_noise, rms.holdout, rms.holdout_over_noise)
        made.add_row(name, *(Text(words.number(x)) for x in figures))
    return made


def _lines(verdict: Verdict) -> list[tuple[str, str]]:
    """Labelled sentences under the tables."""
    found = [
        ("Not told apart by these data", f"{e.id} and {words.in_english(e.equivalents)}")
        for e in verdict.effects
        if e.equivalents
    ]
    experiments = dict.fromkeys(e.separating_experiment for e in verdict.effects if e.separating_experiment)
    found += [("Next experiment", text) for text in experiments]
    found += [("Note", text) for text in verdict.notes]
    if verdict.extended_model:
        found.append(("Extended model", verdict.extended_model))
    return found
