"""Writes a model for use outside: its C, how to build it, and how to call it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from modelgen.codegen.build import ALL, default_wrt
from modelgen.codegen.ctext import comment, number
from modelgen.codegen.emit import Source, emit, environment
from modelgen.codegen.program import build_program
from modelgen.errors import InputError, did_you_mean
from modelgen.files import write_atomically
from modelgen.language import Model


@dataclass(frozen=True)
class Target:
    """A place where a model can run. Files are named after their templates in templates/<folder>/."""

    folder: str
    files: tuple[str, ...]


TARGETS = {"c99": Target("c99", ("CMakeLists.txt", "README.md", "example.c"))}


def export(model: Model, target: str, folder: Path) -> tuple[Path, ...]:
    """Write `model` for `target` into `folder` and return the paths of its files.

    Raises InputError for an unknown target, ToolError when the folder can't be written.
    """
    if target not in TARGETS:
        near = did_you_mean(target, TARGETS) or ";"
        raise InputError(f"unknown target '{target}'{near} it is one of {', '.join(TARGETS)}")
    source = emit(build_program(model, default_wrt(model)), ALL)
    texts = {f"{source.prefix}.h": source.header, f"{source.prefix}.c": source.source}
    facts = _facts(model, source)
    for name in TARGETS[target].files:
        texts[name] = environment().get_template(f"{TARGETS[target].folder}/{name}.j2").render(facts)
    for name, text in texts.items():
        write_atomically(folder / name, text, parents=True)
    return tuple(folder / name for name in texts)


def _facts(model: Model, source: Source) -> dict[str, Any]:
    """What the templates print."""
    measure = source.measures[0]
    values = {p.name: 0.0 if p.default is None else p.default for p in model.scalar_parameters}
    return {
        "id": model.id,
        "text": comment(model.text or model.id),
        "source": comment(model.source or "not stated"),
        "hash": model.hash,
        "prefix": source.prefix,
        "measure": measure,
        "batch": not model.inputs,
        "channels": len(source.outputs) * (2 if measure == "complex" else 1),
        "names": [
            n + part for n in source.outputs for part in (("_re", "_im") if measure == "complex" else ("",))
        ],
        "inputs": [{"name": i.name, "unit": i.unit, "text": comment(i.text)} for i in model.inputs],
        "parameters": [
            {"name": p.name, "unit": p.unit, "text": comment(p.text), "value": number(values[p.name])}
            for p in model.scalar_parameters
        ],
        "staged": max(1, source.staged),
        "kernels": [{"name": k.name, "operations": k.operations} for k in source.kernels],
    }
