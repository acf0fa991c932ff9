"""Numbers and verdicts as text, for the page and the terminal."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from modelgen.papers.number import Result, Verdict
from modelgen.papers.paper import Cell
from modelgen.papers.run import Judged, Reproduction
from modelgen.report.table import table
from modelgen.report.words import number, superscript, unit_cell

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

STYLE = {
    Verdict.REPRODUCED: "green",
    Verdict.NOT_REPRODUCIBLE: "yellow",
    Verdict.WRONG: "red",
    Verdict.GIVEN: "dim",
}


def printed(result: Result) -> str:
    """The printed digits, with the exponent raised: 4.3788·10⁻¹⁰."""
    mantissa, _, exponent = result.number.printed.lower().partition("e")
    text = mantissa.replace("-", "−")
    return f"{text}·10{superscript(int(exponent))}" if exponent else text


def ours(result: Result) -> str:
    """Ours to one digit more than printed, "–" where there is none."""
    if not math.isfinite(result.ours):
        return "–"
    mantissa, _, exponent = result.number.printed.lower().partition("e")
    decimals = len(mantissa.partition(".")[2]) + 1
    scaled = result.ours / 10.0 ** int(exponent or 0)
    if 10 ** (1 - decimals) > abs(scaled) > 0 or abs(scaled) > 20 * max(abs(float(mantissa)), 1):
        return number(result.ours, 4)
    text = f"{scaled:.{decimals}f}".replace("-", "−")
    return f"{text}·10{superscript(int(exponent))}" if exponent else text


def difference(result: Result) -> str:
    """Ours against the printed number: in per cent, or as a factor where they are far apart."""
    value = result.number.value
    if not math.isfinite(result.ours) or value == 0:
        return ""
    ratio = result.ours / value
    if ratio < 0:
        return "other sign"
    if not 0.2 < ratio < 5:
        return f"×{number(ratio)}"
    return f"{number(100 * (ratio - 1), 2)} %" if abs(ratio - 1) > 5e-7 else "0"


def cell(value: Cell) -> str:
    """An entry of a study's table."""
    return value if isinstance(value, str) else number(value, 4)


def print_reproduction(found: Reproduction, console: Console) -> None:
    """Each table, then each study, then the count."""
    for judged in found.papers:
        _print_paper(judged, console)
    console.print(_counts(found))
    if found.left_out:
        console.print(f"interrupted: {found.left_out} numbers and studies were not reached")
    console.print(f"{found.seconds:.1f} s")


def _print_paper(judged: Judged, console: Console) -> None:
    from rich.text import Text

    console.print(Text(judged.paper.title, style="bold"))
    for printed_table, results in judged.tables:
        made = table(
            printed_table.name,
            "quantity",
            "printed",
            "ours",
            "unit",
            "differs by",
            "verdict",
            left=(0, 1, 4, 6),
        )
        for r in results:
            n = r.number
            texts = (n.row, n.quantity, printed(r), ours(r), unit_cell(n.unit), difference(r))
            made.add_row(*(Text(t) for t in texts), Text(r.verdict.value, style=STYLE[r.verdict]))
        console.print()
        console.print(Text(printed_table.caption, style="dim"))
        console.print(made)
        for verdict in (Verdict.NOT_REPRODUCIBLE, Verdict.WRONG):
            for why in dict.fromkeys(r.why for r in results if r.verdict is verdict):
                console.print(Text.assemble((f"{verdict.value}: ", STYLE[verdict]), why))
    for study, outcome in judged.studies:
        console.print()
        console.print(Text(study.title, style="bold"))
        if outcome.columns:
            made = table(*outcome.columns, left=range(len(outcome.columns)) if outcome.prose else (0,))
            for row in outcome.rows:
                made.add_row(*(Text(cell(c)) for c in row))
            console.print(made)
        for line in outcome.says:
            console.print(Text(line))
    console.print()


def _counts(found: Reproduction) -> Table:
    made = table("numbers", *(v.value for v in Verdict), "all")
    for judged in found.papers:
        made.add_row(judged.paper.id, *(str(n) for n in judged.count.values()), str(len(judged.results)))
    return made
