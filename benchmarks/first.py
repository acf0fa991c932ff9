"""From an expression to its first answer, to the fast library, from the cache: each in its own process."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile

SCRIPT = """
import json, time, numpy, casadi, jinja2
import modelgen.models as models
from modelgen.codegen import build, build_many
from modelgen.codegen.build import default_wrt
JUST = ('values', 'jacobian')
{warm}
model = models.{model}
start = time.perf_counter()
{make}
F(f=1000.0)
print(json.dumps(time.perf_counter() - start))
"""
MAKE = {
    "library with every kernel, -O3": "F = build(model)",
    "values and Jacobian alone, -O1": "(F,) = build_many([(model, default_wrt(model))], JUST)",
}
WARM = "from modelgen.codegen.emit import environment; environment()"


def seconds(make: str, model: str, folder: str) -> float:
    """Imports are not counted: a session has them."""
    script = SCRIPT.format(model=model, make=make, warm=WARM)
    env = {**os.environ, "MODELGEN_CACHE": folder}
    done = subprocess.run([sys.executable, "-c", script], env=env, capture_output=True, text=True, check=True)
    return float(json.loads(done.stdout))


def first_answers(rounds: int = 3) -> dict[str, tuple[float, float]]:
    """Seconds (anew, from the cache) of each way to build the electrodynamic and magnetostrictive models."""
    found = {}
    for model in ("electrodynamic_transducer", "magnetostrictive_transducer"):
        for name, make in MAKE.items():
            times = []
            for _ in range(rounds):
                with tempfile.TemporaryDirectory() as folder:
                    times.append((seconds(make, model, folder), seconds(make, model, folder)))
            found[f"{model}: {name}"] = (min(t[0] for t in times), min(t[1] for t in times))
    return found
