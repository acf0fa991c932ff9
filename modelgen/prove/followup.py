"""The proposed experiment, made and added: does it tell apart what the first recordings could not?"""

from __future__ import annotations

import json
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from modelgen.prove.diagnoser import Diagnoser
from modelgen.prove.own import OWN
from modelgen.prove.worker import VERDICT
from modelgen.truths import Secret, write_case
from modelgen.truths.further import further
from modelgen.truths.scoring import accepted

Row = dict[str, Any]


def ambiguous(row: Row) -> bool:
    """Whether the verdict on a listed effect states a wrong name beside others that the data can't tell from
    it, and the device is ours, so that more can be recorded. (Laws between two effects have more than one
    right name.)"""
    if row.get("named") is None or (row.get("set_size") or 0) < 2 or row["domain"] == OWN:
        return False
    return not _only_right(row["secret"], row["verdict"])


def follow_up(row: Row, folder: Path, pool: Executor, diagnoser: Diagnoser) -> Row:
    """{"followed": None}: nothing to resolve; else whether a recording was proposed, and whether it
    resolved."""
    if not ambiguous(row):
        return {"followed": None}
    sentence = row["verdict"]["effects"][0]["separating_experiment"] or ""
    again = folder.with_name("again")
    if not pool.submit(record, row["secret"], sentence, again).result():
        return {"followed": {"sentence": sentence, "made": False, "resolved": False}}
    answer = diagnoser.diagnose(again / "case.toml")
    verdict = {} if answer.error else json.loads((again / VERDICT).read_text(encoding="utf-8"))
    return {"followed": {"sentence": sentence, "made": True} | told_apart(row["secret"], verdict)}


def record(text: str, sentence: str, folder: Path) -> bool:
    """Write the case with the proposed recording added; False where the sentence proposes none."""
    more = further(Secret.from_json(text), sentence)
    if more is not None:
        write_case(more, folder)
    return more is not None


def told_apart(text: str, verdict: Row) -> Row:
    """Resolved: the first name is right, and no wrong one is said to do as well."""
    first = _first(verdict)
    told = {"first": first["id"], "equivalents": first["equivalents"]}
    return told | {"resolved": _only_right(text, verdict)}


def _first(verdict: Row) -> Row:
    """The first claim; one without a name where there is none."""
    return dict((verdict.get("effects") or [{"id": "", "equivalents": []}])[0])


def _only_right(text: str, verdict: Row) -> bool:
    """Whether all names of the first claim are right."""
    first = _first(verdict)
    return {first["id"], *first["equivalents"]} <= set().union(*accepted(Secret.from_json(text)).values())
