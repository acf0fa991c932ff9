"""Builds models: C text, library in the cache, callable function."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from pathlib import Path

from modelgen.codegen.compiler import FAST, QUICK, compile_library
from modelgen.codegen.emit import Source, emit
from modelgen.codegen.function import Function, load
from modelgen.codegen.program import Program, build_program
from modelgen.errors import ToolError
from modelgen.language import Model

ALL = ("values", "jacobian", "sumsq", "normal", "all")


def default_wrt(model: Model) -> tuple[str, ...]:
    """The parameters that a fit would free: those that are not known beforehand."""
    return tuple(p.name for p in model.scalar_parameters if not p.known)


def build(model: Model, wrt: Sequence[str] | None = None) -> Function:
    """Compile `model` and load it.

    `wrt` names the parameters by which Jacobians are taken; by default all that are not `known`.
    Raises InputError for a model or name that is wrong, ToolError when there is no compiler or no place to write.
    """
    return _build(model, default_wrt(model) if wrt is None else tuple(wrt))


@lru_cache(maxsize=64)
def _build(model: Model, wrt: tuple[str, ...]) -> Function:
    program = build_program(model, wrt)
    source = emit(program, ALL)
    library = compile_library({f"{source.prefix}.h": source.header, f"{source.prefix}.c": source.source}, FAST)
    return load(program, source, library)


def build_many(models: Sequence[tuple[Model, tuple[str, ...]]], kernels: Sequence[str] = ("jacobian",)) -> list[Function]:
    """Compile many models at once, quickly: one library a core, kept in the cache. Order is kept."""
    made: list[tuple[Program, Source]] = []
    for k, (model, wrt) in enumerate(models):
        program = build_program(model, wrt)
        made.append((program, emit(program, kernels, prefix=f"{model.id}_{k}")))
    cores = max(1, min(os.cpu_count() or 1, (len(made) + 7) // 8))
    groups = [made[c::cores] for c in range(cores)]
    with ThreadPoolExecutor(cores) as pool:
        libraries = list(pool.map(_compile_group, groups))
    where = {id(p): lib for group, lib in zip(groups, libraries, strict=True) for p, _ in group}
    return [load(p, s, where[id(p)]) for p, s in made]


def _compile_group(group: list[tuple[Program, Source]]) -> Path:
    files = {f"{s.prefix}.{end}": text for _, s in group for end, text in (("h", s.header), ("c", s.source))}
    return compile_library(files, QUICK)


def generate(model: Model, folder: Path) -> tuple[Path, Path]:
    """Write a model's header and source into `folder` and return their paths; unchanged files are not touched.

    Raises ToolError when the folder can't be written.
    """
    source = emit(build_program(model, default_wrt(model)), ALL)
    paths = (folder / f"{source.prefix}.h", folder / f"{source.prefix}.c")
    for path, text in zip(paths, (source.header, source.source), strict=True):
        write_atomically(path, text)
    return paths


def write_atomically(path: Path, text: str) -> None:
    """Write a whole file or nothing. Raises ToolError in one line."""
    data = text.encode()
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists() and path.read_bytes() == data:
            return
        temporary.write_bytes(data)
        os.replace(temporary, path)
    except OSError as why:
        temporary.unlink(missing_ok=True)
        raise ToolError(f"can't write '{path}': {why.strerror or why}") from why
