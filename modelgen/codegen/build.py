"""Builds models: C text, library in the cache, callable function. What was built once is found again by its
hash; until the library of a new model is there, the same C compiled in memory answers."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from functools import cache, lru_cache, partial
from pathlib import Path
from weakref import WeakValueDictionary

import numpy as np

from modelgen.codegen import fitters
from modelgen.codegen.compiler import FAST, QUICK, WIDE, compile_library, find_compiler
from modelgen.codegen.emit import Kernel, Source, emit, templates_folder
from modelgen.codegen.function import Function
from modelgen.codegen.instant import Memory, available
from modelgen.codegen.lower import nonzero
from modelgen.codegen.machine import machine
from modelgen.codegen.program import build_program
from modelgen.codegen.real import Work
from modelgen.codegen.tiers import WORTH, Code, Rise, Tiers, compilers
from modelgen.codegen.unity import unite
from modelgen.errors import InputError, ToolError
from modelgen.files import cache_folder, write_atomically, write_together
from modelgen.language import Model

ALL = ("values", "jacobian", "sumsq", "normal", "all")
GROUPS = 6
"""Libraries that many models are compiled into: more keep all cores busy, fewer start the compiler less."""


def default_wrt(model: Model) -> tuple[str, ...]:
    """The parameters that a fit would free: those that are not known beforehand; all when every one is."""
    free = tuple(p.name for p in model.scalar_parameters if not p.known)
    return free or tuple(p.name for p in model.scalar_parameters)


def build(model: Model, wrt: Sequence[str] | None = None, *, wait: bool = False) -> Function:
    """Compile `model` and load it.

    `wrt` names the parameters by which Jacobians are taken; by default all that are not `known`.
    wait: return when the optimised library is there. Otherwise that is compiled in the background, and the
    same C, compiled in memory, answers meanwhile (see `Function`); rounding then depends on when a call
    comes.
    Raises InputError for a model or name that is wrong, ToolError when there is no compiler or no place to
    write.
    """
    if not isinstance(model, Model):
        raise InputError(f"build: found {model!r}, wanted a Model, such as mg.models.modified_dahl")
    if isinstance(wrt, str):
        raise InputError(f"build: wrt is the text {wrt!r}, wanted a list of names, [{wrt!r}]")
    function = _build(model, default_wrt(model) if wrt is None else tuple(wrt))
    if wait:
        function.tiers.library()
    return function


@lru_cache(maxsize=64)
def _build(model: Model, wrt: tuple[str, ...]) -> Function:
    key = _key(model, wrt, ALL, None, FAST)
    kept = _remembered(key)
    if kept is not None and kept[1] is not None:
        source, library = kept[0], kept[1]
        return _function(model, wrt, Tiers(lambda: Code(source, library)))
    program = build_program(model, wrt)
    sketch = program.copy()  # emitting adds to a program, and both are emitted at the same time

    def at_once(kernel: str) -> Code:
        measure = "complex" if any(program.complex_outputs) else "real"
        source = emit(sketch, (kernel,), measures=(measure,))
        return Code(source, Memory(source.source))

    def make() -> Code:
        source = emit(program, ALL)
        library = _compile([source], FAST)
        _remember(key, source, library)
        return Code(source, library)

    return _function(model, wrt, Tiers(make, at_once))


def _function(model: Model, wrt: tuple[str, ...], tiers: Tiers) -> Function:
    names = [p.name for p in model.scalar_parameters]
    return Function(model, wrt, np.array([names.index(w) for w in wrt], dtype=int), tiers)


def warm() -> None:
    """Begin to compile what all models share, if this machine has not done so before."""
    for shared in (fitters.library, machine):
        compilers().submit(shared)


def build_many(
    models: Sequence[tuple[Model, tuple[str, ...]]],
    kernels: Sequence[str] = ("jacobian",),
    measures: Sequence[str] | None = None,
    quick: bool = True,
    brief: bool = False,
) -> list[Function]:
    """Compile many models at once. Order is kept.

    `quick` saves time at the compiler: in memory where that is possible, and only what fits work in for long
    as libraries, which round alike; else a few libraries in all. `measures` limits the kernels to what is
    compared with data ("complex", "modulus", "phase", "real"). brief: for a few fits, as the equations are
    written: lowered in half the time, a fifth slower.
    """
    level = (QUICK if any(m.is_time_model for m, _ in models) else WIDE) if quick else FAST
    keys = [_key(m, wrt, kernels, measures, level, brief) for m, wrt in models]
    codes = {k: code.best for k in keys if (code := _codes.get(k)) is not None}
    found = {k: _remembered(k) for k in dict.fromkeys(keys) if k not in codes}
    missing = {k: mw for k, mw in zip(keys, models, strict=True) if k in found and found[k] is None}
    if missing:
        at_once = quick and available()
        for sources, library in _built(missing, kernels, measures, None if at_once else level, brief):
            for k, source in sources.items():
                found[k] = (source, library)
                _remember(k, source, library)
    of = dict(zip(keys, models, strict=True))
    for k, kept in found.items():
        if kept is not None:
            source, library = kept
            again = partial(_raised, k, of[k], kernels, measures, level, brief)
            _codes[k] = codes[k] = Code(source, library) if library else _in_memory(source, again)
    return [
        _function(m, w, Tiers(partial(codes.__getitem__, k))) for k, (m, w) in zip(keys, models, strict=True)
    ]


_codes: WeakValueDictionary[str, Code] = WeakValueDictionary()
"""What is loaded, as long as functions hold it: a search comes back to the same models."""


def _in_memory(source: Source, library: Callable[[], Code]) -> Code:
    """Code compiled in memory, which gives way to the `library` once that is worth the compiler's time."""
    try:
        if source.tapes == "none":
            return Code(source, Memory(source.source), Rise(library, WORTH["none"]))
        rise = None if source.tapes == "all" else Rise(library, WORTH[source.tapes])
        return Code(source, Memory(source.source, machine()), rise)
    except ToolError:  # a system that lets nobody write code to memory
        return library()


def _raised(
    key: str, of: tuple[Model, tuple[str, ...]], kernels: Sequence[str], measures: Sequence[str] | None,
    level: tuple[str, ...], brief: bool,
) -> Code:  # fmt: skip
    """The library of a model that was compiled in memory."""
    source = emit(build_program(*of, brief), kernels, measures=measures)
    library = _compile([source], level)
    _remember(key, source, library)
    return Code(source, library)


def _built(
    models: Mapping[str, tuple[Model, tuple[str, ...]]],
    kernels: Sequence[str],
    measures: Sequence[str] | None,
    level: tuple[str, ...] | None,
    brief: bool,
) -> list[tuple[dict[str, Source], Path | None]]:
    """Sources by key, group by group, with the library of each (None without a `level`): while one group is
    compiled, C of the next is written."""
    keys, size = list(models), max(4, -(-len(models) // GROUPS))
    made = []
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        for start in range(0, len(keys), size):
            sources = {}
            for k in keys[start : start + size]:
                model, wrt = models[k]
                prefix = "" if len(models) == 1 else f"{model.id}_{k[:10]}"
                program = build_program(model, wrt, brief)
                sources[k] = emit(program, kernels, prefix, measures, taped=level is None)
            library = level and pool.submit(_compile, list(sources.values()), level)
            made.append((sources, library))
        return [(sources, library.result() if library else None) for sources, library in made]


def _compile(sources: list[Source], level: tuple[str, ...]) -> Path:
    if level != FAST:
        return compile_library(unite(sources), level)
    files = {f"{s.prefix}.{end}": text for s in sources for end, text in (("h", s.header), ("c", s.source))}
    return compile_library(files, level)


@cache
def _code_version() -> str:
    """Hash of the code that makes code: what it built before, an edited version of it builds again."""
    here = Path(__file__).parent
    used = (here.parent / "language" / name for name in ("functions.py", "write.py"))
    files = [*here.glob("*.py"), *templates_folder().rglob("*.j2"), *used]
    return hashlib.sha256(b"".join(f.read_bytes() for f in sorted(files))).hexdigest()


def _key(
    model: Model,
    wrt: Sequence[str],
    kernels: Sequence[str],
    measures: Sequence[str] | None,
    level: tuple[str, ...],
    brief: bool = False,
) -> str:
    compiler = find_compiler()
    parts = (
        model.hash,
        model.options,
        sorted(nonzero(model)),
        tuple(wrt),
        tuple(kernels),
        measures and tuple(measures),
        brief,
        compiler.identity,
        compiler.flags(level),
    )
    return hashlib.sha256(repr(parts).encode() + _code_version().encode()).hexdigest()[:24]


def _remembered(key: str) -> tuple[Source, Path | None] | None:
    """A model built before: its library, or its text while it has none; None when it is not there whole."""
    try:
        kept = json.loads((cache_folder() / f"{key}.json").read_text())
        name = kept.pop("library")
        library = cache_folder() / name if name else None
        kernels = tuple(Kernel(**k | {"work": Work(*k["work"])}) for k in kept.pop("kernels"))
        equations = tuple((n, bool(c)) for n, c in kept.pop("equations"))
        for name in ("measures", "outputs", "complex_outputs"):
            kept[name] = tuple(kept[name])
        whole = available() if library is None else library.exists()
        return (Source(kernels=kernels, equations=equations, **kept), library) if whole else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _remember(key: str, source: Source, library: Path | None) -> None:
    kept = asdict(source) | (
        {"library": library.name, "header": "", "source": ""} if library else {"library": ""}
    )
    kept["kernels"] = [k | {"code": ""} for k in kept["kernels"]]
    write_atomically(cache_folder() / f"{key}.json", json.dumps(kept), parents=True, lasting=False)


def generate(model: Model, folder: Path, beside: Mapping[Path, str] | None = None) -> tuple[Path, Path]:
    """Write a model's header and source into `folder` and return their paths; unchanged files are not
    touched.

    beside: texts of files of the same set. Raises ToolError when the folder can't be written, or not all fit.
    """
    source = emit(build_program(model, default_wrt(model)), ALL)
    paths = (folder / f"{source.prefix}.h", folder / f"{source.prefix}.c")
    texts = dict(zip(paths, (source.header, source.source), strict=True))
    write_together({**(beside or {}), **texts}, parents=True)
    return paths
