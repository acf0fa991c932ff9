"""Models by mpmath at 40 digits, and the reference values, for tests."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import mpmath as mp
import pytest

from modelgen.export.exact import dahl_step, run
from modelgen.language import Model, Output

__all__ = ["close", "dahl_step", "evaluate", "reference_table", "run"]

mp.mp.dps = 40
REFERENCE = Path(__file__).parents[2] / "shared" / "reference" / "reference_values.txt"


def evaluate(model: Model, upto: str = "", **values: Any) -> dict[str, Any]:
    """Quantities of a model without memory (those after `upto` are left out); parameters as in `run`."""
    if upto:
        at = [s.name for s in model.statements].index(upto) + 1
        model = replace(model, statements=model.statements[:at], outputs=(Output(upto),))
    inputs = {i.name for i in model.inputs}
    return run(model, [{k: v for k, v in values.items() if k in inputs}], **values)[0]


def close(found: Any, wanted: Any, digits: int = 18) -> bool:
    """Whether two numbers (or their decimal texts) agree to that many digits."""
    found, wanted = mp.mpmathify(found), mp.mpmathify(wanted)
    return bool(abs(found - wanted) <= abs(wanted) * mp.mpf(10) ** -digits)


def reference_table() -> dict[str, Any]:
    """The 20-digit reference values by their names; skips the test where there are none."""
    if not REFERENCE.exists():
        pytest.skip("no ../shared/reference/reference_values.txt beside the repository")
    values: dict[str, Any] = {}
    for line in REFERENCE.read_text().splitlines():
        words = line.split()
        if len(words) < 2 or line.startswith("#"):
            continue
        if words[-1].endswith("j"):
            values[" ".join(words[:-2])] = mp.mpc(words[-2], words[-1][:-1])
        else:
            values[" ".join(words[:-1])] = mp.mpf(words[-1])
    return values
