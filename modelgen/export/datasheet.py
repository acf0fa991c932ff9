"""DATASHEET.md: what a unit costs, how right it is, over which inputs; a section for each model."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from modelgen.errors import ToolError
from modelgen.export import arm
from modelgen.export.exact import stable_step
from modelgen.export.floats import literal
from modelgen.export.host import Compiled, Reach, measured_errors, reach
from modelgen.export.selftest import render_tests
from modelgen.export.text import REALS, facts_of, in_precision, render, render_c
from modelgen.export.unit import Unit
from modelgen.export.values import Range, Trial, default_of, default_range
from modelgen.export.vectors import Vector

TITLE = "# Datasheet\n\nMeasured by modelgen when it wrote the C beside this file.\n"


@dataclass(frozen=True)
class Sheet:
    """What was measured. Where a tool is absent its part is empty, and the word for it says why.

    stable: the longest step over which states are integrated stably, at default parameters; inf where any is.
    """

    prints: tuple[tuple[str, arm.Footprint], ...]
    absent: str
    errors: dict[str, dict[str, float]]
    no_compiler: str
    reaches: tuple[Reach, ...]
    stable: float

    def failures(self, real: str) -> tuple[str, ...]:
        """The cores on which the self-test of that precision failed in the emulator."""
        return tuple(f.core for r, f in self.prints if r == real and not f.passed)


Tested = Mapping[str, tuple[tuple[Trial, ...], tuple[Vector, ...]]]
"""Trials and their vectors in each precision."""


def take(unit: Unit, real: str, ranges: Mapping[str, Range], tested: Tested, emulator: bool = True) -> Sheet:
    """Measure `unit` in both precisions, with what tools there are; `emulator` or this machine alone."""
    made = {r: (render_c(unit, r), *tested[r]) for r in REALS}
    missing = arm.missing_tools() if emulator else ()
    prints = (
        []
        if missing or not emulator
        else [(r, _on(core, unit, r, *made[r])) for r in REALS for core in arm.CORES]
    )
    prints.sort(key=lambda pair: [c.name for c in arm.CORES].index(pair[1].core))
    errors: dict[str, dict[str, float]] = {}
    reaches: tuple[Reach, ...] = ()
    says = ""
    try:
        for r in REALS:
            compiled = Compiled(unit, r, made[r][0])
            errors[r] = measured_errors(compiled, *made[r][1:])
            if r == real:
                reaches = reach(compiled, r, made[r][1][0], made[r][2][0].scale, ranges)
    except ToolError as why:
        says, errors, reaches = str(why), {}, ()
    verb = "is" if len(missing) == 1 else "are"
    absent = f"{' and '.join(missing)} {verb} not installed" if missing else "nobody asked for it"
    usual = made[real][1][0]
    stable = stable_step(unit.model, usual.samples[0], **usual.parameters) if unit.steps else float("inf")
    return Sheet(tuple(prints), absent, errors, says, reaches, stable)


def _on(
    core: arm.Core,
    unit: Unit,
    real: str,
    files: dict[str, str],
    tried: Sequence[Trial],
    vectors: Sequence[Vector],
) -> arm.Footprint:
    return arm.measure(core, unit.prefix, files | emulator_files(unit, real, tried, vectors))


def emulator_files(
    unit: Unit, real: str, tried: Sequence[Trial], vectors: Sequence[Vector]
) -> dict[str, str]:
    """The self-test, and a program around it for the emulated board that counts instructions and stack."""
    facts = facts_of(unit, real) | {"vectors": vectors, "per_tick": arm.TICK}
    facts["recorded"] = sum(v.trial == 0 for v in vectors)
    texts = {n: render(f"arm/{n}", facts) for n in ("startup.c", "board.ld")}
    texts["measure.c"] = in_precision(render("arm/measure.c", facts), real)
    return texts | render_tests(unit, real, tried, vectors)


def render_sheet(unit: Unit, real: str, sheet: Sheet, ranges: Mapping[str, Range], vectors: int) -> str:
    """The unit's section, Markdown."""
    facts = facts_of(unit, real)
    prints = [
        {
            **{k: getattr(f, k) for k in ("own_flash", "flash", "static_ram", "frame")},
            **{name: f"{c.usual} ({c.most})" for name, c in f.costs.items()},
            "where": f"{f.core} {r}", "sizes": f"{f.parameters}, {f.state}",
            "fit": f"{f.fit_flash}, {f.fit_workspace}, {f.fit_cost or 'more than counted'}",
            "worst_stack": max(c.stack for c in f.costs.values()), "says": "passed" if f.passed else "FAILED",
        }
        for r, f in sheet.prints
    ]  # fmt: skip
    code = render_c(unit, real)[f"{unit.prefix}.c"]
    facts |= {
        "real": real, "prints": prints, "tools": arm.versions() if prints else ("", ""),
        "absent": sheet.absent, "errors": sheet.errors, "no_compiler": sheet.no_compiler, "vectors": vectors,
        "in": "&in, " if unit.inputs else "", "inputs": _inputs(unit, sheet.reaches, ranges),
        "parameters": _parameters(unit), "loops": "for (" in code or "while (" in code,
        "says": _plain(unit.model.text or unit.model.id), "origin": _plain(unit.model.source or "not stated"),
        "notes": [*_notes(unit), *_of_steps(unit, sheet.stable)], "deviations": _deviations(code),
        **_example(unit),
    }  # fmt: skip
    return render("c99/DATASHEET.md", facts)


def merge(old: str, prefix: str, section: str) -> str:
    """The folder's datasheet with the model's section put in or replaced, in the order of names."""
    parts = {m[1]: m[0].strip() for m in re.finditer(r"^## (\w+)\n.*?(?=^## |\Z)", old, re.S | re.M)}
    parts[prefix] = section.strip()
    return "\n".join([TITLE, *(parts[name] + "\n" for name in sorted(parts))])


def _inputs(unit: Unit, reaches: Sequence[Reach], ranges: Mapping[str, Range]) -> list[dict[str, Any]]:
    found = {r.name: r for r in reaches}
    derived = {i.name: i for i in unit.model.inputs}
    rows = []
    for s in unit.inputs:
        i, r = derived.get(s.name), found.get(s.name)
        tested = (
            "one step"
            if i is None
            else "with it"
            if i.derived
            else "{:g} to {:g}".format(*ranges.get(i.name, default_range(i)))
        )
        rows.append(
            {
                "name": f"`{s.member}`", "unit": s.unit, "tested": tested,
                "right": f"{r.low:.3g} to {r.high:.3g}" if r else "not measured",
                "below": (r.below or "not tried") if r else "",
                "above": (r.above or "not tried") if r else "",
            }
        )  # fmt: skip
    return rows


def _parameters(unit: Unit) -> list[dict[str, str]]:
    return [
        {
            "name": f"`{s.member}`", "unit": s.unit, "value": f"{default_of(p):.6g}",
            "range": "{:g} to {:g}".format(*p.bounds), "text": _plain(p.text),
        }
        for s in unit.parameters
        for p in [unit.model.parameter(s.name)]
    ]  # fmt: skip


def _notes(unit: Unit) -> list[str]:
    """What a caller of a time model must know of inputs that a recording would have had smoothed."""
    members = {s.name: s.member for s in unit.inputs}
    kinds = {i.derived[0]: i for i in unit.model.inputs if i.derived and i.name in members}
    notes = []
    for kind in ("rate", "acceleration", "amplitude", "quadrature"):
        if kind in kinds:
            i = kinds[kind]
            notes.append(f"`{members[i.name]}` is the caller's: {_plain(i.text)}, as it is at the sample.")
    turning = [i for i in unit.model.inputs if i.derived and i.derived[0] == "turning"]
    if turning:
        of = turning[0].derived[1] if turning[0].derived else ""
        notes.append(
            f"Between two samples `{of}` is taken to run one way; who knows where it turned steps there, too."
        )
    return notes


def _of_steps(unit: Unit, stable: float) -> list[str]:
    """How long a step may be."""
    if not math.isfinite(stable):
        return []
    parts = max(s.substeps for s in unit.model.states if s.rate is not None)
    size = f"{stable:.2g} {unit.model.inputs[0].unit}"
    ways = f"in {parts} parts of a step" if parts > 1 else "in one"
    return [
        f"States are integrated by the classical Runge–Kutta scheme {ways}: with default parameters, from "
        f"the first sample of the tests, a `{unit.step}` of more than {size} is unstable, a tenth of it "
        f"accurate."
    ]


def _example(unit: Unit) -> dict[str, str]:
    """Bounds of the first parameter that can be fitted, for an example."""
    if not unit.columns:
        return {}
    low, high = unit.model.parameter(unit.columns[0]).bounds
    return {"low": literal(low, "double"), "high": literal(high, "double")}


def _plain(text: str) -> str:
    """A model's text in one cell of a Markdown table, without markup."""
    return re.sub(r"([|<>`\\*\[\]])", r"\\\1", " ".join(text.split()))


def _deviations(code: str) -> str:
    """Rules that this very C departs from."""
    found = []
    if "break;" in code:
        found.append("15.4 (advisory, one break a loop) holds, the loop over Newton steps ends by `break`;")
    return " ".join(found)
