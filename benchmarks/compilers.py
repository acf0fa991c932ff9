"""The same C compiler and flags for everybody."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from modelgen.codegen.compiler import FAST, find_compiler


def compiled(code: str, folder: str, *flags: str, cpp: bool = False) -> Path:
    """A library of C (or C++) text, compiled as our kernels are, with more flags if wanted."""
    path = Path(folder) / ("code.cpp" if cpp else "code.c")
    includes = "#include <cmath>\n" if cpp else "#include <math.h>\n#include <stddef.h>\n"
    path.write_text(includes + (f'extern "C" {{\n{code}\n}}\n' if cpp else code))
    compiler = find_compiler()
    ours = [f.replace("c99", "c++17") if cpp else f for f in compiler.flags(FAST)]
    command = [
        *compiler.command,
        *ours,
        *flags,
        *(["-Drestrict=__restrict"] if cpp else []),
        str(path),
        "-lm",
    ]
    library = path.with_suffix(".so")
    done = subprocess.run([*command, "-o", str(library)], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(next(line for line in done.stderr.splitlines() if "error" in line))
    return library


def casadi_compiled(f: Any) -> Any:
    """A CasADi function through its C code generator."""
    import casadi as ca

    folder = Path(tempfile.mkdtemp())
    maker = ca.CodeGenerator("code.c")
    maker.add(f)
    maker.generate(f"{folder}/")
    path = compiled((folder / "code.c").read_text(), str(folder))
    return ca.external(f.name(), str(path))


def casadi_call(f: Any, inputs: list[Any], output: Any) -> Callable[[], Any]:
    """A call of `f` on memory that stays where it is, as quick as CasADi's Python interface can be."""
    buffer, run = f.buffer()
    for k, a in enumerate(inputs):
        buffer.set_arg(k, memoryview(a))
    buffer.set_res(0, memoryview(output))

    def call(keep: Any = (f, buffer, inputs)) -> Any:
        run()
        return output

    return call


def symforce_cpp(expressions: Callable[[list[Any]], Any], count: int) -> str:
    """C++ function call(x, o) of expressions of symforce's symbols, by its own elimination and printer."""
    import symforce

    symforce.set_epsilon_to_zero()
    import symforce.symbolic as sf
    from symforce.codegen.backends.cpp.cpp_code_printer import CppCodePrinter

    symbols = [sf.Symbol(f"v{k}") for k in range(count)]
    steps, results = sf.sympy.cse([sf.S(e) for e in expressions(symbols)])
    printer = CppCodePrinter()
    lines = [f"const double v{k} = x[{k}];" for k in range(count)]
    lines += [f"const double {s} = {printer.doprint(e)};" for s, e in steps]
    lines += [f"o[{k}] = {printer.doprint(e)};" for k, e in enumerate(results)]
    return (
        "typedef double Scalar;\nstatic inline void call(const double *x, double *o) {\n"
        + "\n".join(lines)
        + "\n}\n"
    )
