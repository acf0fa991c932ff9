"""What a script calls first: a case and the model that it names."""

from __future__ import annotations

from pathlib import Path

from modelgen.fit.series import signature_of
from modelgen.language import Model
from modelgen.models import load
from modelgen.recordings import Case, load_case, read_case_file


def open_case(path: str | Path) -> tuple[Model, Case]:
    """The model that a case names, with the case's [options], and the case with its recordings.

    A model in a file of the user's, "path/to/file.py:NAME", is looked for relative to the case.
    Raises InputError, one line, for anything that is wrong in the case, its tables or the model's file.
    """
    case_file = read_case_file(path)
    model = load(case_file.model, case_file.path.parent)
    if case_file.options:
        model = model.variant(**case_file.options)
    return model, load_case(case_file, signature_of(model))


def read_case(path: str | Path) -> Case:
    """The case of a `case.toml`; see `open_case`."""
    return open_case(path)[1]
