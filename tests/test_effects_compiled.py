"""Models with an effect that remembers, compiled: values as read plainly, derivatives as differences tell."""

from __future__ import annotations

import numpy as np
import pytest
from test_effects import CASES, base, extended, inputs, outputs, shape_value

from modelgen.codegen.build import build_many
from modelgen.models import load

TIME = [(e, port) for m, e, port in CASES if m == "modified_dahl"]


@pytest.fixture(scope="module")
def compiled() -> list:  # type: ignore[type-arg]
    """Value and Jacobian of every extended model, by the kernels that a diagnosis has."""
    made = []
    for e, port in TIME:
        p = e.parameters(load("modified_dahl"), port)
        wrt = ("rho", "k_D", *(p[q.name].name for q in e.strengths), *(p[q.name].name for q in e.shapes))
        made.append((extended("modified_dahl", e, port).model, wrt))
    return build_many(made, ("jacobian",), ("real",))


def test_compiled_values_are_those_of_a_plain_reading_and_derivatives_those_of_differences(
    compiled: list,  # type: ignore[type-arg]
) -> None:
    plain, rows = base("modified_dahl")[0], inputs("modified_dahl")
    start = {q.name: q.default for q in plain.model.scalar_parameters}
    for (e, port), f in zip(TIME, compiled, strict=True):
        p = e.parameters(load("modified_dahl"), port)
        values = {p[q.name].name: 0.3 + q.null for q in e.strengths}
        values |= {p[q.name].name: shape_value(q, "modified_dahl") for q in e.shapes}
        wanted = outputs(f.model, extended("modified_dahl", e, port)(rows, **values))[0]
        names = {i.name for i in f.model.inputs}
        prepared = f.prepare(**{k: v for k, v in rows.items() if k in names}, **values)
        theta = np.array([values.get(n, start.get(n)) for n in f.wrt])
        got, J = prepared.jacobian(theta, "real")
        assert np.allclose(got, wanted, rtol=1e-9, atol=1e-11 * np.abs(wanted).max()), (e.id, values)
        for k, x in enumerate(theta[:2]):
            h = np.zeros(len(theta))
            h[k] = 1e-5 * x
            up, down = (prepared.jacobian(theta + s * h, "real")[0] for s in (1, -1))
            slope = (up - down) / (2e-5 * x)
            assert np.allclose(J[:, k], slope, atol=2e-4 * np.abs(slope).max()), (e.id, f.wrt[k])
