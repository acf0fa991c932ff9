"""Models by name: those that ship, and those in a file of the user's; what is wrong is said in one line."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import modelgen.models as models
from modelgen.errors import InputError
from modelgen.language import Model

SPRING = """
from modelgen.language import *
z = Input("z", "mm")
k = Parameter("k", "N/mm", 1.0)
F = Equation("F", k * z, "N")
spring = Model("spring", inputs=(z,), parameters=(k,), statements=(F,), outputs=("F",))
"""


def refusal(spec: str, folder: Path) -> str:
    with pytest.raises(InputError) as caught:
        models.load(spec, folder)
    text = str(caught.value)
    assert "\n" not in text and len(text) < 400
    return text


@pytest.mark.parametrize("name", models.SHIPPED)
def test_models_that_ship(name: str) -> None:
    model = models.load(name)
    assert isinstance(model, Model) and model.id == name and model is getattr(models, name)


def test_a_model_hides_the_file_it_stands_in() -> None:
    """However it was imported first: the package's attribute is the model."""
    code = (
        "from modelgen.models.modified_dahl import r; import modelgen.models.complex_stiffness;"
        "import modelgen.models as m;"
        "print(m.modified_dahl.id, m.complex_stiffness.id, m.load('modified_dahl').id)"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert out.split() == ["modified_dahl", "complex_stiffness", "modified_dahl"]


def test_nothing_heavy_is_imported_before_a_model_is_wanted() -> None:
    code = "import sys, modelgen.models; print('sympy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout == "False\n"


def test_a_file_of_the_users(tmp_path: Path) -> None:
    (tmp_path / "my models").mkdir()
    file = tmp_path / "my models" / "mine.py"
    file.write_text(SPRING)
    assert models.load("my models/mine.py:spring", tmp_path).id == "spring"
    assert models.load(f"{file}:spring").id == "spring"
    assert models.load(str(file)).id == "spring"  # the only model in it
    file.write_text(SPRING.replace('"spring"', '"coil"'))
    assert models.load(f"{file}:spring").id == "coil"  # what stands there now, no older compilation
    assert sorted(p.name for p in file.parent.iterdir()) == ["mine.py"]


def test_unknown_models(tmp_path: Path) -> None:
    assert "unknown model 'modified_dal', did you mean 'modified_dahl'?" in refusal("modified_dal", tmp_path)
    assert "complex_stiffness" in refusal("xyzzy", tmp_path)
    for odd in ("", ":", "a:b", "mine.txt:spring"):
        assert refusal(odd, tmp_path).startswith(f"unknown model '{odd}'")
    with pytest.raises(AttributeError, match="did you mean 'modified_dahl'"):
        _ = models.modified_dal


def test_files_that_are_not_there(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(SPRING)
    (tmp_path / "folder.py").mkdir()
    here = tmp_path.resolve()
    assert refusal("mime.py:spring", tmp_path) == f"no file 'mime.py' in {here}, did you mean 'mine.py'?"
    assert refusal("none/here.py:spring", tmp_path).startswith("no file 'none/here.py'")
    assert "is a folder" in refusal("folder.py:spring", tmp_path)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("x = 1\ny = (\n", "bad.py, line 2: '(' was never closed"),
        ("x = 1\ny = 1 / 0\n", "bad.py, line 2: ZeroDivisionError: division by zero"),
        ("def f():\n    return [][0]\n\nf()\n", "bad.py, line 2: IndexError: list index out of range"),
        ("import nothing_of_this_name\n", "bad.py, line 1: ModuleNotFoundError: No module named"),
        ("raise SystemExit(3)\n", "bad.py, line 1: SystemExit: 3"),
        ("\nraise ValueError('two\\nlines')\n", "bad.py, line 2: ValueError: two lines"),
        ("open('no such file')\n", "bad.py, line 1: FileNotFoundError: [Errno 2] No such file or directory"),
        ("x = '\0'", "bad.py"),
        (SPRING.replace('"N/mm"', '"N"'), "bad.py, line 6: model 'spring', equation 'F': the right"),
        (SPRING.replace("k * z", "kk * z"), "bad.py, line 5: NameError: name 'kk' is not defined"),
    ],
)  # fmt: skip
def test_files_that_do_not_run(text: str, says: str, tmp_path: Path) -> None:
    (tmp_path / "bad.py").write_text(text)
    assert refusal("bad.py:spring", tmp_path).startswith(says)


def test_files_that_are_not_text(tmp_path: Path) -> None:
    (tmp_path / "bad.py").write_bytes(b"x = '\xff\xfe'\n")
    assert refusal("bad.py:spring", tmp_path).startswith("bad.py")


def test_names_that_are_not_in_the_file(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(SPRING + "other = spring.with_parameters()\n")
    assert refusal("mine.py:sprung", tmp_path) == (
        "'mine.py' has no 'sprung', did you mean 'spring'? models in it: spring, other"
    )
    assert "is of type Equation, not a Model; models in it: spring, other" in refusal("mine.py:F", tmp_path)
    assert refusal("mine.py", tmp_path) == (
        "'mine.py' does not say which model; write mine.py:NAME, models in it: spring, other"
    )
    (tmp_path / "empty.py").write_text("")
    assert refusal("empty.py:spring", tmp_path) == "'empty.py' has no 'spring'; there is no Model in it"


def test_a_state_that_starts_at_an_equation_is_told_so() -> None:
    from modelgen.errors import InputError
    from modelgen.language import Equation, Input, Model, Parameter, State

    t, k = Input("t", "s"), Parameter("k", "1", 1.0)
    y = Equation("y", 2 * k)
    with pytest.raises(InputError, match="state 'x': its initial value uses 'y'"):
        Model("m", (t,), (k,), (y, State("x", y, 0.5 * k)), ("y",))
