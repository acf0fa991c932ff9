"""What users write in models and cases of their own, and how they are told of slips."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sympy import Symbol

from modelgen.api import open_case
from modelgen.cli import main
from modelgen.effects import CATALOGUE
from modelgen.effects.kinds import unknown_kinds
from modelgen.errors import InputError
from modelgen.fit.series import signature_of
from modelgen.language import (
    Condition,
    Equation,
    Implicit,
    Input,
    Model,
    Parameter,
    Port,
    State,
    complex_parameter,
    exp,
    j,
)
from modelgen.models import SHIPPED, load


def leaking(real: bool | None) -> Model:
    """A leaking tank whose quantities are all written as symbols, `real` or not."""
    t, q, k, h, left = (Symbol(n, real=real) for n in ("t", "q", "k", "h", "left"))
    root = Implicit("root", Symbol("root", real=real) ** 2 - h, (0, 2 * h**0.5), "cm**0.5")
    return Model(
        "leaking",
        (Input("t", "s"), Input("q", "cm/s")),
        (Parameter("k", "cm**0.5/s", 1.0, (0.1, 9.0)), Parameter("h_0", "cm", 2.0, (0.1, 9.0))),
        (
            State("h", Symbol("h_0", real=real), rate=q - k * h**0.5, unit="cm"),
            root,
            Equation("left", h, "cm"),
            Equation("twice", 2 * left, "cm"),
        ),
        ("twice",),
        (Port("out", "force", "left", (("z", h), ("t", t))),),
        conditions=(Condition("it leaks", k),),
    )


def test_a_plain_symbol_of_a_quantity_is_that_quantity() -> None:
    plain, real = leaking(None), leaking(True)
    assert plain == real and plain.hash == real.hash
    assert plain.ports[0]["z"] == plain["h"].symbol
    assert not signature_of(plain).outputs[0].complex


def test_what_is_complex_stays_complex() -> None:
    f, R = Input("f", "Hz"), Parameter("R", "ohm", 1.0)
    S = complex_parameter("S", "ohm", 1 + 2j)
    Y = Equation("Y", Symbol("S") * exp(j * Symbol("R") / Symbol("R")), "ohm")
    Z = Equation("Z", Symbol("Y") + Symbol("S_re"), "ohm")
    model = Model("z", (f,), (R, S), (Y, Z), ("Z",))
    assert model["Z"].complex
    assert model["Z"].expr == Y.symbol + S.re.symbol and Y.symbol.is_real is None


LAG = """
from modelgen.language import *
t, u = Input("t", "s"), Input("u", "V")
tau = Parameter("tau", "s", 0.2, (0.01, 10.0))
T_0 = Parameter("T_0", "K", 290.0, (280.0, 310.0))
x = State("x", T_0, rate=(Parameter("K", "K/V", 1.0, known=True) * u + T_0 - Symbol("x")) / tau, unit="K")
lag = Model("lag", (t, u), (tau, T_0, Parameter("K", "K/V", 1.0, known=True)), (x,), ("x",),
            (Port("thermometer", "KIND", "x"),))
"""
CASE = 'model = "lag.py:lag"\n[[recording]]\nfile = "lag.csv"\n'


@pytest.fixture
def lag(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a good case of a user's model, where the commands run."""
    t = np.arange(0, 4, 0.02)
    noise = 0.01 * np.random.default_rng(3).standard_normal(t.size)
    rows = np.stack([t, np.sin(3 * t), 291 + 0.9 * np.sin(3 * t - 0.5) + noise], axis=1)
    np.savetxt(tmp_path / "lag.csv", rows, delimiter=",", header="t [s],u [V],x [K]", comments="")
    (tmp_path / "lag.py").write_text(LAG.replace("KIND", "sensor"))
    (tmp_path / "case.toml").write_text(CASE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("kind", "near"), [("senser", ", did you mean 'sensor'?"), ("sensor", ""), ("qqqq", "")]
)
def test_a_misspelt_kind_of_port_is_told_by_every_command(
    kind: str, near: str, lag: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A kind that is near to none may be one for effects of the user's own."""
    (lag / "lag.py").write_text(LAG.replace("KIND", kind))
    told = f"port 'thermometer': no effect knows the kind '{kind}'"
    for arguments in (["fit", "case.toml"], ["build", "lag.py:lag"], ["export", "lag.py:lag"]):
        assert main(arguments) == 0
        out, err = capsys.readouterr()
        said = " ".join((out if arguments[0] == "fit" else err).split())
        assert (told + near in said) if near else ("no effect knows" not in said), arguments


def test_a_kind_of_port_that_no_effect_of_a_diagnosis_knows() -> None:
    """Where the user's effects are there to be seen, a kind that is near to none is unknown, too."""
    model = replace(load("kelvin_voigt"), ports=(Port("mount", "nokind", "F"),))
    (note,) = unknown_kinds(model, ())
    assert note.startswith("port 'mount': no effect knows the kind 'nokind'; known are capacitance, ")
    (own, *_) = CATALOGUE
    assert unknown_kinds(model, (replace(own, kinds=("nokind",)),)) == ()
    assert not any(unknown_kinds(load(id), ()) for id in SHIPPED)


def test_bounds_in_another_unit_than_the_model_s_are_refused(lag: Path) -> None:
    for bounds, apart in (("[17, 27]", True), ("[310, 400]", True), ("[200, 281]", False)):
        (lag / "case.toml").write_text(CASE.replace("[[rec", f"[bounds]\nT_0 = {bounds}\n[[rec"))
        if not apart:
            open_case("case.toml")
            continue
        with pytest.raises(InputError) as told:
            open_case("case.toml")
        assert str(told.value) == (
            f"case.toml, [bounds] T_0 = {bounds}: apart from lag's own bounds [280, 310]; "
            "numbers of a case are in the model's units, here K"
        )


LINE = """
from modelgen.language import Equation, Input, Model, Parameter

x, a, b = Input("x", ""), Parameter("a", "", 1.0), Parameter("b", "dimensionless", 1.0)
line = Model("line", (x,), (a, b), (Equation("y", a * x + b, "-"),), ("y",))
"""


def test_a_pure_number_has_the_unit_1_however_it_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    x = np.linspace(0.1, 1, 40)
    y = 2 * x + 1 + 0.01 * np.random.default_rng(0).standard_normal(40)
    np.savetxt(tmp_path / "record.csv", np.c_[x, y], delimiter=",", header="x [1],y [1]", comments="")
    (tmp_path / "line.py").write_text(LINE)
    (tmp_path / "case.toml").write_text('model = "line.py:line"\n[[recording]]\nfile = "record.csv"\n')
    for command in ("fit", "diagnose"):
        to = tmp_path / f"{command}.json"
        assert main([command, str(tmp_path / "case.toml"), "--json", str(to)]) == 0
        told = json.loads(to.read_text())
        assert {p["unit"] for p in told["parameters"].values()} == {"1"}
        out = capsys.readouterr().out
        if command == "fit":
            assert told["rms"]["unit"] == "1" and list(told["rms_by_unit"]) == ["1"]
            rows = [line.split() for line in out.splitlines() if line.startswith(("a ", "b "))]
            assert [row[-1] for row in rows] == ["1", "1"]
        else:
            assert told["fit"]["unit"] == "1" and "fit [1]" in out


@pytest.mark.parametrize("count", [10**7, 0, -2, 1.5, "4", True])
def test_substeps_are_a_whole_number_from_1(count: object) -> None:
    t, T = Input("t", "s"), Parameter("T", "s", 1.0)
    x = State("x", 1, rate=-Symbol("x") / T, substeps=count)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"'m', state 'x': substeps is .*, wanted a whole number from 1"):
        Model("m", (t,), (T,), (x,), ("x",))
