"""Compute every published number anew, and keep what was found as one value."""

from __future__ import annotations

import json
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from modelgen.files import write_atomically
from modelgen.fit.result import jsonable
from modelgen.papers.number import Result, Verdict, judge
from modelgen.papers.paper import Found, Paper, Study, Table

SCHEMA = "modelgen.reproduce/1"
Show = Callable[[float, str], None]  # part done, what is being done


@dataclass(frozen=True)
class Judged:
    """One paper with the result of each number, in the order of its tables, and of each study."""

    paper: Paper
    tables: tuple[tuple[Table, tuple[Result, ...]], ...]
    studies: tuple[tuple[Study, Found], ...]

    @property
    def results(self) -> tuple[Result, ...]:
        """Of all tables."""
        return tuple(r for _, results in self.tables for r in results)

    @property
    def count(self) -> dict[Verdict, int]:
        """How many numbers got each verdict."""
        found = Counter(r.verdict for r in self.results)
        return {v: found[v] for v in Verdict}


@dataclass(frozen=True)
class Reproduction:
    """All papers, judged."""

    papers: tuple[Judged, ...]
    seconds: float

    def to_dict(self) -> dict[str, Any]:
        """For JSON; a number that does not exist is null."""
        whole: dict[str, Any] = jsonable(
            {"schema": SCHEMA, "papers": [_paper(p) for p in self.papers], "seconds": self.seconds}
        )
        return whole

    def write_json(self, path: str | Path) -> None:
        """Write whole or not at all. Raises InputError or ToolError as `write_atomically` does."""
        text = json.dumps(self.to_dict(), indent=1, ensure_ascii=False, allow_nan=False)
        write_atomically(path, text + "\n")


def reproduce(papers: Sequence[Paper], show: Show | None = None) -> Reproduction:
    """Judge every number and run every study of `papers`."""
    began = time.perf_counter()
    tell = _Count(
        sum(len(t.numbers) for p in papers for t in p.tables) + sum(len(p.studies) for p in papers), show
    )
    return Reproduction(tuple(_judged(p, tell) for p in papers), time.perf_counter() - began)


def _judged(paper: Paper, tell: _Count) -> Judged:
    tables = []
    for table in paper.tables:
        results = []
        for number in table.numbers:
            tell(f"{table.name}, {number.row}")
            results.append(judge(number))
        tables.append((table, tuple(results)))
    studies = []
    for study in paper.studies:
        tell(study.title)
        studies.append((study, study.run()))
    return Judged(paper, tuple(tables), tuple(studies))


class _Count:
    """Tells how much of `total` has been begun."""

    def __init__(self, total: int, show: Show | None) -> None:
        self.total, self.show, self.begun = total, show, 0

    def __call__(self, text: str) -> None:
        if self.show is not None:
            self.show(self.begun / max(self.total, 1), text)
        self.begun += 1


def _paper(judged: Judged) -> dict[str, Any]:
    return {
        "paper": judged.paper.id,
        "title": judged.paper.title,
        "count": {v.value: n for v, n in judged.count.items()},
        "tables": [
            {"table": t.name, "caption": t.caption, "numbers": [_number(r) for r in results]}
            for t, results in judged.tables
        ],
        "studies": [
            {"title": s.title, "says": f.says, "columns": f.columns, "rows": f.rows}
            for s, f in judged.studies
        ],
    }


def _number(result: Result) -> dict[str, Any]:
    n = result.number
    return {
        "row": n.row,
        "quantity": n.quantity,
        "printed": n.value,
        "printed_as": n.printed,
        "ours": result.ours,
        "unit": n.unit,
        "rounding": n.rounding,
        "stated_uncertainty": n.within or None,
        "verdict": result.verdict.value,
        "how": n.how,
        "why": result.why,
    }
