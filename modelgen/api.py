"""What a script calls first: a case and the model that it names."""

from __future__ import annotations

from pathlib import Path

from modelgen.errors import InputError
from modelgen.fit.series import signature_of
from modelgen.language import Model
from modelgen.models import load
from modelgen.recordings import Case, load_case, read_case_file
from modelgen.units import unit_text


def open_case(path: str | Path) -> tuple[Model, Case]:
    """The model that a case names, with the case's [options], and the case with its recordings.

    A model in a file of the user's, "path/to/file.py:NAME", is looked for relative to the case.
    Raises InputError, one line, for anything that is wrong in the case, its tables or the model's file.
    """
    case_file = read_case_file(path)
    model = load(case_file.model, case_file.path.parent)
    if case_file.options:
        model = model.variant(**case_file.options)
    case = load_case(case_file, signature_of(model))
    _check_signs(model, case)
    _check_bounds(model, case)
    return model, case


def _check_signs(model: Model, case: Case) -> None:
    """No constant and no search range is below zero where the model has no meaning there, as of a mass."""
    known = [("[constants]", n, v) for n, v in case.constants.items()]
    known += [(f"recording '{r.name}'", n, v) for r in case.recordings for n, v in r.constants.items()]
    known += [("[bounds]", n, end) for n, pair in case.bounds.items() for end in reversed(pair)]
    for place, name, value in known:
        low = model.parameter(name).bounds[0]
        if value < 0 <= low:
            raise InputError(f"{case.path}, {place} {name}: {value:g} is below {low:g}, its least value")


def _check_bounds(model: Model, case: Case) -> None:
    """Bounds of a case and of its model have values in common; else they were meant in another unit."""
    for name, (low, high) in case.bounds.items():
        p = model.parameter(name)
        least, most = p.bounds
        if high <= least or low >= most:
            unit = unit_text(p.unit) or "1, a pure number"
            raise InputError(
                f"{case.path}, [bounds] {name} = [{low:g}, {high:g}]: apart from {model.id}'s own bounds "
                f"[{least:g}, {most:g}]; numbers of a case are in the model's units, here {unit}"
            )


def read_case(path: str | Path) -> Case:
    """The case of a `case.toml`; see `open_case`."""
    return open_case(path)[1]
