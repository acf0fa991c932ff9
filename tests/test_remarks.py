"""Tables with remarks beside the numbers, and models in folders with names like a file's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from modelgen.errors import InputError
from modelgen.recordings import Case, Channel, Recording, Signature, load_case, read_case_file

SPRING = Signature("spring", (Channel("z", "mm"),), (Channel("F", "N"),), {}, "z")


def record(folder: Path, table: str) -> Recording:
    (folder / "a.csv").write_text(table)
    (folder / "case.toml").write_text('model = "spring"\n[[recording]]\nfile = "a.csv"\n')
    return load_case(read_case_file(folder / "case.toml"), SPRING).fit[0]


@pytest.mark.parametrize("mark", [".", ","])
@pytest.mark.parametrize("apart", [";", "\t"])
@pytest.mark.parametrize("head", ["remark", "remark [-]"])
def test_a_comma_in_a_remark_is_no_decimal_mark(tmp_path: Path, mark: str, apart: str, head: str) -> None:
    rows = [("0", "1.5", "dry, cold"), ("1", "2.5", "No. 2, wet"), ("2", "4.5", "")]
    cells = [("z [mm]", "F [N]", head), *((z, F.replace(".", mark), says) for z, F, says in rows)]
    found = record(tmp_path, "\n".join(map(apart.join, cells)))
    np.testing.assert_array_equal(found.outputs["F"], [1.5, 2.5, 4.5])
    assert any("commas are read" in w for w in found.warnings) is (mark == ",")


def test_a_point_beside_decimal_commas_is_still_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"line 3, column 'F \[N\]': '2\.500' has a point, others a decimal"):
        record(tmp_path, "z [mm];F [N];remark\n0;1,5;dry, cold\n1;2.500;\n")


@pytest.mark.parametrize(
    ("model", "file"),
    [
        ("my.pylib/model.py:M", "/a/my.pylib/model.py"),
        ("my.pylib/model.py", "/a/my.pylib/model.py"),
        ("model.py:M", "/a/model.py"),
        ("model.py", "/a/model.py"),
        ("kelvin_voigt", None),
        ("my.pylib", None),
    ],
)
def test_the_file_of_a_model_is_what_stands_before_its_name(model: str, file: str | None) -> None:
    path = Path("/a/case.toml")
    assert Case(path, model, ()).files == ((path,) if file is None else (path, Path(file)))
