"""The exported fitter: what scipy finds, here and in the emulator; wrong requests are refused."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares
from test_export import SANITIZERS, WARNINGS, decay, needs_arm, needs_gcc

import modelgen.models as models
from modelgen.codegen import build
from modelgen.errors import InputError
from modelgen.export import arm, export
from modelgen.export.c99 import Settings
from modelgen.export.datasheet import emulator_files
from modelgen.export.routines import make_unit
from modelgen.export.text import facts_of, render, render_c
from modelgen.export.vectors import make_vectors
from modelgen.language import Equation, Input, Model, Parameter

COIL = models.electrodynamic_transducer
FREE = ("R_e", "L_e", "Bl", "K_m", "R_m")
PROGRAM = """
#include "electrodynamic_transducer_fit.h"
#include <stdio.h>

static const electrodynamic_transducer_input in[] = {{ {inputs} }};
static const {real} measured[] = {{ {measured} }};

int main(void)
{{
    static electrodynamic_transducer_workspace w;
    const electrodynamic_transducer_range ranges[] = {{ {ranges} }};
    const electrodynamic_transducer_record record = {{ {n}, in, measured, {{ 100.0, 100.0 }} }};
    electrodynamic_transducer_parameters p = {{ {start} }};
    const electrodynamic_transducer_range wrong[] = {{ {{ 0, 2.0, 1.0 }}, {{ 99, 0.0, 1.0 }} }};
    const electrodynamic_transducer_range twice[] = {{ {{ 0, 1.0, 2.0 }}, {{ 0, 1.0, 2.0 }} }};
    printf("%d", electrodynamic_transducer_fit(&w, &wrong[0], 1, &record, 1, 9, &p));
    printf(" %d", electrodynamic_transducer_fit(&w, &wrong[1], 1, &record, 1, 9, &p));
    printf(" %d", electrodynamic_transducer_fit(&w, twice, 2, &record, 1, 9, &p));
    printf(" %d", electrodynamic_transducer_fit(&w, ranges, 0, &record, 1, 9, &p));
    printf(" %d", electrodynamic_transducer_fit(&w, ranges, {size}, &record, 1, 100, &p));
    printf(" %.9g", w.lm.f);
    printf(" {formats}\\n", {values});
    return 0;
}}
"""


def recorded() -> tuple[np.ndarray, np.ndarray]:
    """A noisy sweep (n,), complex (n,)."""
    rng, f = np.random.default_rng(4), np.geomspace(20, 2000, 40)
    Z = np.asarray(build(COIL)(f=f, Bl=6.3, K_m=3300.0, R_m=1.9))
    return f, Z + 0.01 * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size))


def program(real: str) -> dict[str, str]:
    """C that fits the sweep, with the exported files that it needs."""
    unit = replace(make_unit(COIL), fitter=True)
    f, Z = recorded()
    text = PROGRAM.format(
        real=real, n=f.size, size=len(FREE),
        inputs=", ".join(f"{{ {x!r} }}" for x in f.tolist()),
        measured=", ".join(f"{x!r}" for z in Z.tolist() for x in (z.real, z.imag)),
        ranges=", ".join(f"{{ ELECTRODYNAMIC_TRANSDUCER_FIT_{n}, 1e-9, 1e9 }}" for n in FREE),
        start=", ".join(repr(COIL.parameter(s.name).default) for s in unit.parameters),
        formats=" ".join(["%.9g"] * len(FREE)), values=", ".join(f"(double)p.{n}" for n in FREE),
    )  # fmt: skip
    return {"program.c": text} | render_c(unit, real)


def ran(folder: Path) -> str:
    """What all C in a folder prints, compiled with every warning an error, and with sanitizers."""
    command = ["gcc", *WARNINGS, *SANITIZERS, *map(str, folder.glob("*.c")), "-o", str(folder / "it"), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    done = subprocess.run([folder / "it"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def check(said: str, rel: float) -> None:
    """Against scipy's fit of the same sweep."""
    f, Z = recorded()
    coil = build(COIL)

    def residual(theta: np.ndarray) -> np.ndarray:
        r = np.asarray(coil(f=f, **dict(zip(FREE, theta, strict=True)))) - Z
        return 100.0 * np.concatenate([r.real, r.imag])

    start = [COIL.parameter(n).default for n in FREE]
    wanted = least_squares(residual, start, x_scale=np.abs(start), xtol=1e-15, ftol=1e-15, gtol=1e-15)
    *refused, status, value = said.split()[:6]
    assert refused == ["-1"] * 4 and status in ("1", "3")  # converged, or stalled by the rounding of floats
    assert float(value) == pytest.approx(2 * wanted.cost, rel=max(rel, 1e-8))
    assert [float(x) for x in said.split()[6:]] == pytest.approx(wanted.x, rel=rel)


@needs_gcc
def test_it_finds_what_scipy_finds(tmp_path: Path) -> None:
    for name, text in program("double").items():
        (tmp_path / name).write_text(text)
    check(ran(tmp_path), 1e-6)


@needs_arm
def test_it_finds_it_on_a_microcontroller_in_single_precision() -> None:
    files = program("float")
    facts = facts_of(make_unit(COIL), "float")
    files |= {n: render(f"arm/{n}", facts) for n in ("startup.c", "board.ld")}
    with tempfile.TemporaryDirectory() as name:
        text, passed = arm.emulate(arm.CORES[0], arm.link(arm.CORES[0], files, Path(name)))
    assert passed
    check(text, 2e-4)


@needs_arm
@pytest.mark.slow
@pytest.mark.parametrize("name", [n for n in models.SHIPPED if n != "bouc_wen"])
def test_all_models_fit_themselves_on_a_microcontroller(name: str) -> None:
    unit = replace(make_unit(getattr(models, name)), fitter=True)
    files = render_c(unit, "float") | emulator_files(unit, "float", *make_vectors(unit, "float", {}))
    found = arm.measure(arm.CORES[1], unit.prefix, files)
    assert found.passed and found.fit_cost > 0 and found.fit_flash > found.flash / 2


@needs_gcc
@pytest.mark.parametrize("real", ["double", "float"])
def test_the_self_test_fits_without_a_warning(real: str, tmp_path: Path) -> None:
    for model in (models.modified_dahl, decay()):
        export(model, "c99", tmp_path, Settings(real, measure=False, fitter=True))
    assert ran(tmp_path).count(" fit sum_of_squares ") == 2
    build_file = (tmp_path / "CMakeLists.txt").read_text()
    assert "decay_fit.c modified_dahl_fit.c modelgen_fit.c" in build_file
    assert "bounded Levenberg–Marquardt" in (tmp_path / "DATASHEET.md").read_text()


@needs_gcc
@pytest.mark.parametrize("real", ["double", "float"])
def test_parameters_that_are_all_zero_are_moved_and_fitted_back(real: str, tmp_path: Path) -> None:
    x, a, b = Input("x", range=(1.0, 2.0)), Parameter("a", "1", 0.0), Parameter("b", "1", 0.0, (-3.0, 0.0))
    model = Model("zero", (x,), (a, b), (Equation("y", a * x + b * x**2),), ("y",))
    export(model, "c99", tmp_path, Settings(real, measure=False, fitter=True))
    said = ran(tmp_path)
    assert "zero 0 checks failed" in said
    left, start = re.findall(r"sum_of_squares (\S+) of (\S+)", said)[0]
    assert float(left) <= 1e-4 * float(start) and float(start) > 0
    moves = re.findall(r"p\.(\w) = \(?(-?[\d.]+)", (tmp_path / "zero_refit.c").read_text())
    assert moves == [("a", "0.02"), ("b", "-0.02")]


def test_a_model_without_parameters_has_no_fitter(tmp_path: Path) -> None:
    x = Input("x", "1")
    model = Model("plain", (x,), (), (Equation("y", x * x),), ("y",))
    with pytest.raises(InputError, match="--fitter: 'plain' has no parameter to fit"):
        export(model, "c99", tmp_path, Settings(fitter=True, measure=False))


@pytest.mark.skipif(shutil.which("cppcheck") is None, reason="cppcheck is not installed")
def test_the_datasheet_names_every_rule_that_the_c_departs_from(tmp_path: Path) -> None:
    export(models.kelvin_voigt, "c99", tmp_path, Settings(measure=False, fitter=True))
    listed = set(re.findall(r"\b\d+\.\d+\b", (tmp_path / "DATASHEET.md").read_text().split("MISRA")[1]))
    sources = ["kelvin_voigt.c", "kelvin_voigt_fit.c", "modelgen_fit.c"]
    command = ["cppcheck", "--std=c99", "--addon=misra", "--quiet", "--template={id}", *sources]
    done = subprocess.run(
        [*command, "--template={id}", *sources], cwd=tmp_path, capture_output=True, text=True
    )
    rules = {line.removeprefix("misra-c2012-") for line in done.stderr.splitlines()}
    assert rules and rules <= listed
