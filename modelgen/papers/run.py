"""Compute every published number anew, and keep what was found as one value."""

from __future__ import annotations

import json
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from modelgen.files import write_atomically
from modelgen.fit.result import jsonable
from modelgen.papers.number import Result, Verdict, judge
from modelgen.papers.paper import Found, Paper, Study, Table

SCHEMA = "modelgen.reproduce/1"
Show = Callable[[float, str], None]  # part done, what is being done
Stop = Callable[[], int]


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
    """All papers, judged. left_out: numbers and studies that were not reached, as it was interrupted."""

    papers: tuple[Judged, ...]
    seconds: float
    left_out: int = 0

    def to_dict(self) -> dict[str, Any]:
        """For JSON; a number that does not exist is null."""
        whole: dict[str, Any] = jsonable(
            {
                "schema": SCHEMA,
                "papers": [_paper(p) for p in self.papers],
                "left_out": self.left_out,
                "seconds": self.seconds,
            }
        )
        return whole

    def write_json(self, path: str | Path) -> None:
        """Write whole or not at all. Raises InputError or ToolError as `write_atomically` does."""
        text = json.dumps(self.to_dict(), indent=1, ensure_ascii=False, allow_nan=False)
        write_atomically(path, text + "\n")


def reproduce(papers: Sequence[Paper], show: Show | None = None, stop: Stop = lambda: 0) -> Reproduction:
    """Judge every number and run every study of `papers`.

    stop: how often the user has asked to stop. Once: what is being computed is finished and kept. Twice: it
    is not, as an optimiser may have been cut short inside.
    """
    began = time.perf_counter()
    steps = _Steps(
        sum(len(t.numbers) for p in papers for t in p.tables) + sum(len(p.studies) for p in papers),
        show,
        stop,
    )
    judged = tuple(_judged(p, steps) for p in papers)
    reached = tuple(p for p in judged if p.tables or p.studies)
    return Reproduction(reached, time.perf_counter() - began, steps.total - steps.kept)


def _judged(paper: Paper, steps: _Steps) -> Judged:
    tables = []
    for table in paper.tables:
        results = [
            found[0]
            for n in table.numbers
            if (found := steps.take(f"{table.name}, {n.row}", partial(judge, n))) is not None
        ]
        tables += [(table, tuple(results))] if results else []
    studies = [
        (study, outcome[0])
        for study in paper.studies
        if (outcome := steps.take(study.title, study.run)) is not None
    ]
    return Judged(paper, tuple(tables), tuple(studies))


T = TypeVar("T")


class _Steps:
    """Takes one step after the other, tells how much of `total` has been begun, and stops when asked."""

    def __init__(self, total: int, show: Show | None, stop: Stop) -> None:
        self.total, self.show, self.stop, self.begun, self.kept = total, show, stop, 0, 0

    def take(self, text: str, step: Callable[[], T]) -> tuple[T] | None:
        """What `step` returns, None once it was asked to stop."""
        if self.stop():
            return None
        if self.show is not None:
            self.show(self.begun / max(self.total, 1), text)
        self.begun += 1
        try:
            found = step()
        except KeyboardInterrupt:
            if not self.stop():  # not one that was counted: an interrupt as it always is
                raise
            return None
        if self.stop() > 1:
            return None
        self.kept += 1
        return (found,)


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
