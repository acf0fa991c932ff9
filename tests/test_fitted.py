"""From a fit to C: its values are the defaults of what is exported."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from modelgen.cli.fitted import fitted
from modelgen.errors import InputError
from modelgen.models import load

FIT = {
    "schema": "modelgen.fit/1",
    "model": "modified_dahl",
    "parameters": {
        "k_D": {"value": 0.37, "std": 0.01},
        "F_0[a]": {"value": 1.0},
        "F_0[b]": {"value": 1.5},
        "F_0[c]": {"value": 9.0},
    },
}


def test_fitted_values_are_defaults(tmp_path: Path) -> None:
    """One of the recordings in the middle stands for what each has its own value of; the rest stays."""
    (tmp_path / "fit.json").write_text(json.dumps(FIT))
    before, other = load("modified_dahl"), load("complex_stiffness")
    after, same = fitted([before, other], tmp_path / "fit.json")
    assert after.parameter("k_D").default == 0.37
    assert after.parameter("F_0").default == 1.5
    assert after.parameter("rho").default == before.parameter("rho").default
    assert same is other


def test_what_the_data_said_nothing_about_keeps_its_default(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    parameters = {
        "k_D": {"value": 0.37},
        "c_D": {"value": 0.11},
        "rho": {"value": 77.0},
        "F_0[a]": {"value": 1.0},
        "F_0[b]": {"value": 55.0},
    }
    said = [
        "the data say nothing about rho and F_0[b]",
        "the data don't determine k_D and c_D apart: only k_D*c_D",
    ]
    found = {**FIT, "parameters": parameters, "undetermined": said}
    (tmp_path / "fit.json").write_text(json.dumps(found))
    before = load("modified_dahl")
    (after,) = fitted([before], tmp_path / "fit.json")
    assert after.parameter("k_D").default == 0.37
    assert after.parameter("c_D").default == 0.11  # their product is as it was found
    assert after.parameter("F_0").default == 1.0
    assert after.parameter("rho").default == before.parameter("rho").default
    assert "nothing about rho: left at the model's own default" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"schema": "modelgen.verdict/1"}, "no result of"),
        ({"model": "mount"}, "a fit of 'mount', wanted one of modified_dahl"),
        ({"parameters": {"k_d": {"value": 1.0}}}, "no parameter 'k_d', did you mean 'k_D'"),
        ({"parameters": {"k_D": {"value": None}}}, "k_D: a finite value wanted, found None"),
        ({"parameters": {"k_D": 3.0}}, "k_D: a finite value wanted"),
        ({"parameters": [1.0]}, "no result of"),
        ({"undetermined": 5}, "no result of"),
    ],
)
def test_what_is_no_fit_of_the_model_is_refused(tmp_path: Path, change: dict[str, object], says: str) -> None:
    (tmp_path / "fit.json").write_text(json.dumps({**FIT, **change}))
    with pytest.raises(InputError, match=says):
        fitted([load("modified_dahl")], tmp_path / "fit.json")
