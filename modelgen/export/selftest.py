"""The C of a unit's self-test."""

from __future__ import annotations

from collections.abc import Sequence

from modelgen.export.floats import literal, single
from modelgen.export.text import facts_of, render
from modelgen.export.unit import Unit
from modelgen.export.values import Trial
from modelgen.export.vectors import ALLOWANCE, Vector


def render_test(unit: Unit, real: str, tried: Sequence[Trial], vectors: Sequence[Vector]) -> str:
    """A C file with `<prefix>_test()`, which prints the worst errors and returns the number of failures."""

    def row(values: Sequence[float]) -> list[str]:
        return [literal(v, "double") for v in values]

    facts = facts_of(unit, real) | {
        "allowance": f"{ALLOWANCE:g}",
        "in": "&v->in, " if unit.inputs else "",
        "sets": [row([t.parameters[s.name] for s in unit.parameters] or [0.0]) for t in tried],
        "vectors": [
            {
                "set": v.trial, "first": int(v.first), "inputs": row(v.inputs), "wanted": row(v.wanted),
                "scale": row(v.scale), "allowed": row(v.allowed),
            }
            for v in vectors
        ],
        "jacobians": [[[row(e) for e in entries] for entries in v.jacobian] for v in vectors if v.jacobian],
    }  # fmt: skip
    text = render("c99/test.c", facts)
    return single(text) if real == "float" else text
