"""Finds a C compiler, compiles into a cache keyed by what went in, and writes atomically."""

from __future__ import annotations

import errno
import hashlib
import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from threading import Lock

from modelgen.errors import ToolError
from modelgen.files import cache_folder

FAST = ("-O3", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=fast")
"""No -ffast-math: sums keep their order, NaN and infinity keep their meaning. FMA may round once instead of
twice."""
_ROUNDS = ("-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off")
"""Every operation rounds, so that a kernel gives the same numbers whatever it is compiled together with, and
in memory."""
QUICK = ("-Og", *_ROUNDS)
"""For code that is compiled to be run a few times: as fast as by -O1, in half the time at the compiler."""
WIDE = ("-O1", "-ftree-vectorize", *_ROUNDS)
"""The same for samples that need not be taken in order: twice QUICK's time at the compiler makes code that is
two to three times as fast. Samples in order gain nothing by it."""


@dataclass(frozen=True)
class Compiler:
    """A C compiler: the command, its name, and what tells this very compiler on this very machine from
    others."""

    command: tuple[str, ...]
    name: str
    identity: str

    def flags(self, level: tuple[str, ...]) -> tuple[str, ...]:
        native = ["-mcpu=native" if self.name == "zig" else "-march=native"]
        if platform.machine() in ("x86_64", "AMD64"):  # compilers shy at full width, which pays here
            native.append("-mprefer-vector-width=512")
            if self.name == "gcc":  # at -O1 it else leaves registers so that libm takes ten times as long
                native.append("-fexpensive-optimizations")
        return (*level, *native, "-std=c99", "-fPIC", "-shared", "-Wall")


@cache
def find_compiler() -> Compiler:
    """$CC, gcc, cc, clang, or the C compiler in the `ziglang` wheel. Raises ToolError when there is none."""
    chosen = os.environ.get("CC")
    candidates = [shlex.split(chosen)] if chosen else [["gcc"], ["cc"], ["clang"]]
    for command in candidates:
        path = shutil.which(command[0]) if command else None
        if path:
            real = Path(path).resolve()
            stat = real.stat()
            name = "zig" if "zig" in real.name else "clang" if "clang" in real.name else "gcc"
            return Compiler(
                (path, *command[1:]), name, f"{real}:{stat.st_size}:{stat.st_mtime_ns}:{_machine()}"
            )
    if chosen:
        raise ToolError(f"no C compiler: CC is set to '{chosen}', which is not found")
    if find_spec("ziglang") is not None:
        from importlib.metadata import version

        return Compiler(
            (sys.executable, "-m", "ziglang", "cc"), "zig", f"zig:{version('ziglang')}:{_machine()}"
        )
    raise ToolError(
        "no C compiler: none of gcc, cc, clang is found, and CC is not set; 'pip install ziglang' brings one"
    )


@cache
def _machine() -> str:
    """What -march=native stands for here."""
    text, info = platform.machine(), Path("/proc/cpuinfo")
    if not info.exists():
        text += platform.processor()  # may start a process to find out
    else:
        for line in info.read_text(errors="replace").splitlines():
            if line.startswith(("flags", "Features", "model name")):
                text += line
            elif not line.strip():
                break
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def library_key(files: dict[str, str], level: tuple[str, ...]) -> str:
    """Hash of sources, flags and compiler."""
    compiler = find_compiler()
    digest = hashlib.sha256()
    for part in (compiler.identity, *compiler.flags(level), *(f"{n}\0{t}" for n, t in sorted(files.items()))):
        digest.update(part.encode() + b"\0")
    return digest.hexdigest()[:24]


def compile_library(files: dict[str, str], level: tuple[str, ...] = FAST) -> Path:
    """Compile C files (name → text) into one shared library and return its path in the cache.

    Raises ToolError with the compiler's first message when the compiler refuses, and when the disk does.
    """
    compiler = find_compiler()
    target = cache_folder() / f"{library_key(files, level)}.so"
    with _LOCKS.setdefault(target.name, Lock()):
        return target if target.exists() else _compiled(compiler, files, level, target)


_LOCKS: dict[str, Lock] = {}
"""Threads that want the same library wait for the first."""
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_LOCKS.clear)  # a child has no thread that would open them


_PASSING = (errno.EAGAIN, errno.ENOMEM, errno.EFAULT)
"""What starting a program says on a machine that is short of memory or processes for a moment."""


def _run(command: list[str], folder: str, env: dict[str, str] | None) -> subprocess.CompletedProcess[str]:
    """Run `command` in `folder`; where the machine can't start it just now, again a little later."""
    for pause in (0.1, 0.3, 1.0, 3.0, 6.0):
        try:
            return subprocess.run(command, cwd=folder, capture_output=True, text=True, env=env, check=False)
        except OSError as why:
            if why.errno not in _PASSING:
                raise
            time.sleep(pause)
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, env=env, check=False)


def _compiled(compiler: Compiler, files: dict[str, str], level: tuple[str, ...], target: Path) -> Path:
    try:
        folder = tempfile.mkdtemp(prefix="build-", dir=cache_folder())
        try:
            for name, text in files.items():
                (Path(folder) / name).write_text(text)
            sources = [n for n in files if n.endswith(".c")]
            command = [*compiler.command, *compiler.flags(level), *sources, "-o", "out.so", "-lm"]
            env = (
                {**os.environ, "ZIG_GLOBAL_CACHE_DIR": str(cache_folder() / "zig")}
                if compiler.name == "zig"
                else None
            )
            done = _run(command, folder, env)
            if done.returncode != 0:
                first = next((x for x in done.stderr.splitlines() if "error" in x), done.stderr.strip()[:200])
                raise ToolError(
                    f"the C compiler ({compiler.command[0]}) refused {', '.join(sources)}: {first.strip()}"
                )
            os.replace(Path(folder) / "out.so", target)
        finally:  # a TemporaryDirectory would also go when a child that was forked meanwhile ends
            shutil.rmtree(folder, ignore_errors=True)
    except OSError as why:
        raise ToolError(f"can't compile into '{cache_folder()}': {why.strerror or why}") from why
    return target
