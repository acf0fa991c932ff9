"""What a controller gets of a model: structs of parameters, inputs, states and outputs, and functions on
them."""

from __future__ import annotations

from dataclasses import dataclass

from modelgen.codegen.ctext import MACROS, RESERVED
from modelgen.codegen.program import Program
from modelgen.export.floats import MATH
from modelgen.language import Model

KEYWORDS = frozenset((
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum", "extern",
    "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return", "short",
    "signed", "sizeof", "static", "struct", "switch", "typedef", "union", "unsigned", "void", "volatile",
    "while", "errno", "linux", "unix", "asm", "NULL", "EOF", "NAN", "INFINITY", "HUGE_VAL", "bool", "true",
    "false", "class", "template", "this", "new", "delete", "private", "public", "operator", "namespace",
    "signgam", "isnan", "isinf", "isfinite", "signbit", "fpclassify",
))  # fmt: skip
assert "state" in RESERVED and "tangent" in RESERVED, "pointers of the functions below"


@dataclass(frozen=True)
class Slot:
    """A member of a struct: the model's `name` for it, its `member` in C, and what it is."""

    name: str
    member: str
    unit: str = ""
    text: str = ""


@dataclass(frozen=True)
class Routine:
    """A C function: its name after the prefix, what it does, arguments and body; `operations` a call."""

    name: str
    says: str
    arguments: str
    body: tuple[str, ...]
    operations: int


@dataclass(frozen=True)
class Unit:
    """A model as C for a controller. `rows` × `columns` is its Jacobian; no `states`: nothing to remember.
    `step` is the input that is the time since the sample before, if there is one. fitter: with the C that
    fits the columns' parameters to recorded samples."""

    model: Model
    program: Program
    prefix: str
    step: str
    fixed: tuple[tuple[str, float], ...]
    parameters: tuple[Slot, ...]
    inputs: tuple[Slot, ...]
    states: tuple[Slot, ...]
    tangents: tuple[Slot, ...]
    outputs: tuple[Slot, ...]
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    routines: tuple[Routine, ...]
    fitter: bool = False

    @property
    def steps(self) -> bool:
        """Whether samples must be given in order."""
        return bool(self.states)


def member(name: str) -> str:
    """A name of the model as a struct's member; only C's own words and macros are avoided."""
    base = name.rstrip("_")
    return f"{name}_" if base in KEYWORDS or base in MATH or MACROS.fullmatch(base) else name
