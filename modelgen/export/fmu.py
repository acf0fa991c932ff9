"""`modelgen export --target fmu`: co-simulation units of FMI 2.0 and 3.0, with sources and a binary."""

from __future__ import annotations

import hashlib
import io
import platform
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any

import sympy as sp

from modelgen.codegen.compiler import find_compiler
from modelgen.codegen.ctext import number
from modelgen.errors import InputError, ToolError
from modelgen.export.c99 import Settings
from modelgen.export.fmi import stubs
from modelgen.export.rewrite import step_name
from modelgen.export.routines import make_unit
from modelgen.export.text import facts_of, render, render_c
from modelgen.export.unit import Unit
from modelgen.export.values import default_of, default_range, parse_fixed
from modelgen.files import write_together
from modelgen.language import Equation, Input, Model, State
from modelgen.language.derived import per, values_before
from modelgen.language.quantities import BACKWARD
from modelgen.units import PURE, factor

VERSIONS = (2, 3)


def export_fmu(model: Model, folder: Path, settings: Settings) -> tuple[Path, ...]:
    """Write `NAME_fmi2.fmu` and `NAME_fmi3.fmu`; the same model gives the same bytes with the same compiler.

    Inputs of a step hold at its end. Rates and accelerations of an input are differences over the step.
    Raises InputError for a wrong setting, ToolError when there is no C compiler or no place to write.
    """
    alone = stand_alone(model)
    unit = make_unit(alone, parse_fixed(alone, settings.fix), prefix=settings.name)
    made = {folder / f"{unit.prefix}_fmi{v}.fmu": _zipped(_content(unit, v)) for v in VERSIONS}
    write_together(made, parents=True)
    return tuple(made)


def stand_alone(model: Model) -> Model:
    """`model` with what follows from an input's motion computed from the input as it comes, step by step."""
    used = {s.name for x in model.statements for s in _free(x)}
    moving = [i for i in model.inputs if i.derived and i.derived[0] not in BACKWARD]
    moving = [i for i in moving if i.name in used or i.derived[0] == "rate"]  # type: ignore[index]
    if not moving:
        return model
    other = [i for i in moving if i.derived and i.derived[0] not in ("rate", "acceleration")]
    if other:
        raise InputError(
            f"model '{model.id}' needs '{other[0].name}' ({other[0].text}), which no single step can tell"
        )
    formed = {i.name for i in moving}
    before = values_before(model)
    inputs = {i.name: i for i in model.inputs if i not in moving and before.get(i.name) not in formed}
    t = model.inputs[0]
    since = t.symbol - _previous(inputs, t).symbol
    dt = Equation(step_name(model), since, t.unit, text="time since the step before")
    equations, states = [dt], dict[str, State]()
    for i in sorted(moving, key=lambda i: i.derived != ("rate", (i.derived or "  ")[1])):
        kind, of = i.derived or ("", "")
        x = inputs[of]
        if kind == "rate":
            change, scale = x.symbol - _previous(inputs, x).symbol, per(x.unit, t.unit, 1, i.unit)
        else:
            v = next((m for m in moving if m.derived == ("rate", of)), None)
            if v is None:
                raise InputError(f"model '{model.id}' needs '{i.name}' but not the rate of '{of}'")
            change, scale = v.symbol - _last(states, v), per(v.unit, t.unit, 1, i.unit)
        rise = change / dt.symbol if scale == 1 else scale * change / dt.symbol
        # a state is integrated from where a step begins, and there is no way yet
        begin = _last(states, i) if i.name in before.values() else 0
        expr = sp.Piecewise((rise, dt.symbol > 0), (begin, True))
        equations.append(Equation(i.name, expr, i.unit, text=i.text))
    return replace(
        model,
        inputs=tuple(inputs.values()),
        statements=(*equations, *model.statements, *states.values()),
        ports=(),
        checked=True,
    )


def _last(states: dict[str, State], i: Input) -> sp.Symbol:
    """The value of `i` at the step before, kept by a state that is added where there is none."""
    name = f"{i.name}_last"
    states[name] = State(name, 0, update=i.symbol, unit=i.unit, text=f"{i.name} of the step before")
    return sp.Symbol(name, real=True)


def _free(statement: Any) -> set[Any]:
    parts = (getattr(statement, k, None) for k in ("expr", "update", "rate", "residual"))
    return set().union(*(p.free_symbols for p in parts if p is not None))


def _previous(inputs: dict[str, Input], x: Input) -> Input:
    """The input that holds the value before of `x`, added where there is none."""
    for i in inputs.values():
        if i.derived == ("previous", x.name):
            return i
    made = Input(f"{x.name}_prev", x.unit, derived=("previous", x.name))
    return inputs.setdefault(made.name, made)


def _content(unit: Unit, version: int) -> dict[str, bytes]:
    """The unit's files by their paths in the archive."""
    facts = _facts(unit, version)
    sources = render_c(unit, "double") | {f"fmi{version}.c": render(f"fmu/fmi{version}.c", facts)}
    binary, path = _binary(unit.prefix, version, sources)
    files = {f"sources/{n}": t.encode() for n, t in sources.items()}
    files["modelDescription.xml"] = render(f"fmu/modelDescription{version}.xml", facts).encode()
    if version == 3:
        files["sources/buildDescription.xml"] = render("fmu/buildDescription.xml", facts).encode()
    return {**files, path: binary}


def _facts(unit: Unit, version: int) -> dict[str, Any]:
    """What the templates print. Parameters, inputs and outputs are numbered through."""
    clock = unit.model.axis if unit.steps else ""
    scale = _of_seconds(unit.model) if unit.steps else ""
    own = [s for s in unit.inputs if s.name not in (unit.step, clock)]
    places = {s.name: f"c->values[PARAMETERS + {k}]" for k, s in enumerate(own)}
    places |= {unit.step: f"{scale}dt", clock: f"{scale}c->time"} if unit.steps else {}
    ranges = {i.name: default_range(i) for i in unit.model.inputs}
    starts = [default_of(unit.model.parameter(s.name)) for s in unit.parameters]
    starts += [0.5 * sum(ranges[s.name]) for s in own] + [0.0] * len(unit.outputs)
    groups = (
        ("parameter", "tunable", unit.parameters),
        ("input", "continuous", own),
        ("output", "", unit.outputs),
    )
    variables = [
        {
            "name": escape(s.name), "unit": escape(_unit_of(unit, s.name) or s.unit), "text": escape(s.text),
            "causality": kind, "variability": how or "continuous",
        }
        for kind, how, slots in groups
        for s in slots
    ]  # fmt: skip
    for k, v in enumerate(variables):
        v |= {"ref": str(k), "index": str(k + 1), "start": repr(starts[k])}
    facts = facts_of(unit, "double")
    says = " ".join((unit.model.text or unit.model.id).split())
    digest = hashlib.sha256("".join(render_c(unit, "double").values()).encode()).hexdigest()
    parts = (unit.model.hash[:8], unit.model.hash[8:12], unit.model.hash[12:], digest[:4], digest[4:16])
    return facts | {
        "variables": variables, "units": sorted({"s", *(v["unit"] for v in variables)}),
        "says": escape(says), "parameters": unit.parameters, "inputs": own, "outputs": unit.outputs,
        "token": f"{{{'-'.join(parts)}}}", "sources": [places[s.name] for s in unit.inputs],
        "by_step": any(s.name == unit.step for s in unit.inputs),
        "starts": [number(x) for x in starts], "in": "&in, " if unit.inputs else "",
        "stubs": stubs(version), "clock": unit.model.axis if clock else "time",
    }  # fmt: skip


def _of_seconds(model: Model) -> str:
    """C that makes the unit of the model's clock of the seconds that a simulation counts in, "" for none.

    Raises InputError for a clock that is no time; one without a unit counts in seconds, too.
    """
    clock = model.inputs[0]
    try:
        scale = 1.0 if clock.unit in PURE else factor("s", clock.unit)
    except InputError:
        raise InputError(
            f"model '{model.id}' steps along '{clock.name}' [{clock.unit}], wanted a time: a unit steps in s"
        ) from None
    return "" if scale == 1.0 else f"{number(scale)} * "


def _unit_of(unit: Unit, name: str) -> str:
    """A quantity's unit as the model writes it; the C has it in basic characters."""
    for q in (*unit.model.inputs, *unit.model.scalar_parameters, *unit.model.statements):
        if q.name in (name, name.removesuffix("_re"), name.removesuffix("_im")):
            return q.unit
    return ""


def _binary(prefix: str, version: int, sources: Mapping[str, str]) -> tuple[bytes, str]:
    """The shared library for this machine, and its path in the archive."""
    arch = {"AMD64": "x86_64", "x86_64": "x86_64", "arm64": "aarch64", "aarch64": "aarch64"}
    machine = arch.get(platform.machine(), platform.machine())
    system, end = {"win32": ("windows", "dll"), "darwin": ("darwin", "dylib")}.get(
        sys.platform, ("linux", "so")
    )
    old = {"windows": "win", "darwin": "darwin", "linux": "linux"}[system] + "64"
    compiler = find_compiler()
    flags = ("-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-ffp-contract=off")
    stripped = ("-Wl,-s", "-Wl,--build-id=none") if system == "linux" else ()
    names = sorted(n for n in sources if n.endswith(".c"))
    with tempfile.TemporaryDirectory(prefix="modelgen-fmu-") as folder:
        for name, text in sources.items():
            (Path(folder) / name).write_text(text)
        command = [*compiler.command, *flags, *names, "-o", "unit", *stripped, "-lm"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise ToolError(f"the C compiler ({compiler.command[0]}) refused the unit: {done.stderr[:200]}")
        place = old if version == 2 else f"{machine}-{system}"
        return (Path(folder) / "unit").read_bytes(), f"binaries/{place}/{prefix}.{end}"


def _zipped(files: Mapping[str, bytes]) -> bytes:
    """A zip archive whose bytes depend on its content alone."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.compress_type, entry.create_system = zipfile.ZIP_DEFLATED, 3
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, files[name])
    return buffer.getvalue()
