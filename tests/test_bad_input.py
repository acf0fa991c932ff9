"""Wrong input through the command line: one line on stderr, exit status 2, nothing written."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modelgen.cli import main
from modelgen.codegen.compiler import find_compiler

ROOT = Path(__file__).parents[1]
SWEEP = "f [Hz],Re Z [ohm],Im Z [ohm]\n" + "".join(
    f"{f},{6 + 3 / (1 + ((f - 60) / 9) ** 2):.4f},{0.003 * f:.4f}\n" for f in range(20, 420, 20)
)
CASE = 'model = "electrodynamic_transducer"\n[constants]\nM_m = 0.015\n[[recording]]\nfile = "sweep.csv"\n'
SPRING = """
from modelgen.language import *
f = Input("f", "Hz")
R, X = Parameter("R", "ohm", 1.0), Parameter("X", "ohm*s", 1e-3)
Z = Equation("Z", R + j * f * X, "ohm")
coil = Model("coil", inputs=(f,), parameters=(R, X), statements=(Z,), outputs=("Z",))
"""
Run = Callable[..., str]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a good case, where the commands run."""
    (tmp_path / "sweep.csv").write_text(SWEEP)
    (tmp_path / "case.toml").write_text(CASE)
    (tmp_path / "coil.py").write_text(SPRING)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    """Run a command that must be refused; returns its one line."""

    def run(*arguments: str, status: int = 2) -> str:
        before = contents(folder)
        assert main(arguments) == status
        out, err = capsys.readouterr()
        assert out == "" and err.count("\n") == 1 and err.startswith("modelgen: "), (out, err)
        assert "Traceback" not in err and contents(folder) == before
        return err.removeprefix("modelgen: ").rstrip("\n")

    return run


def contents(folder: Path) -> dict[str, bytes]:
    files = (p for p in folder.rglob("*") if p.is_file() and "__pycache__" not in p.parts)
    return {str(p): p.read_bytes() for p in files}


def test_the_case_itself_is_good(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fit", "case.toml", "--json", "fit.json"]) == 0
    assert "Bl" in capsys.readouterr().out and (folder / "fit.json").exists()


LAW = """
from modelgen.effects import Effect, Strength
from modelgen.effects.effect import add
e = Effect("rub", ("mechanical_impedance",), "", "", (Strength("R", "{port}"),), add(lambda at, p: p["R"]))
"""


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ('at["omga"]', "'rub': neither port 'mechanical' of .* a 'omga', did you mean 'omega'"),
        ('p["r"]', "a 'r', did you mean 'R'"),
        ('__import__("math").sin(p["R"])', "'rub' at .*: TypeError: .*sin, exp, … of modelgen.language"),
        ('p["R"] / int("x")', "'rub' at port 'mechanical' of electrodynamic_transducer: ValueError"),
    ],
)
def test_an_effect_whose_law_fails_is_refused(folder: Path, refused: Run, wrong: str, says: str) -> None:
    (folder / "rub.py").write_text(LAW.replace('p["R"]', wrong))
    assert re.search(says, refused("diagnose", "case.toml", "--effects", "rub.py"))


LAG = """
from modelgen.language import *
t, u = Input("t", "s"), Input("u", "N")
tau, K = Parameter("tau", "s", 0.2, (0.01, 10.0)), Parameter("K", "mm/N", 1.0, (0.0, 10.0))
x = State("x", 0.0, rate=(K * u - Symbol("x", real=True)) / tau, unit="mm")
lag = Model("lag", (t, u), (tau, K), (x,), ("x",))
"""


def test_a_state_may_be_an_output_and_units_and_names_in_brackets_are_printed(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    t = np.arange(0, 4, 0.02)
    noise = 0.01 * np.random.default_rng(3).standard_normal((2, len(t)))
    text = 'model = "lag.py:lag"\nper_recording = ["tau"]\n'
    for name, e in zip("ab", noise, strict=True):
        rows = np.stack([t, np.sin(3 * t), 2 * np.sin(3 * t - 0.5) + e], axis=1)
        np.savetxt(folder / f"{name}.csv", rows, delimiter=",", header="t [s],u [N],x [mm]", comments="")
        text += f'[[recording]]\nfile = "{name}.csv"\n'
    (folder / "lag.py").write_text(LAG)
    (folder / "lag.toml").write_text(text)
    assert main(["fit", "lag.toml"]) == 0
    told = capsys.readouterr().out
    assert "tau[a]" in told and "tau[b]" in told
    assert main(["diagnose", "lag.toml"]) == 0
    assert "fit [mm]" in capsys.readouterr().out


TABLES = {
    "": "empty",
    "f [Hz],Re Z [ohm],Im Z [ohm]\n": "no data|no line|empty|no row",
    SWEEP.replace("40,", "40,nan,", 1).replace(",nan,6", ",nan", 1): "line 3",
    SWEEP.replace("40,", "forty,", 1): "line 3.*forty",
    SWEEP.replace("f [Hz]", "f [m]"): "f.*'m'",
    SWEEP.replace("f [Hz]", "f [herz]"): "herz",
    SWEEP.replace("f [Hz]", "f"): "f.*unit",
    SWEEP.replace("Re Z [ohm]", "Re Z"): "Re Z.*unit",
    SWEEP + "400,6,1\n": "400",
    SWEEP.replace("Im Z [ohm]", "Re Z [ohm]"): "Re Z",
    "f [Hz],Re Z [ohm],Im Z [ohm]\n20,6,0\n40,6,1\n": "4 data values cannot determine 5 parameters",
    "f [Hz],x [m]\n1,2\n2,3\n": "Z",
    "\x00\x01\x02": "sweep.csv",
    "f [Hz],Re Z [ohm],Im Z [ohm]\n" + "".join(f"{f},0,0\n" for f in range(1, 21)): "zero in all 20 rows",
    SWEEP.replace("\n40,", "\n40,1e300,1\n41,", 1): "line 3, column 'Re Z.*1e\\+300 is too large",
    SWEEP.replace("\n40,", "\n40,0,0\n41,", 1): "line 3: 'Z' is zero there",
    "f [Hz];|Z| [ohm]\n20;6,1\n40;1.234,5\n60;7\n": "line 3, column '\\|Z.*'1.234,5' has a point",
}


@pytest.mark.parametrize(("table", "says"), TABLES.items(), ids=range(len(TABLES)))
def test_tables(table: str, says: str, folder: Path, refused: Run) -> None:
    (folder / "sweep.csv").write_text(table)
    for command in ("fit", "diagnose"):
        line = refused(command, "case.toml", "--json", "out.json")
        assert matches(says, line), line


def matches(says: str, line: str) -> bool:
    import re

    return re.search(says, line) is not None


CASES = {
    CASE.replace("sweep.csv", "sweeep.csv"): "sweeep.csv",
    CASE.replace(
        "electrodynamic", "electrodinamic"
    ): "unknown model.*did you mean 'electrodynamic_transducer'",
    CASE.replace("M_m", "M_n"): "no parameter 'M_n', did you mean 'M_m'",
    CASE.replace("[[rec", "[bounds]\nBl = [9, 1]\n[[rec"): "Bl = \\[9, 1\\]: wanted low below high",
    CASE.replace("[[rec", "[bounds]\nM_m = [0.01, 0.1]\n[[rec"): "M_m: has a bound and a constant",
    CASE.replace("[[rec", "[noise]\nZZ_relative = 1e-3\n[[rec"): "no such channel",
    CASE.replace("M_m = 0.015", "M_m = 'heavy'"): "wanted a number",
    CASE.replace("M_m = 0.015", "M_m = nan"): "wanted a finite number",
    CASE.replace("M_m = 0.015", "M_m = "): "line 3",
    CASE + "[noise]\nZ = 1\n[noise]\nZ_relative = 1\n": (
        "line 8: a second \\[noise\\], first in line 6: wanted one, with all that is in both$"
    ),
    CASE.replace("M_m = 0.015", "M_m = 0.015\nM_m = 2"): "line 4: 'M_m' is given twice, first in line 3$",
    CASE.replace("M_m = 0.015", "M_m = [1,\n2]\nM_m = [2,\n3]"): "'M_m' is given twice, first in line 3$",
    CASE + "noise = { Z = 1, Z = 2 }\n": "line 6: 'Z' is given twice$",
    CASE
    + "[recording]\n": "line 6: \\[recording\\] .*first in line 4: wanted \\[\\[recording\\]\\] for each$",
    CASE.replace("M_m = 0.015", "M_m = -1"): "\\[constants\\] M_m: -1 is below 1e-09, its least value",
    CASE.replace("[[rec", "[bounds]\nR_e = [-9, -3]\n[[rec"): "\\[bounds\\] R_e: -3 is below",
    CASE.replace("[[rec", "[noise]\nZ = 1e300\n[[rec"): "Z = 1e\\+300: too large",
    CASE.replace("[[rec", "[noise]\nZ = 1e-300\n[[rec"): "Z = 1e-300: no such noise",
    CASE.replace('"sweep.csv"', "2024-01-01"): "file: the date 2024-01-01 found, wanted text in quotes$",
    CASE + 'role = "test"\n': 'wanted "fit" or "holdout"',
    CASE + 'role = "holdout"\n': 'no recording has role = "fit"',
    'per_recording = ["Cl"]\n' + CASE: "no parameter 'Cl', did you mean 'Bl'",
    CASE.replace("[constants]", '[options]\neddy = "exact"\n[constants]'): "has no options",
    "": "model: missing",
    CASE.replace("electrodynamic_transducer", "contact_damping"): "'contact_damping' has no input",
}


@pytest.mark.parametrize(("case", "says"), CASES.items(), ids=range(len(CASES)))
def test_cases(case: str, says: str, folder: Path, refused: Run) -> None:
    (folder / "case.toml").write_text(case)
    for command in ("fit", "diagnose"):
        line = refused(command, "case.toml", "--json", "out.json")
        assert matches(says, line), line


def test_a_motion_that_stands_still(folder: Path, refused: Run) -> None:
    (folder / "still.csv").write_text("t [s],z [mm],F_m [N]\n" + "".join(f"{k},2,{k}\n" for k in range(40)))
    (folder / "case.toml").write_text('model = "kelvin_voigt"\n[[recording]]\nfile = "still.csv"\n')
    for command in ("fit", "diagnose"):
        assert "'z' is 2 throughout, wanted a motion" in refused(command, "case.toml")


def test_the_file_of_a_model_is_not_overwritten(folder: Path, refused: Run) -> None:
    (folder / "case.toml").write_text(
        CASE.replace("electrodynamic_transducer", "coil.py:coil").replace("M_m", "R")
    )
    assert refused("fit", "case.toml", "--json", "coil.py") == (
        "cannot write coil.py: it is an input, which would be lost"
    )


def test_an_output_that_never_changes(folder: Path, refused: Run) -> None:
    rows = "".join(f"{20 * 1.1**k},8,0\n" for k in range(60))
    (folder / "flat.csv").write_text("f [Hz],Re Z [ohm],Im Z [ohm]\n" + rows)
    (folder / "case.toml").write_text(CASE.replace("sweep.csv", "flat.csv"))
    for command in ("fit", "diagnose"):
        assert "'Z' is 8+0j throughout and its noise is not stated" in refused(command, "case.toml")


def test_other_separators_and_decimal_commas_read_the_same(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    results = []
    for change in ("", ",;", ",\t", ",;.,", ",\t.,"):
        text = SWEEP
        for old, new in zip(change[::2], change[1::2], strict=True):
            text = text.replace(old, new)
        (folder / "sweep.csv").write_text(text)
        assert main(["fit", "case.toml"]) == 0
        out = capsys.readouterr().out
        assert ("commas are read as decimal marks" in out) == (len(change) == 4)
        results.append([line for line in out.splitlines() if line.startswith(("R_e", "Bl"))])
    assert results == [results[0]] * 5


def test_a_case_that_leaves_nothing_free(folder: Path, refused: Run) -> None:
    held = "R_e = 6\nL_e = 1e-3\nBl = 5\nM_m = 1\nK_m = 1\nR_m = 1"
    (folder / "case.toml").write_text(CASE.replace("M_m = 0.015", held))
    assert refused("fit", "case.toml").startswith("nothing to fit")


OPTIONS = {
    ("fit", "nothing.toml"): "nothing.toml: no such file",
    ("fit", ".", "--plot", "fit.svg"): "--plot is for one case, and '.' is a folder",
    ("diagnose", ".", "--report", "a.html"): "--report a.html is of one case",
    ("fit",): "CASE.toml",
    ("fit", "case.toml", "--start", "Bl=1e9"): "'Bl': start 1e\\+09 is outside its bounds",
    ("fit", "case.toml", "--start", "B=1"): "'B' is not a free parameter, did you mean 'Bl'",
    ("fit", "case.toml", "--start", "Bl"): "NAME=VALUE",
    ("fit", "case.toml", "--method", "psso"): "unknown method 'psso', did you mean 'pso'",
    ("fit", "case.toml", "--method", ""): "--method: found '', wanted one of gauss-newton, ipopt",
    ("fit", "case.toml", "--method", "pso(0)"): "particles = 0: at least 1",
    ("fit", "case.toml", "--method", "pso >>"): "unknown method",
    ("fit", "case.toml", "--seed", "x"): "--seed",
    ("fit", "case.toml", "--seed", "-1"): "--seed",
    ("fit", "case.toml", "--start", "Bl=1", "--start", "Bl=2"): "'Bl' is given twice",
    ("fit", "case.toml", "--sead", "1"): "--sead",
    ("diagnose", "case.toml", "--html", "p.html"): "No such option: --html.*: the page is --report here",
    ("prove", "--report", "p.html"): "No such option: --report.*: the page is --html here",
    ("fit", "case.toml", "--json", "x.json", "--json", "y.json"): "--json is given twice, wanted once",
    ("export", "modified_dahl", "--fix", "b=1", "--fix", "b=2"): "--fix b=2: 'b' is given twice",
    ("export", "modified_dahl", "--fit", "."): "\\.: a folder, wanted a result",
    ("export", "modified_dahl", "--fit", "none.json"): "none.json: no such file",
    ("export", "modified_dahl", "--fit", "case.toml"): "case.toml: no result of `modelgen fit --json`",
    ("export", "modified_dahl", "--fix", "b=nan"): "--fix b=nan: a finite number is wanted",
    ("export", "modified_dahl", "--target", "fmu", "--fitter"): "--fitter belongs to --target c99",
    ("export", "modified_dahl", "--target", "fmu", "--real", "float"): "--real float belongs to --target c99",
    ("export", "modified_dahl", "--target", "fmu", "--range", "z=0:1"): "--range belongs to --target c99",
    ("export", "modified_dahl", "--range", "z=0:inf"): "finite numbers are wanted",
    ("export", "modified_dahl", "--range", "z=0:1", "--range", "z=0:2"): "'z' is given twice",
    ("export", "modified_dahl", "--range", "Z=0:1"): "no input 'Z', did you mean 'z'\\? it is one of t, z",
    ("fit", "case.toml", "--json", "case.toml"): "case.toml: it is an input, which would be lost",
    ("fit", ".", "--json", "case.toml"): "case.toml: it is an input, which would be lost",
    ("diagnose", "case.toml", "--json", "../{}/sweep.csv"): "sweep.csv: it is an input, which would be lost",
    ("diagnose", "case.toml", "--json", "a.html", "--report", "a.html"): "cannot write a.html twice",
    ("loops", "sweep.csv", "--json", "sweep.csv"): "sweep.csv: it is an input",
    ("modal", "sweep.csv", "--json", "sweep.csv"): "sweep.csv: it is an input",
    ("prove", "--trials", "1", "--html", "proof.pdf"): "--html proof.pdf: the page is HTML",
    ("prove", "--secret", "nowhere"): "nowhere: no such file or folder",
    ("prove", "--domain", "mechanics"): "it is one of impedance, gmm, force, stiffness",
    ("reproduce", "gmm", "--html", "page.pdf"): "--html page.pdf: the page is HTML",
    ("reproduce", "gm"): "no paper 'gm', did you mean 'gmm'\\? it is one of gmm, mre",
    ("fit", "case.toml", "--json", "missing/out.json"): "folder missing does not exist",
    ("fit", "case.toml", "--json", "."): "it is a folder",
    ("diagnose", "case.toml", "--report", "missing/out.html"): "folder missing does not exist",
    ("diagnose", "case.toml", "--out", "sweep.csv"): "sweep.csv is a file, a folder is wanted",
    ("diagnose", "case.toml", "--effects", "mine.py"): "no file 'mine.py' in ",
    ("diagnose", "case.toml", "--effects", "coil.py"): "has no effect in it",
    ("build", "modified_dal"): "unknown model 'modified_dal', did you mean 'modified_dahl'",
    ("build", "modified_dahl", "coil.py:cool"): "has no 'cool', did you mean 'coil'",
    ("build", "modified_dahl", "--out", "sweep.csv"): "sweep.csv is a file, a folder is wanted",
    ("build", "modified_dahl", "--out", "sweep.csv/generated"): "sweep.csv is a file, a folder is wanted",
    ("build", "coil.py:coil", "coil.py:coil"): "two models are called 'coil'",
    ("export", "modified_dahl", "--target", "fortran"): "unknown target 'fortran'.*c99",
    ("export", "modified_dahl", "--out", "case.toml"): "case.toml is a file, a folder is wanted",
    ("export",): "MODEL",
    ("dance",): "No such command 'dance'",
}


@pytest.mark.parametrize(("arguments", "says"), OPTIONS.items(), ids=[" ".join(a) for a in OPTIONS])
def test_options(arguments: tuple[str, ...], says: str, folder: Path, refused: Run) -> None:
    line = refused(*(a.format(folder.name) for a in arguments))
    assert matches(says, line), line


MODELS = {
    SPRING.replace("R + j", "R + + * j"): "coil.py, line 5: invalid syntax",
    SPRING.replace('"ohm*s"', '"N"'): "equation 'Z'.*can't be added",
    SPRING.replace('"ohm*s"', '"omh"'): "'X': unknown unit 'omh'",
    SPRING.replace(
        '"R", "ohm", 1.0', '"R", "ohm", 1.0, (2.0, 3.0)'
    ): "default 1 of 'R' is outside \\[2, 3\\]",
    SPRING.replace('"R", "ohm", 1.0', '"R", "ohm", 2.5, (3.0, 2.0)'): "bounds of parameter 'R' are reversed",
    SPRING.replace("(f,)", '(f, Input("R", "ohm"))'): "name 'R' is declared twice",
    SPRING.replace("(R, X)", "(R,)"): "'X' is not declared",
    SPRING.replace("R + j * f * X", "'R'"): "line 5: 'R' of type str is no expression",
    SPRING.replace("R + j * f * X", "Max(R, j * f * X)"): "complex numbers have no order, in Max",
    SPRING.replace('outputs=("Z",)', 'outputs=("z",)'): "output 'z' is no equation, did you mean 'Z'",
    SPRING.replace('"X"', '"X;exit(1)"'): "is not a name",
    SPRING.replace('("Z",))', '("Z",), ports=(Port("a", "terminals", "z"),))'): (
        "port 'a' of kind 'terminals': 'z' is no equation, did you mean 'Z'"
    ),
    SPRING.replace(
        '("Z",))',
        '("Z",), ports=(Port("a", "terminals", "Z", (("omega", __import__("sympy").Symbol("r")),)),))',
    ): ("port 'a': variable 'omega' is 'r', which the model does not have, did you mean 'R'"),
    SPRING.replace("coil =", "cool ="): "has no 'coil', did you mean 'cool'",
    SPRING + "raise ValueError('no')\n": "line 7: ValueError: no",
    SPRING + "import no_such_module\n": "line 7: ModuleNotFoundError",
    SPRING + "coil = 3\n": "'coil' in .* is of type int, not a Model",
    SPRING.replace("from modelgen.language import *", ""): "NameError",
    SPRING.replace("R + j", "__import__('math').sin(R) + j"): "sin, exp, … of modelgen.language, not of math",
    SPRING.replace("R + j", "__import__('math').sin(2 * R) + j"): "sin, exp, … of modelgen.language, not",
    SPRING.replace(
        "R + j", "__import__('numpy').sin(R) + j"
    ): "sin, exp, … of modelgen.language, not of math",
    SPRING.replace("R + j", "(R if f > 3 else 2 * R) + j"): "line 5: .*Piecewise.* of modelgen.language",
}


@pytest.mark.parametrize(("text", "says"), MODELS.items(), ids=range(len(MODELS)))
def test_models_of_the_user(text: str, says: str, folder: Path, refused: Run) -> None:
    (folder / "coil.py").write_text(text)
    (folder / "case.toml").write_text(
        CASE.replace("electrodynamic_transducer", "coil.py:coil").replace("M_m", "R")
    )
    for arguments in (("build", "coil.py:coil"), ("export", "coil.py:coil"), ("fit", "case.toml")):
        line = refused(*arguments)
        assert matches(says, line), line


def test_a_missing_file_of_a_model_is_told_with_its_folder(folder: Path, refused: Run) -> None:
    (folder / "sub").mkdir()
    (folder / "sub" / "case.toml").write_text(CASE.replace("electrodynamic_transducer", "coil.py:coil"))
    assert refused("fit", "sub/case.toml").startswith(
        f"no file 'coil.py' in {folder.resolve() / 'sub'}, wanted"
    )


def test_a_model_of_the_user_is_found_beside_its_case(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "case.toml").write_text(
        CASE.replace("electrodynamic_transducer", "coil.py:coil").replace("M_m", "R")
    )
    elsewhere = folder / "elsewhere"
    elsewhere.mkdir()
    os.chdir(elsewhere)
    assert main(["fit", "../case.toml"]) == 0
    assert "coil" in capsys.readouterr().out


def test_a_model_may_be_in_a_file_called_as_a_module_is(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`platform`, which others import while it runs."""
    (folder / "platform.py").write_text("import uuid\n" + (folder / "coil.py").read_text())
    (folder / "case.toml").write_text(
        CASE.replace("electrodynamic_transducer", "platform.py:coil").replace("M_m", "R")
    )
    for m in [m for m in sys.modules if m == "uuid"]:
        del sys.modules[m]
    assert main(["fit", str(folder / "case.toml")]) == 0
    assert "coil" in capsys.readouterr().out


@pytest.mark.parametrize("ports", ["", ', ports=(Port("a", "terminal", "Z"),)'])
def test_a_model_that_no_effect_fits_is_judged_all_the_same(
    ports: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "coil.py").write_text(SPRING.replace('("Z",))', f'("Z",){ports})'))
    (folder / "case.toml").write_text(
        CASE.replace("electrodynamic_transducer", "coil.py:coil").replace("M_m", "R")
    )
    assert main(["diagnose", "case.toml"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "which no effect explains" in said
    assert ("no effect knows the kind 'terminal', did you mean 'terminals'?" in said) is bool(ports)


def test_a_page_of_another_format_is_refused(folder: Path, refused: Run) -> None:
    (folder / "case.toml").write_text(CASE)
    line = refused("diagnose", "case.toml", "--report", "page.pdf")
    assert "the page is HTML" in line and not (folder / "page.pdf").exists()


def test_no_compiler(refused: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    find_compiler.cache_clear()
    try:
        line = refused("build", "coil.py:coil")
        assert line == "no C compiler: CC is set to 'no-such-compiler', which is not found"
        monkeypatch.delenv("CC")
        monkeypatch.setenv("PATH", str(tmp_path))
        monkeypatch.setattr("modelgen.codegen.compiler.find_spec", lambda name: None)
        find_compiler.cache_clear()
        assert "pip install ziglang" in refused("build", "coil.py:coil")
    finally:
        find_compiler.cache_clear()


def test_unsorted_frequencies_are_sorted_and_said(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    head, *rows = SWEEP.splitlines(keepends=True)
    results: list[Any] = []
    for order in (rows, rows[::2] + rows[1::2]):
        (folder / "sweep.csv").write_text(head + "".join(order))
        assert main(["fit", "case.toml"]) == 0
        results.append(capsys.readouterr().out)
    assert "sort" in results[1] and "sort" not in results[0]


def test_the_same_in_a_process_of_its_own(folder: Path) -> None:
    """As the shell sees it: status 2, one line, no traceback."""
    for arguments in (
        ["fit", "nothing.toml"],
        ["build", "modified_dal"],
        ["fit", "case.toml", "--json", "no/x.json"],
    ):
        done = subprocess.run(
            [sys.executable, "-c", "import sys; from modelgen.cli import main; sys.exit(main())", *arguments],
            capture_output=True, text=True, env={**os.environ, "PYTHONPATH": str(ROOT)}, cwd=folder,
        )  # fmt: skip
        assert done.returncode == 2 and done.stdout == ""
        assert done.stderr.startswith("modelgen: ") and done.stderr.count("\n") == 1


@pytest.mark.skipif(sys.platform == "win32", reason="a closed pipe is told otherwise there")
@pytest.mark.parametrize(
    "arguments",
    [["fit", "case.toml", "--json", "out.json"], ["fit", ".", "--json", "out.json"], ["list"], ["--help"]],
)
def test_a_reader_that_goes_is_no_error(arguments: list[str], folder: Path) -> None:
    """As `| head` does: status 0 and nothing on stderr, and what is written to files is whole."""
    reading, writing = os.pipe()
    os.close(reading)
    code = "import sys; from modelgen.cli import main; sys.exit(main())"
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        stdout=writing, stderr=subprocess.PIPE, text=True, cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    os.close(writing)
    assert (done.returncode, done.stderr) == (0, "")
    assert (folder / "out.json").exists() is ("--json" in arguments)


def test_a_fit_that_is_right_is_not_refused_for_lack_of_noise(folder: Path) -> None:
    """A record without any scatter still has a noise level other than 0."""
    f = np.arange(20, 420, 20)
    rows = "".join(f"{x},{6.0},{0.003 * x}\n" for x in f)
    (folder / "sweep.csv").write_text("f [Hz],Re Z [ohm],Im Z [ohm]\n" + rows)
    (folder / "case.toml").write_text(CASE.replace("electrodynamic_transducer", "coil.py:coil").replace(
        "[constants]\nM_m = 0.015\n", ""))  # fmt: skip
    assert main(["fit", "case.toml"]) == 0


@pytest.mark.skipif(sys.platform == "win32", reason="limits of a process are POSIX")
def test_a_full_disk_leaves_nothing_half_written(folder: Path) -> None:
    """Files of at most 3 kB: too small for a compiled model, its C, and a plot."""
    code = "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (3000, 3000)); "
    code += "from modelgen.cli import main; sys.exit(main())"
    assert main(["fit", "case.toml"]) == 0  # compiled by now
    before = contents(folder)
    for arguments in (
        ["fit", "case.toml", "--plot", "fit.png"],
        ["build", "coil.py:coil", "--out", "generated"],
        ["export", "coil.py:coil", "--out", "exported"],
    ):
        done = subprocess.run(
            [sys.executable, "-B", "-c", code, *arguments],
            capture_output=True, text=True, env={**os.environ, "PYTHONPATH": str(ROOT)}, cwd=folder,
        )  # fmt: skip
        assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
        assert "too large" in done.stderr.lower()
        assert contents(folder) == before
