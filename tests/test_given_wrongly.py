"""What users mistake: each is said in a line that names the thing, what was found and what was wanted."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sympy import Symbol, tanh

import modelgen as mg
from modelgen.cli.methods import read_method
from modelgen.effects import Effect, Shape, Strength
from modelgen.effects.effect import add
from modelgen.errors import InputError
from modelgen.export.values import parse_fixed
from modelgen.fit.series import signature_of
from modelgen.language import Equation, Input, Model, Parameter, Port, State, j, rate_of
from modelgen.models import load

t, z = Input("t", "s"), Input("z", "mm")
k = Parameter("k", "N/mm", 1.0, (0.1, 10.0))
T = Parameter("T", "s", 1.0)
F = Equation("F", k * z, "N")
PORT = Port("mount", "force", "F", (("z", z),))
SPRING = Model("spring", (t, z), (k,), (F,), ("F",), (PORT,))


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Parameter("k", "N/mm", "ten"), "'k': default: found 'ten'"),  # type: ignore[arg-type]
        (lambda: Parameter("k", "N/mm", 1.0, (0.1,)), r"bounds are \(0.1,\)"),  # type: ignore[arg-type]
        (lambda: Parameter("k", "N/mm", 1.0, (0, "1")), "'k': bounds: found '1'"),  # type: ignore[arg-type]
        (lambda: Parameter("k", known="no"), "'k': known: found 'no', wanted True or False"),  # type: ignore[arg-type]
        (lambda: State("x", rate=z, stiff="no"), "'x': stiff: found 'no', wanted True"),  # type: ignore[arg-type]
        (lambda: Model("s", (t, z), (k,), (F,), ("F",), PORT), "ports is of type Port"),  # type: ignore[arg-type]
        (lambda: Model("s", (t, z), k, (F,), ("F",)), "parameters is of type Parameter"),  # type: ignore[arg-type]
        (lambda: Port("mount", "force", "F", ("z", z)), "'mount': variables are no pairs of name and"),
        (
            lambda: Model("s", (t, z), (k,), (Equation("F", k * Symbol("z_prev", real=True), "N"),), ("F",)),
            r"'z_prev' is not declared: .* previous\(z\)",
        ),
        (
            lambda: Model("s", (z, t, rate_of(z, "v", "mm/s")), (k,), (F,), ("F",)),
            "first input is 'z', wanted 't', along which 'v' is formed",
        ),
        (
            lambda: Model("s", (z, t), (T,), (State("x", 0, rate=(z - Symbol("x")) / T, unit="mm"),), ("x",)),
            "first input is 'z', wanted 't', along which 'x' is formed",
        ),
        (
            lambda: Model("s", (z, t), (k,), (F,), ("F",)),
            "'s': its first input is 'z', wanted 't', which orders samples",
        ),
        (
            lambda: Model("s", (t, z), (k,), (Equation("F", k * z / (z - z), "N"),), ("F",)),
            "model 's', equation 'F': it divides by zero",
        ),
        (lambda: mg.build(SPRING, wrt="k"), "wrt is the text 'k'"),
        (lambda: mg.build(SPRING)(t=[0, 1], z=[0, 1], k=1j), "'k' .* is 1j, wanted a number"),
        (lambda: State("x"), "state 'x' has neither update nor rate, wanted one of them"),
        (lambda: State("x", 0, update=z, rate=z), "state 'x' has both update and rate, wanted one of them"),
        (lambda: mg.PSO(4.5), "particles = 4.5: a whole number is wanted"),  # type: ignore[arg-type]
        (lambda: mg.PSO(w="1"), "w = '1': a number is wanted"),  # type: ignore[arg-type]
        (lambda: mg.MultiStart(0), r"inner = 0: a method is wanted; .* MultiStart\(starts=20\)"),  # type: ignore[arg-type]
        (lambda: read_method("pso(-3)"), "wanted pso or pso"),
        (lambda: read_method("pso(40) > ipopt"), "lone > in 'pso.*, wanted >> between methods"),
        (lambda: read_method("pso >> "), "before and after each >>"),
        (lambda: parse_fixed(SPRING, ["k=-1"]), "outside the bounds of 'k'"),
        (lambda: load(""), "wanted an id"),
        (lambda: load("."), "is a folder"),
    ],
)
def test_it_is_refused(make: Callable[[], Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        make()


def case_of(folder: Path, model: str, header: str, rows: Any, more: str = "") -> tuple[Model, Any]:
    np.savetxt(folder / "r.csv", rows, delimiter=",", header=header, comments="")
    (folder / "case.toml").write_text(f'model = "{model}"\n{more}\n[[recording]]\nfile = "r.csv"\n')
    return mg.open_case(folder / "case.toml")


SWING = np.linspace(0, 6, 200)


def test_a_record_of_one_sample(tmp_path: Path) -> None:
    model, case = case_of(tmp_path, "kelvin_voigt", "t [s],z [mm],F_m [N]", [[0.0, 1.0, 2.0]])
    with pytest.raises(InputError, match="one sample only"):
        mg.fit(model, case)


def test_settings_of_a_fit_and_a_diagnosis(tmp_path: Path) -> None:
    rows = np.column_stack([SWING, np.sin(SWING), 2 * np.sin(SWING)])
    model, case = case_of(tmp_path, "kelvin_voigt", "t [s],z [mm],F_m [N]", rows)
    for seed in ("x", -1):
        with pytest.raises(InputError, match="seed: found"):
            mg.fit(model, case, seed=seed)
        with pytest.raises(InputError, match="seed: found"):
            mg.diagnose(case, model, seed=seed)
    for law, found in ((friction(), "something of type Effect"), ("own.py", "'own.py', .*load_effects")):
        with pytest.raises(InputError, match=f"effects: found {found}"):
            mg.diagnose(case, model, effects=law)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="start: found something of type list, wanted values by name"):
        mg.fit(model, case, start=[1, 2])  # type: ignore[arg-type]
    with pytest.raises(InputError, match="start: 'k_D' is 'a'"):
        mg.fit(model, case, start={"k_D": "a"})


def test_a_complex_output_over_time() -> None:
    model = Model("s", (t, z), (k,), (Equation("F", k * z * (1 + j), "N"),), ("F",))
    with pytest.raises(InputError, match="'F' is complex, and runs over time"):
        signature_of(model)


def test_a_sweep_that_knows_when_it_was_taken() -> None:
    """Frequencies order it, whatever its time."""
    f = Input("f", "Hz")
    assert Model("s", (f, t), (k, T), (Equation("K", k * t / (t + T), "N/mm"),), ("K",)).axis == "f"


def test_a_phase_in_degrees_that_is_said_to_be_in_radian(tmp_path: Path) -> None:
    f = np.geomspace(10, 1000, 60)
    Z = np.exp(1j * np.linspace(0, 9, 60)) * 5
    rows = np.column_stack([f, np.abs(Z), np.degrees(np.angle(Z))])
    head = "f [Hz],|Z| [ohm],phase [rad]"
    (warning,) = case_of(tmp_path, "electrodynamic_transducer", head, rows)[1].warnings
    assert "as a phase in degrees" in warning
    rows[:, 2] = np.linspace(-10, -80, 60)
    (warning,) = case_of(tmp_path, "electrodynamic_transducer", head, rows)[1].warnings
    assert warning.endswith("'phase [rad]': phases up to 80 rad: degrees?")
    rows[:, 2] = np.linspace(0, -7, 60)
    assert not case_of(tmp_path, "electrodynamic_transducer", head, rows)[1].warnings
    head = "f [Hz],|Z| [ohm],phase [deg]"
    assert not case_of(tmp_path, "electrodynamic_transducer", head, rows)[1].warnings


def friction(**more: Any) -> Effect:
    law = add(lambda at, p: p["F_s"] * tanh(at["v"] / p["v_s"]))
    shape = Shape("v_s", "{v}", "speed", 0.001, 1.0)
    strength = Strength("F_s", "{port}", text="level")
    given: dict[str, Any] = {"kinds": ("force",), **more}
    kinds = given.pop("kinds")
    return Effect("seal", kinds, "dry friction of the seal", "own", (strength,), law, (shape,), **given)


@pytest.mark.slow
def test_an_own_law_of_speed_at_a_port_that_tells_displacement_alone(tmp_path: Path) -> None:
    """Ports are completed before laws are looked at."""
    v, rng = 2 * np.cos(2 * SWING), np.random.default_rng(1)
    force = 3 * np.sin(2 * SWING) + 4 * np.tanh(v / 0.5) + rng.normal(0, 0.05, SWING.size)
    rows = np.column_stack([SWING, np.sin(2 * SWING), force])
    (tmp_path / "s.py").write_text(
        "from modelgen.language import *\nt, z = Input('t', 's'), Input('z', 'mm')\n"
        "k = Parameter('k', 'N/mm', 1.0, (0.1, 10.0))\nF = Equation('F', k * z, 'N')\n"
        "s = Model('s', (t, z), (k,), (F,), ('F',), (Port('mount', 'force', 'F', (('z', z),)),))\n"
    )
    model, case = case_of(tmp_path, "s.py:s", "t [s],z [mm],F [N]", rows, "[noise]\nF = 0.05")
    verdict = mg.diagnose(case, model, effects=[friction()])
    assert {"seal", "coulomb_friction"} & {i for e in verdict.effects for i in (e.id, *e.equivalents)}
    with pytest.raises(InputError, match="kinds is text"):
        mg.diagnose(case, model, effects=[friction(kinds="force")])


def test_a_model_with_nothing_free_is_diagnosed(tmp_path: Path) -> None:
    v, rng = 2 * np.cos(2 * SWING), np.random.default_rng(1)
    force = 3 * np.sin(2 * SWING) + 0.5 * v + rng.normal(0, 0.05, SWING.size)
    known = "[constants]\nk_D = 3.0\nc_D = 0.5\nF_0 = 0.0\n[noise]\nF_m = 0.05"
    rows = np.column_stack([SWING, np.sin(2 * SWING), force])
    model, case = case_of(tmp_path, "kelvin_voigt", "t [s],z [mm],F_m [N]", rows, known)
    assert mg.diagnose(case, model).adequate
    rows[:, 2] += 4 * np.tanh(v / 0.5)
    model, case = case_of(tmp_path, "kelvin_voigt", "t [s],z [mm],F_m [N]", rows, known)
    assert [e.id for e in mg.diagnose(case, model).effects] == ["coulomb_friction"]
