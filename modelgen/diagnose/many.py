"""Diagnoses of many cases, each a task of an executor."""

from __future__ import annotations

import json
import pickle
import tempfile
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from modelgen.diagnose.diagnosis import diagnose
from modelgen.effects import Effect
from modelgen.errors import InputError
from modelgen.files import write_together
from modelgen.fit.farm import packed
from modelgen.language import Model
from modelgen.recordings import Case

Verdict = dict[str, Any]


def diagnose_cases(
    cases: Mapping[str, tuple[Model, Case]],
    out: Path,
    *,
    effects: Sequence[Effect] | None = None,
    seed: int = 0,
    executor: Executor,
) -> dict[str, Verdict | InputError]:
    """The verdict (as in its JSON) on each case, by name; extended models go into out/name.

    A case that cannot be diagnosed gives its error, and stops no other. Raises ToolError when `out` can't be
    written.
    """
    futures = {
        name: executor.submit(_diagnosed, packed(model, case, effects), str(out / name), seed)
        for name, (model, case) in cases.items()
    }
    found: dict[str, Verdict | InputError] = {}
    for name, future in futures.items():
        verdict, files = future.result()
        write_together({out / name / file: text for file, text in files.items()}, parents=True)
        found[name] = verdict
    return found


def _diagnosed(origin: bytes, home: str, seed: int) -> tuple[Verdict | InputError, dict[str, bytes]]:
    """The verdict and the files that belong to it, which whoever asked writes: a worker may be far away."""
    model, case, effects = pickle.loads(origin)
    with tempfile.TemporaryDirectory(prefix="modelgen-") as name:
        folder = Path(name)
        try:
            text = diagnose(case, model, effects=effects, out=folder, seed=seed).to_json()
        except InputError as why:
            return why, {}
        files = {str(f.relative_to(folder)): f.read_bytes() for f in folder.rglob("*") if f.is_file()}
    return json.loads(text.replace(name, home)), files
