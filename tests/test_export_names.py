"""Names of a model that mean something else in the C: the step between samples, macros of the headers."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest
from test_export import WARNINGS, needs_gcc

import modelgen.models as models
from modelgen.export.fmu import stand_alone
from modelgen.export.host import Compiled
from modelgen.export.inverse import inverse
from modelgen.export.routines import make_unit
from modelgen.export.text import render_c
from modelgen.export.vectors import make_vectors
from modelgen.language import Equation, Implicit, Input, Model, Parameter, State, Symbol, previous, rate_of

H, LAG = 0.25, 5.0


def lag(name: str, output: str = "y") -> Model:
    """dx/dt = (z − x)/lag by Euler's rule, where the lag is called `name`."""
    t, z, p = Input("t", "s"), Input("z", "mm"), Parameter(name, "s", LAG, (1e-3, 1e3))
    before, x = previous(t), Symbol("x", real=True)
    update = x + (t - before) / p * (z - x)
    y = Equation(output, State("x", 0, update=update, unit="mm").symbol, "mm")
    return Model("lag", (t, z, before), (p,), (State("x", 0, update=update, unit="mm"), y), (output,))


def stepped(model: Model, rows: Sequence[Sequence[float]]) -> tuple[list[float], Compiled]:
    """The first output at each sample, at default parameters."""
    unit = make_unit(model)
    c = Compiled(unit, "double", render_c(unit, "double"))
    p = [float(model.parameter(s.name).default or 0.0) for s in unit.parameters]
    return [float(c.call("step" if k else "start", p, row)[1][0]) for k, row in enumerate(rows)], c


def test_a_parameter_called_as_the_step_is_still_one() -> None:
    wanted = [0.0]
    for _ in range(9):
        wanted.append(wanted[-1] + H / LAG * (1 - wanted[-1]))
    for name, step in (("tau", "dt"), ("dt", "dt_")):
        found, c = stepped(lag(name), [(H, 1.0)] * 10)
        assert found == pytest.approx(wanted, rel=1e-14)
        assert [s.member for s in c.unit.parameters] == [name]
        assert [s.member for s in c.unit.inputs] == [step, "z"]
        _, vectors = make_vectors(c.unit, "double", {})
        assert vectors[1].inputs[0] == 2.0**-6


def test_the_step_keeps_its_name_where_a_statement_is_it_and_gives_way_where_one_is_not() -> None:
    assert make_unit(lag("tau", output="dt")).step == "dt_"
    backward = make_unit(inverse(models.modified_dahl))
    assert backward.step == "dt" and [s.name for s in backward.inputs] == ["dt", "F_wanted"]


def test_models_made_of_one_with_such_a_parameter_do_not_take_it_over() -> None:
    t, q, p = Input("t", "s"), Input("q", "m", range=(-9.0, 9.0)), Parameter("dt", "s", LAG)
    w = rate_of(q, "w", "m/s")
    model = Model("speed", (t, q, w), (p,), (Equation("y", q + p * w, "m"),), ("y",))
    found, _ = stepped(stand_alone(model), [(H, 0.0), (H, 1.0)])
    assert found[1] == pytest.approx(1 + LAG / H)
    found, _ = stepped(inverse(model), [(0.0, 0.0), (H, 1 + LAG / H)])
    assert found[1] == pytest.approx(1.0)


HEADERS = ("float", "limits", "math", "stdbool", "stddef", "stdint", "stdio", "stdlib", "string")


@needs_gcc
def test_names_that_are_macros_of_the_headers_compile(tmp_path: Path) -> None:
    """In structs, as constants of a function, in an implicit equation; where the caller had the headers."""
    x, names = Input("INT32_MAX", range=(1.0, 2.0)), ("DBL_MAX", "M_PI", "SIZE_MAX", "EXPORT", "stdout")
    parameters = tuple(Parameter(n, "1", 0.5, (0.0, 1.0)) for n in names)
    half = Equation("DBL_EPSILON", sum((p * x for p in parameters), 0 * x.symbol))
    root = Symbol("FLT_MAX", real=True)
    found = Implicit("FLT_MAX", root**3 + root - half.symbol * parameters[0], (-9.0, 9.0))
    y = Equation("DECIMAL_DIG", half.symbol**2 + root / half.symbol)
    unit = make_unit(Model("names", (x,), parameters, (half, found, y), ("DECIMAL_DIG", "DBL_EPSILON")))
    includes = "".join(f"#include <{h}.h>\n" for h in HEADERS)
    for real in ("double", "float"):
        for name, text in render_c(unit, real).items():
            (tmp_path / name).write_text(includes + text if name.endswith(".h") else text)
        for std in ("-std=c99", "-std=gnu99"):
            command = ["gcc", *WARNINGS, std, "-c", "names.c"]
            done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
            assert done.returncode == 0, done.stderr
