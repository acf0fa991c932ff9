"""Exported C: right to rounding here and in the emulator, without warnings, safe with any number."""

from __future__ import annotations

import itertools
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import modelgen.models as models
from modelgen.codegen import build
from modelgen.errors import InputError, ToolError
from modelgen.export import arm, export
from modelgen.export.c99 import Settings
from modelgen.export.datasheet import emulator_files, merge
from modelgen.export.floats import single
from modelgen.export.host import Compiled
from modelgen.export.routines import make_unit
from modelgen.export.text import REALS, render_c
from modelgen.export.unit import Unit
from modelgen.export.vectors import make_vectors
from modelgen.language import Equation, Input, Model, Parameter, Piecewise, State, exp, previous, sqrt

WARNINGS = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow",
            "-Wdouble-promotion", "-Wstrict-prototypes", "-Wmissing-prototypes", "-Werror")  # fmt: skip
SANITIZERS = ("-fsanitize=address,undefined", "-fno-sanitize-recover")
QUICK = ("modified_dahl", "electrodynamic_transducer")
ABSENT = arm.missing_tools()
needs_arm = pytest.mark.skipif(bool(ABSENT), reason=f"not installed: {', '.join(ABSENT)}")
needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")


def decay(substeps: int = 2) -> Model:
    """dx/dt = −k x + u, a model of a user's with a rate, two inputs and a name that is C's."""
    t, u, k = Input("t", "s"), Input("u", "1/s"), Parameter("k", "1/s", 3.0)
    x = State("double", 0.5, rate=u - k * State("double", rate=0).symbol, unit="1", substeps=substeps)
    return Model("decay", (t, u, previous(t), previous(u)), (k,), (x, Equation("y", 2 * x, "1")), ("y",))


def exported(model: Model, folder: Path, real: str, *flags: str) -> str:
    """What the self-test of an export says, compiled with `flags`."""
    export(model, "c99", folder, Settings(real, measure=False))
    command = ["gcc", *WARNINGS, *flags, *map(str, folder.glob("*.c")), "-o", str(folder / "selftest"), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    ran = subprocess.run([folder / "selftest"], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    return ran.stdout


@needs_gcc
@pytest.mark.parametrize(
    "name", [*QUICK, *(pytest.param(n, marks=pytest.mark.slow) for n in models.SHIPPED if n not in QUICK)]
)
def test_the_self_test_passes_under_sanitizers(name: str, tmp_path: Path) -> None:
    for real in REALS:
        folder = tmp_path / real
        said = exported(getattr(models, name), folder, real, *SANITIZERS)
        assert " 0 checks failed" in said


@needs_gcc
def test_what_swings_fast_is_tested_in_steps_that_it_bears(tmp_path: Path) -> None:
    """A second in 64 steps is twice what a mass of 250 Hz bears; the datasheet tells how much that is."""
    t, u, v = Input("t", "s"), Input("u", "N"), State("v", rate=0).symbol
    k, c, m = Parameter("k", "N/m", 2.5e6), Parameter("c", "N*s/m", 400.0), Parameter("m", "kg", 1.0)
    z = State("z", 0.0, rate=v, unit="m", substeps=4)
    fast = State("v", 0.0, rate=(u - k * z - c * v) / m, unit="m/s")
    swing = Model("swing", (t, u), (k, c, m), (z, fast, Equation("F", k * z, "N")), ("F",))
    assert " 0 checks failed" in exported(swing, tmp_path, "double")
    assert "more than 0.007 s is unstable" in (tmp_path / "DATASHEET.md").read_text()


@needs_gcc
def test_models_of_a_user_and_several_in_one_folder(tmp_path: Path) -> None:
    choice = Piecewise((sqrt(Input("x")), Input("x").symbol >= 0), (-Input("x"), True))
    y, unused = Equation("y", choice * 2), Parameter("in", "1", 2.0)
    folded = Model("folded", (Input("x"),), (unused,), (y,), ("y",))
    looped = replace(decay(substeps=6), id="looped")
    for model in (decay(), looped, folded, models.modified_dahl):
        said = exported(model, tmp_path, "float")
    assert [line.split()[0] for line in said.splitlines() if "checks failed" in line] == [
        "decay", "folded", "looped", "modified_dahl",
    ]  # fmt: skip
    sheet = (tmp_path / "DATASHEET.md").read_text()
    assert [line for line in sheet.splitlines() if line.startswith("## ")] == [
        "## decay", "## folded", "## looped", "## modified_dahl",
    ]  # fmt: skip


def test_one_sample_at_a_time_gives_what_the_batch_gives() -> None:
    model = models.modified_dahl
    t = np.linspace(0.0, 2.0, 201)
    z = 3 * np.sin(2 * np.pi * t)
    v = 6 * np.pi * np.cos(2 * np.pi * t)
    turn = np.concatenate([z[:1], z[:-1]])
    wanted = build(model)(t=t, z=z, v=v, a=0 * t, z_turn=turn)
    unit = make_unit(model)
    c = Compiled(unit, "double", render_c(unit, "double"))
    p = [model.parameter(s.name).default or 0.0 for s in unit.parameters]
    found = [c.call("start" if k == 0 else "step", p, (z[k], v[k]))[1][0] for k in range(len(t))]
    assert np.array(found) == pytest.approx(np.asarray(wanted), rel=1e-13)


AWKWARD = (0.0, -0.0, 1e-310, -5e-324, 1e-30, 1.0, -1.0, 1e30, 1e308, -1e308, np.inf, -np.inf, np.nan)


@pytest.mark.parametrize("name", QUICK)
@pytest.mark.parametrize("real", REALS)
def test_no_number_spoils_the_state_or_gives_what_is_none(name: str, real: str) -> None:
    model = getattr(models, name)
    unit = make_unit(model)
    c = Compiled(unit, real, render_c(unit, real))
    p = [model.parameter(s.name).default or 0.0 for s in unit.parameters]
    calls = ("step", "step_jacobian") if unit.steps else ("evaluate", "jacobian")
    if unit.steps:
        c.call("start_jacobian", p, [0.1] * len(unit.inputs))
    with np.errstate(over="ignore"):
        for values, call in itertools.product(itertools.product(AWKWARD, repeat=len(unit.inputs)), calls):
            before = c.state.copy()
            status, out, jac = c.call(call, p, values)
            assert np.isfinite(c.state).all()
            if status:
                assert np.isnan(out).all() and (c.state == before).all()
            else:
                assert np.isfinite(out).all()
                assert np.isfinite(jac).all() or not call.endswith("jacobian")


def test_no_parameter_makes_a_call_hang() -> None:
    rng = np.random.default_rng(0)
    for name in ("complex_stiffness", "contact_damping"):
        unit = make_unit(getattr(models, name))
        c = Compiled(unit, "float", render_c(unit, "float"))
        with np.errstate(over="ignore"):
            for _ in range(300):
                p = rng.choice(AWKWARD, len(unit.parameters)).tolist()
                status, out, _ = c.call("evaluate", p, rng.choice(AWKWARD, len(unit.inputs)).tolist())
                assert status in (0, 1) and (status == 1 or np.isfinite(out).all())


def test_single_precision_is_the_double_program_token_by_token() -> None:
    text = 'double y = exp(1.0) + 2 * x[3] + 1e-3; /* double 1.0 */ f("exp 1.0"); p->expo; 1e300 * 1e-300'
    assert single(text) == (
        'float y = expf(1.0f) + 2 * x[3] + 0.001f; /* double 1.0 */ f("exp 1.0"); p->expo; INFINITY * 0.0f'
    )


def test_a_fixed_parameter_is_a_number_in_the_code() -> None:
    unit = make_unit(models.modified_dahl, {"b": 1.0})
    text = render_c(unit, "float")["modified_dahl.c"]
    assert "mg_dahl_step" not in text and "powf" not in text and "expf(" in text
    assert "b" not in {s.name for s in unit.parameters}


def on_board(unit: Unit, real: str, core: arm.Core) -> arm.Footprint:
    files = render_c(unit, real) | emulator_files(unit, real, *make_vectors(unit, real, {}))
    return arm.measure(core, unit.prefix, files)


@needs_arm
@pytest.mark.parametrize("core", arm.CORES, ids=lambda c: c.name)
@pytest.mark.parametrize("real", REALS)
def test_it_runs_on_a_microcontroller(core: arm.Core, real: str) -> None:
    found = on_board(make_unit(models.modified_dahl), real, core)
    assert found.passed
    assert found.static_ram == 0
    assert found.errors["F"] < {"double": 4e-16, "float": 2.5e-7}[real]
    assert 0 < found.costs["step"].stack < 400


@needs_arm
def test_a_dahl_step_takes_at_most_150_instructions() -> None:
    found = on_board(make_unit(models.modified_dahl), "float", arm.CORES[0])
    again = on_board(make_unit(models.modified_dahl), "float", arm.CORES[0])
    assert found.costs["step"].usual <= 150
    assert found.costs == again.costs  # counted, not timed


@needs_arm
@pytest.mark.slow
@pytest.mark.parametrize("name", [n for n in models.SHIPPED if n != "modified_dahl"])
def test_all_models_run_on_a_microcontroller(name: str) -> None:
    for core, real in zip(arm.CORES, ("float", "double"), strict=True):
        assert on_board(make_unit(getattr(models, name)), real, core).passed, (core.name, real)


@needs_arm
def test_without_the_tools_the_datasheet_says_what_is_not_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(arm, "QEMU", "no-such-emulator")
    export(models.modified_dahl, "c99", tmp_path, Settings("float"))
    sheet = (tmp_path / "DATASHEET.md").read_text()
    assert "Instructions a call: not measured, because no-such-emulator is not installed." in sheet
    assert "Flash: not measured" in sheet


def test_a_failed_self_test_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    costs = {r.name: arm.Cost(1, 1, 8) for r in make_unit(models.modified_dahl).routines}
    bad = arm.Footprint("Cortex-M4F", 1, 1, 0, 1, 1, 8, costs, passed=False)
    monkeypatch.setattr("modelgen.export.datasheet.arm.missing_tools", lambda: ())
    monkeypatch.setattr("modelgen.export.datasheet.arm.measure", lambda *_: bad)
    monkeypatch.setattr("modelgen.export.datasheet.arm.versions", lambda: ("", ""))
    with pytest.raises(ToolError, match="modified_dahl: its self-test fails on Cortex-M4F"):
        export(models.modified_dahl, "c99", tmp_path, Settings("float"))
    assert "FAILED" in (tmp_path / "DATASHEET.md").read_text()


def test_exporting_again_changes_no_byte(tmp_path: Path) -> None:
    texts = []
    for _ in range(2):
        files = export(models.electrodynamic_transducer, "c99", tmp_path, Settings("double", measure=False))
        texts.append([f.read_bytes() for f in files])
    assert texts[0] == texts[1]


def test_a_datasheet_keeps_the_sections_of_others() -> None:
    first = merge("", "b", "## b\n\nold\n")
    both = merge(first, "a", "## a\n\ntext\n\n### Cost\n")
    assert both.index("## a") < both.index("### Cost") < both.index("## b")
    assert "old" not in merge(both, "b", "## b\n\nnew\n")


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        (Settings("half"), "unknown precision 'half'"),
        (Settings(fix=["k_d=1"]), "no parameter 'k_d'.*k_D"),
        (Settings(fix=["k_D=x"]), "'x' is not a number"),
        (Settings(ranges=["zz=1:2"]), "no input 'zz'"),
        (Settings(ranges=["z=2:1"]), "2 is not below 1"),
        (Settings(name="1x"), "is not a name"),
    ],
)
def test_wrong_settings_are_answered_in_one_line(settings: Settings, says: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=says):
        export(models.modified_dahl, "c99", tmp_path, settings)
    assert not list(tmp_path.iterdir())


def test_unknown_targets_are_answered_with_those_there_are(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="unknown target 'c98', did you mean 'c99'"):
        export(models.modified_dahl, "c98", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_model_without_a_value_where_it_is_tested_asks_for_a_range(tmp_path: Path) -> None:
    x = Input("x", "1")
    model = Model("m", (x,), (Parameter("a", "1", 1.0),), (Equation("y", sqrt(-2 - x * x) * exp(0)),), ("y",))
    with pytest.raises(InputError, match=r"no finite value where it is tested; give --range for x \[1\]"):
        export(model, "c99", tmp_path, Settings(measure=False))


@needs_gcc
def test_a_model_without_parameters_has_no_jacobian(tmp_path: Path) -> None:
    x = Input("x", "1")
    model = Model("plain", (x,), (), (Equation("y", x * x),), ("y",))
    assert "worst_error" in exported(model, tmp_path, "float")
    assert "jacobian" not in (tmp_path / "plain.h").read_text().lower()
