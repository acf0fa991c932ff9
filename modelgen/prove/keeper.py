"""What keeps the secrets: draws and seals them, writes the cases, and after a verdict reveals and scores."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from modelgen.prove.baselines import rivals
from modelgen.prove.diagnoser import Answer
from modelgen.prove.plan import Task
from modelgen.prove.worker import VERDICT
from modelgen.truths import Secret, draw, score, seal, unseal, write_case
from modelgen.truths.secret import NotDetectable

Row = dict[str, Any]
D2 = (30.0, 1e4)


def conceal(task: Task, folder: Path) -> tuple[str, str]:
    """Draw a task's secret and write its case; returns the sealed text and its SHA-256, or ("", why not)."""
    effect = task.effects[0] if len(task.effects) == 1 else task.effects or None
    try:
        secret = draw(task.seed, task.kind, task.domain, effect, D2, task.noise, task.ratio)
    except NotDetectable as hidden:
        return "", str(hidden)
    write_case(secret, folder)
    return seal(secret)


def reveal(
    index: int, text: str, digest: str, folder: Path, answer: Answer, own: Secret | None = None
) -> Row:
    """The row of a trial: the secret, checked against its digest, and what the verdict in the folder got
    right.

    own: the secret, where the text is somebody's own file; simpler methods are then not tried.
    """
    secret = own or unseal(text, digest)
    row = {
        "index": index,
        "sha256": digest,
        "secret": text,
        "error": answer.error,
        "wall": answer.seconds,
        "cpu": answer.cpu,
    }
    row |= told(secret)
    if answer.error:
        return row
    verdict = json.loads((folder / VERDICT).read_text(encoding="utf-8"))
    row |= score(secret, verdict)
    return row | {"verdict": summary(verdict), "rivals": {} if own else rivals(secret, verdict, folder)}


def told(secret: Secret) -> Row:
    """What a table needs of a secret."""
    free = {n: abs(v) for n, v in secret.bent.items()}
    return {
        "domain": secret.domain,
        "kind": secret.kind,
        "effects": list(secret.effects),
        "variant": secret.variant,
        "noise": secret.noise,
        "d2": dict(secret.d2),
        "ratio": secret.ratio,
        "unexplained": 1 - secret.r2,
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
    }
