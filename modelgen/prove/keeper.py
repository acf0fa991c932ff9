"""What keeps the secrets: draws and seals them, writes the cases, and after a verdict reveals and scores."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from modelgen.errors import InputError
from modelgen.prove.baselines import rivals
from modelgen.prove.diagnoser import Answer
from modelgen.prove.gallery import glance
from modelgen.prove.own import OWN, Own, copy_case, opened
from modelgen.prove.plan import Task
from modelgen.prove.worker import VERDICT
from modelgen.truths import Secret, draw, score, seal, write_case
from modelgen.truths.secret import NotDetectable

Row = dict[str, Any]


@dataclass(frozen=True)
class Sealed:
    """A case that is written: the secret's text ("" if its maker withholds it) and the text's SHA-256.
    `hidden`: why there is none."""

    text: str
    sha256: str
    hidden: str = ""


def conceal(task: Task | Own, folder: Path) -> Sealed:
    """Draw a task's secret and write its case, or copy the case that somebody else made."""
    if isinstance(task, Own):
        if task.case is None:
            write_again(task, folder)
        else:
            copy_case(task.case, folder)
        return Sealed(task.text, task.sha256)
    effect = task.effects[0] if len(task.effects) == 1 else task.effects or None
    try:
        secret = draw(task.seed, task.kind, task.domain, effect, task.d2, task.noise, task.ratio)
    except NotDetectable as hidden:
        return Sealed("", "", str(hidden))
    write_case(secret, folder)
    return Sealed(*seal(secret))


def write_again(task: Own, folder: Path) -> None:
    """The case of a secret that a run has revealed. Raises InputError where its numbers make none."""
    try:
        write_case(opened(task.text, task.sha256), folder)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as why:
        raise InputError(f"{task.name}: no case can be made of this secret: {why!r}") from None


def reveal(index: int, sealed: Sealed, folder: Path, answer: Answer) -> Row:
    """The row of a trial: the secret, checked against its digest, and what the verdict in the folder got
    right; the verdict alone where the secret is withheld."""
    row = {
        "index": index,
        "sha256": sealed.sha256,
        "secret": sealed.text,
        "error": answer.error,
        "wall": answer.seconds,
        "cpu": answer.cpu,
        "foreign": list(answer.foreign),
    }
    verdict = {} if answer.error else json.loads((folder / VERDICT).read_text(encoding="utf-8"))
    if verdict:
        row |= {"verdict": summary(verdict), "glance": glance(folder)}
    if not sealed.text:
        return row | {"withheld": True}
    secret = opened(sealed.text, sealed.sha256)
    row |= told(secret)
    return row | score(secret, verdict) | {"rivals": rivals(secret, verdict, folder)} if verdict else row


def told(secret: Secret) -> Row:
    """What a table needs of a secret. Of somebody's own case nobody knows the best base: no depth, no R²."""
    drawn = secret.domain != OWN
    free = {n: abs(v) for n, v in secret.bent.items()}
    return {
        "domain": secret.domain,
        "kind": secret.kind,
        "effects": list(secret.effects),
        "variant": secret.variant,
        "noise": secret.noise,
        "stated": {None: "", 0.0: "not", 1.0: "rightly"}.get(secret.levels.get("stated"), "wrongly"),
        "d2": dict(secret.d2),
        "ratio": secret.ratio if drawn else None,
        "unexplained": 1 - secret.r2 if drawn else None,
        "parameters": len(secret.identifiable),
        "bent": max(free.values(), default=0.0),
        "bent_std": max((abs(v) for v in secret.bent_std.values()), default=0.0),
    }


def summary(verdict: Mapping[str, Any]) -> Row:
    """A verdict without its long parts."""
    kept = ("id", "port", "says", "probability", "equivalents", "separating_experiment")
    return {
        "adequate": verdict["adequate"],
        "summary": verdict.get("summary", ""),
        "effects": [{k: e.get(k) for k in kept} for e in verdict["effects"]],
        "fit": verdict["fit"],
        "foreseen": verdict.get("holdout_foreseen_over_noise"),
    }
