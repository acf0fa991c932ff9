"""What a caller gives is refused, or understood, before anything long is done with it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modelgen.api import open_case
from modelgen.diagnose import diagnose
from modelgen.errors import InputError
from modelgen.models import load
from modelgen.recordings import Case, Recording

HELD = """
from modelgen.language import Equation, Input, Model, Parameter
x = Input("x", "A")
R, b = Parameter("R", "ohm", 1.0, (0.0, 100.0)), Parameter("b", "V", 0.0)
line = Model("line", (x,), (R, b), (Equation("U", R * x + b, "V"),), ("U",))
"""


def record(name: str, role: str = "fit") -> Recording:
    t = np.linspace(0.0, 1.0, 20)
    return Recording(name, None, role, {"t": t, "z": np.sin(9 * t)}, {"F": np.cos(t)})


@pytest.mark.parametrize("role", ["fit", "holdout"])
def test_two_recordings_of_one_name_are_refused(role: str) -> None:
    with pytest.raises(InputError, match="case, recordings: 2 are called 'a', wanted a name of its own"):
        Case(None, "kelvin_voigt", (record("a"), record("b"), record("a", role)))
    with pytest.raises(InputError, match=r"^some\.toml, recordings: 3 are called 'a'"):
        Case(Path("some.toml"), "kelvin_voigt", (record("a"),) * 3)
    assert len(Case(None, "kelvin_voigt", (record("a"), record("b", role))).recordings) == 2


def opened(folder: Path, bounds: str) -> Case:
    (folder / "line.py").write_text(HELD)
    (folder / "a.csv").write_text("x [A],U [V]\n" + "".join(f"{k},{-3 * k}\n" for k in range(9)))
    case = folder / "case.toml"
    case.write_text(f'model = "line.py:line"\n[bounds]\n{bounds}\n[[recording]]\nfile = "a.csv"\n')
    return open_case(case)[1]


def test_a_range_that_goes_below_what_has_a_meaning_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"case\.toml, \[bounds\] R: -10 is below 0, its least value$"):
        opened(tmp_path, "R = [-10, 10]")
    with pytest.raises(InputError, match=r"\[bounds\] R: -3 is below 0"):
        opened(tmp_path, "R = [-9, -3]")
    assert opened(tmp_path, "R = [0, 10]\nb = [-5, 5]").bounds == {"R": (0.0, 10.0), "b": (-5.0, 5.0)}


@pytest.mark.parametrize("kind", [str, Path])
def test_the_folder_of_a_diagnosis_may_be_text(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: type
) -> None:
    given: list[Any] = []
    monkeypatch.setattr("modelgen.diagnose.diagnosis._diagnosed", lambda *all: given.extend(all))
    diagnose(Case(None, "kelvin_voigt", (record("a"),)), load("kelvin_voigt"), out=kind(tmp_path))
    assert tmp_path in given  # "a folder" as text is not equal to its path
