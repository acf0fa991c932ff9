"""Imports go down only: from a room to those below it, in the package and within the diagnosis."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1] / "modelgen"
DIAGNOSIS = ("hypotheses", "noise", "search", "gate", "experiment", "account")


def imported(file: Path) -> set[str]:
    """The modelgen modules that a file imports, wherever in it."""
    nodes = list(ast.walk(ast.parse(file.read_text())))
    froms = {n.module for n in nodes if isinstance(n, ast.ImportFrom) and n.module and n.level == 0}
    plain = {name.name for n in nodes if isinstance(n, ast.Import) for name in n.names}
    return {name for name in froms | plain if name.startswith("modelgen.")}


@pytest.mark.parametrize("room", DIAGNOSIS)
def test_a_room_of_the_diagnosis_imports_none_above_it(room: str) -> None:
    """hypotheses < noise < search < gate < experiment < account, the order of a diagnosis."""
    above = DIAGNOSIS[DIAGNOSIS.index(room) + 1 :]
    files = list((ROOT / "diagnose" / room).glob("*.py"))
    assert files
    for file in files:
        wrong = {
            name for name in imported(file) if any(name.startswith(f"modelgen.diagnose.{r}.") for r in above)
        }
        assert not wrong, f"{file.name} imports {wrong}"
