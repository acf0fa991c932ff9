"""The committed C: the same byte by byte, without warnings, safe against names and texts of all kinds."""

from __future__ import annotations

import ctypes
import errno
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import modelgen.models as models
from modelgen.codegen import build, generate
from modelgen.codegen.compiler import QUICK, compile_library
from modelgen.codegen.ctext import comment
from modelgen.errors import InputError, ToolError
from modelgen.export import export
from modelgen.language import Equation, Input, Model, Parameter, State, exp, previous

ROOT = Path(__file__).parents[1]
STRICT = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror")
needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")


def strictly(*files: Path, out: Path) -> None:
    done = subprocess.run(
        ["gcc", *STRICT, *map(str, files), "-o", str(out), "-lm"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", models.SHIPPED)
def test_regenerating_changes_no_byte(name: str, tmp_path: Path) -> None:
    for path in generate(getattr(models, name), tmp_path):
        assert path.read_bytes() == (ROOT / "generated" / path.name).read_bytes()


def test_a_model_and_its_c_are_written_all_or_none(tmp_path: Path) -> None:
    (tmp_path / "kelvin_voigt.c").mkdir()
    with pytest.raises(InputError, match=r"kelvin_voigt\.c: it is a folder"):
        generate(models.kelvin_voigt, tmp_path, {tmp_path / "kelvin_voigt.py": "1"})
    assert [p.name for p in tmp_path.iterdir()] == ["kelvin_voigt.c"]


@needs_gcc
@pytest.mark.parametrize("name", models.SHIPPED)
def test_no_warnings(name: str, tmp_path: Path) -> None:
    done = subprocess.run(
        ["gcc", *STRICT, "-c", str(ROOT / "generated" / f"{name}.c"), "-o", str(tmp_path / "x.o")],
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


@pytest.mark.skipif(shutil.which("g++") is None, reason="g++ is not installed")
@pytest.mark.parametrize("name", models.SHIPPED)
def test_the_header_is_cpp_too(name: str) -> None:
    command = ["g++", "-Wall", "-Wextra", "-fsyntax-only", "-x", "c++", str(ROOT / "generated" / f"{name}.h")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_two_builds_at_once_do_not_disturb_each_other(tmp_path: Path) -> None:
    names = ("electrodynamic_transducer", "kelvin_voigt", "complex_stiffness")
    script = "import sys; from modelgen.cli import main; "
    script += "sys.exit(main(['build', *sys.argv[2:], '--out', sys.argv[1]]))"
    env = {**os.environ, "MODELGEN_CACHE": str(tmp_path / "cache"), "PYTHONPATH": str(ROOT)}
    out = tmp_path / "generated"
    command = [sys.executable, "-c", script, str(out), *names]
    runs = [subprocess.Popen(command, env=env, stdout=subprocess.DEVNULL) for _ in range(2)]
    assert [run.wait(timeout=300) for run in runs] == [0, 0]
    assert sorted(p.name for p in out.iterdir()) == sorted(f"{n}.{end}" for n in names for end in "ch")
    for path in out.iterdir():
        assert path.read_bytes() == (ROOT / "generated" / path.name).read_bytes()
    assert not [
        p for p in (tmp_path / "cache").rglob("*") if p.name.endswith(".tmp") or p.name.startswith("build-")
    ]


LIBC = (
    "y0", "gamma", "step", "exp", "double", "index", "main", "sum", "e0", "t1", "s1", "q", "lanes",
    "normal", "j0", "j0_1", "set", "work", "out", "p", "n", "i", "in", "stride", "data", "weight",
    "theta", "r_next", "mg_max", "sin", "b", "b_", "exp_", "INFINITY", "MG_LANES", "restrict", "inline",
    "size_t", "solve_y", "d_r_0", "time", "linux",
)  # fmt: skip


def test_a_compiler_that_does_not_start_just_now_is_started_again(tmp_path: Path, monkeypatch) -> None:
    """A machine that is short of memory for a moment refuses a new process; a missing one stays missing."""
    monkeypatch.setenv("MODELGEN_CACHE", str(tmp_path))
    refused, run = iter([errno.EFAULT, errno.EAGAIN, errno.ENOMEM]), subprocess.run

    def busy(*arguments, **options):
        for number in refused:
            raise OSError(number, os.strerror(number))
        return run(*arguments, **options)

    monkeypatch.setattr(subprocess, "run", busy)
    monkeypatch.setattr(time, "sleep", lambda _: None)
    library = ctypes.CDLL(str(compile_library({"one.c": "int one(void) { return 1; }\n"}, QUICK)))
    assert library.one() == 1
    refused = iter([errno.ENOENT])
    with pytest.raises(ToolError, match="No such file"):
        compile_library({"two.c": "int two(void) { return 2; }\n"}, QUICK)


def test_names_of_a_model_take_nothing_over() -> None:
    """Parameters called like C's keywords, libc's functions and the generator's own variables."""
    x = Input("x", "1")
    parameters = tuple(Parameter(name, "1", 0.1 + k) for k, name in enumerate(LIBC))
    total = sum(
        ((k + 1) * parameter for k, parameter in enumerate(parameters)), start=x * exp(-parameters[0])
    )
    model = Model("double", (x,), parameters, (Equation("void", total),), ("void",))
    f = build(model)
    wanted = sum((k + 1) * (0.1 + k) for k in range(len(LIBC)))
    at = np.array([0.0, 2.0])
    assert f(x=at) == pytest.approx(wanted + at * np.exp(-0.1), rel=1e-14)
    assert f.jacobian(x=at)[:, 1:] == pytest.approx(np.tile(np.arange(2.0, len(LIBC) + 1), (2, 1)))
    ready = f.prepare(x=at)
    data, weight = (ready.pad(np.full((1, 2), v)) for v in (0.0, 1.0))
    values = np.array([[p.default for p in parameters]], dtype=float)
    total_square = float(np.sum(f(x=at) ** 2))
    assert ready.sumsq(values, "real", data, weight)[0] == pytest.approx(total_square)
    assert ready.normal(values[0], "real", data, weight)[0] == pytest.approx(total_square)


def test_names_of_a_time_model_take_nothing_over() -> None:
    """A decay dx/dt = −k x, its state and parameters called like what the generator declares for states."""
    t, k, d = Input("t", "1"), Parameter("d_r_0", "1", 0.7), Parameter("r_next", "1", 2.0)
    r = State("r", d, rate=-k * State("r", rate=0).symbol, substeps=20)
    model = Model("decay", (t, previous(t)), (k, d), (r, Equation("y", 3 * r)), ("y",))
    at = np.linspace(0, 1, 11)
    f = build(model)
    assert f(t=at) == pytest.approx(6 * np.exp(-0.7 * at), rel=1e-9)
    wanted = np.stack([-6 * at * np.exp(-0.7 * at), 3 * np.exp(-0.7 * at)], axis=1)
    assert f.jacobian(t=at) == pytest.approx(wanted, rel=1e-8, abs=1e-12)


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("χ_r − jχ_i, jωR_g2", "chi_r - j chi_i, j omega R_g2"),
        ("σ/h_D, dζ/dt, 2ξMω", "sigma/h_D, d zeta/dt, 2 xi M omega"),
        ("μ_33^σ*, R_q in µm or μm", "mu_33^sigma*, R_q in um or um"),
        ("√(|S|²), 10⁻⁶ xⁿ, Poincaré–Bendixson", "sqrt(|S|^2), 10^-6 x^n, Poincare-Bendixson"),
    ],
)
def test_a_comment_in_c_spells_out_what_is_not_ascii(text: str, plain: str) -> None:
    assert comment(text) == plain


NASTY = '*/ system("x"); /* \\\n\r\u2028 #error "no" ??/ *//*/ %> {{ 7*7 }} {% raw %}'


@needs_gcc
def test_texts_of_a_model_cannot_leave_their_comment(tmp_path: Path) -> None:
    x, k = Input("x", "1", NASTY), Parameter("k", "1", 2.0, text=NASTY, source=NASTY)
    y = Equation("y", k * x + 1, "1", NASTY, NASTY)
    model = Model(
        "nasty", (x,), (k,), (y,), ("y",), source=NASTY, text=NASTY, options=(("a", NASTY), (NASTY, "b"))
    )
    assert build(model)(x=3.0) == 7.0
    header, source = generate(model, tmp_path)
    assert all(line.isascii() for line in (header.read_text() + source.read_text()).splitlines())
    strictly(source, *_main(tmp_path), out=tmp_path / "a.out")
    files = export(model, "c99", tmp_path / "c99")
    strictly(*(f for f in files if f.suffix == ".c"), out=tmp_path / "b.out")
    assert subprocess.run([tmp_path / "b.out"], capture_output=True).returncode == 0


def _main(folder: Path) -> tuple[Path]:
    path = folder / "main.c"
    path.write_text("int main(void) { return 0; }\n")
    return (path,)


@pytest.mark.parametrize("name", ["x;", "1x", "a b", "x\n", "π", "", "_x", "a" * 64, "x-y", "*/"])
def test_names_that_are_none_are_refused(name: str) -> None:
    with pytest.raises(InputError, match="is not a name"):
        Model("m", (Input("x"),), (Parameter(name),), (Equation("y", Input("x").symbol),), ("y",))


@pytest.mark.slow
def test_the_compiler_of_the_zig_wheel_serves_where_there_is_no_other(tmp_path: Path) -> None:
    pytest.importorskip("ziglang", reason="the ziglang wheel is not installed")
    script = (
        "import modelgen as mg; f = mg.build(mg.models.complex_stiffness); "
        "from modelgen.codegen.compiler import find_compiler; print(find_compiler().name, float(f(f=1.0)[0]))"
    )
    env = {k: v for k, v in os.environ.items() if k != "CC"}
    env |= {"PATH": str(tmp_path), "MODELGEN_CACHE": str(tmp_path / "cache"), "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", script], env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    name, value = done.stdout.split()
    assert name == "zig" and float(value) == pytest.approx(0.72393189561606818185, rel=1e-12)


def test_symbols_of_a_library_are_prefixed() -> None:
    f = build(models.modified_dahl)
    library = ctypes.CDLL(str(f.code.library))
    assert all(hasattr(library, f"modified_dahl_{k.name}") for k in f.code.source.kernels)
