"""The C of a unit's self-test."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from modelgen.export.floats import literal, single
from modelgen.export.text import facts_of, members_of, render
from modelgen.export.unit import Unit
from modelgen.export.values import Trial
from modelgen.export.vectors import ALLOWANCE, Vector


def render_tests(unit: Unit, real: str, tried: Sequence[Trial], vectors: Sequence[Vector]) -> dict[str, str]:
    """The self-test's C by file name, and that of the fit where there is one."""
    texts = {f"{unit.prefix}_test.c": _render_test(unit, real, tried, vectors)}
    if unit.fitter:
        texts[f"{unit.prefix}_refit.c"] = _render_refit(unit, real, tried[0], vectors)
    return texts


def _render_test(unit: Unit, real: str, tried: Sequence[Trial], vectors: Sequence[Vector]) -> str:
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


def _render_refit(unit: Unit, real: str, trial: Trial, vectors: Sequence[Vector]) -> str:
    """A C file with `<prefix>_refit()`, which fits what the model gives at the first trial's inputs."""
    recorded = [v for v in vectors if v.trial == 0]
    facts = facts_of(unit, real) | members_of(unit) | {
        "real": real,
        "in": "&samples[i], " if unit.inputs else "",
        "samples": [[literal(x, real) for x in v.inputs] for v in recorded],
        "weights": [literal(1 / x if x else 1.0, "double") for x in _scales(unit, recorded[0])],
        "moved": list(_moved(unit, real, trial)),
    }  # fmt: skip
    return render("c99/refit.c", facts)


def _scales(unit: Unit, v: Vector) -> list[float]:
    """What the errors of the Jacobian's rows are judged by."""
    names = [s.name for s in unit.outputs]
    return [v.scale[names.index(row)] for row in unit.rows]


def _moved(unit: Unit, real: str, trial: Trial) -> Iterator[dict[str, str]]:
    """Parameters that can be moved, with bounds a tenth to either side, inside the model's. A tenth of zero
    is nothing: where all are zero, it is one of 1, and they move by a fifth of what the bounds leave."""
    members = {s.name: s.member for s in unit.parameters}
    for name in [n for n in unit.columns if trial.parameters[n]] or unit.columns:
        value, (low, high) = trial.parameters[name], unit.model.parameter(name).bounds
        size = abs(value) or 1.0
        low, high = max(low, value - size / 10), min(high, value + size / 10)
        if low < high:
            move = f"*= {literal(0.98, real)}" if value else f"= {literal((high or low) / 5, real)}"
            ends = {"low": literal(low, "double"), "high": literal(high, "double")}
            yield {"name": name, "member": members[name], "move": move, **ends}
