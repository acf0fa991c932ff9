"""The page: papers, their numbers with verdicts, studies and figures, as one HTML file without a script."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from markupsafe import Markup, escape

from modelgen.files import write_atomically
from modelgen.papers.number import Verdict
from modelgen.papers.paper import Figure
from modelgen.papers.run import Judged, Reproduction, Show
from modelgen.papers.show import cell, difference, ours, printed

_INDEX = re.compile(r"(?<![\w&])([^\W\d_]{1,2}'*)_([A-Za-z0-9]{1,4})(?![A-Za-z0-9_(])")
_POWER = re.compile(r"\^(\d+)\b")
REPEATED = 30  # a reason longer than this is printed once a table
CLASS = {
    Verdict.REPRODUCED: "same",
    Verdict.NOT_REPRODUCIBLE: "open",
    Verdict.WRONG: "wrong",
    Verdict.GIVEN: "given",
}


def write_page(found: Reproduction, path: str | Path, show: Show | None = None) -> None:
    """Draw the figures and write the page whole or not at all. Raises InputError or ToolError, one line."""
    write_atomically(path, page(found, show))


def page(found: Reproduction, show: Show | None = None) -> str:
    """The page as text."""
    from modelgen.report.html import template

    drawn: list[list[tuple[Figure, Markup]]] = []
    total = sum(len(p.paper.figures) for p in found.papers)
    for judged in found.papers:
        figures = []
        for k, figure in enumerate(judged.paper.figures):
            if show is not None:
                show(
                    (sum(len(done) for done in drawn) + k) / max(total, 1),
                    f"{judged.paper.id}, {figure.name}",
                )
            figures.append((figure, _drawn(figure, f"{judged.paper.id}{k}")))
        drawn.append(figures)
    return str(
        template("reproduce.html.j2").render(
            found=found,
            papers=[_paper(p, figures) for p, figures in zip(found.papers, drawn, strict=True)],
            verdicts=[(v.value, CLASS[v], sum(p.count[v] for p in found.papers)) for v in Verdict],
            cell=cell,
            sub=lowered,
        )
    )


def _paper(judged: Judged, figures: list[tuple[Figure, Markup]]) -> dict[str, Any]:
    tables = []
    for table, results in judged.tables:
        said: set[str] = set()
        rows = [
            {
                "n": r.number,
                "how": _once(r.number.how, said),
                "printed": printed(r),
                "ours": ours(r),
                "difference": difference(r),
                "class": CLASS[r.verdict],
                "verdict": r.verdict.value,
                "why": _once(r.why, said),
            }
            for r in results
        ]
        tables.append({"name": table.name, "caption": table.caption, "rows": rows})
    count = [(v.value, CLASS[v], n) for v, n in judged.count.items()]
    return {"judged": judged, "count": count, "tables": tables, "figures": figures}


def _once(text: str, said: set[str]) -> str:
    """The text where it stands first in a table, and a mark where it would be repeated at length."""
    if text in said and len(text) > REPEATED:
        return "as above"
    said.add(text)
    return text


def lowered(text: str | Markup) -> Markup:
    """Text with indices lowered, R_f as R with a small f, and whole powers raised; a name of several parts,
    k_D_M, stays."""
    low = _INDEX.sub(r"\1<sub>\2</sub>", str(escape(text)))
    return Markup(_POWER.sub(r"<sup>\1</sup>", low))


def _drawn(figure: Figure, key: str) -> Markup:
    from matplotlib.figure import Figure as Canvas

    from modelgen.report import svg

    with svg.style():
        canvas = Canvas(figsize=figure.size, layout="constrained")
        figure.draw(canvas)
        return Markup(svg.inline(canvas, f"{figure.name}: {figure.title}", key))
