"""Generated C against the 40-digit reading: every quantity and derivative of every model that ships."""

from __future__ import annotations

from typing import Any

import mpmath as mp
import numpy as np
import pytest
from exact import run

import modelgen.models as models
from modelgen.codegen import build
from modelgen.language import Model

FREQUENCIES = np.array([0.7, 3.0, 140.0, 1600.0, 9000.0])
VARIANTS = (
    ("magnetostrictive_transducer", {}),
    ("magnetostrictive_transducer", {"eddy": "series"}),
    ("magnetostrictive_transducer", {"eddy": "none"}),
    ("magnetostrictive_transducer", {"eddy_sign": "printed"}),
    ("contact_damping", {}),
    ("contact_damping", {"surface": "fractal"}),
    ("contact_damping", {"g_form": "homogeneous"}),
    ("complex_stiffness", {}),
    ("electrodynamic_transducer", {}),
    ("modified_dahl", {}),
    ("modified_dahl", {"b": 0.6}),
    ("modified_dahl", {"b": 1.7}),
    ("modified_dahl", {"initial": "steady"}),
)


def recording(model: Model) -> dict[str, Any]:
    """Inputs of a few samples; the displacement swings, with a reversal inside two of the steps."""
    if not model.inputs:
        return {}
    if model.axis == "f":
        return {"f": FREQUENCIES}
    z = np.array([0.1, 0.6, 1.2, 1.0, 0.2, -0.7, -1.1, -0.9, -0.9, 0.3])
    z_prev = np.concatenate([z[:1], z[:-1]])
    z_turn = z_prev.copy()
    z_turn[3], z_turn[7] = 1.3, -1.25
    v = np.gradient(z, 0.01)
    t = np.arange(len(z)) * 0.01
    t_prev = np.concatenate([t[:1], t[:-1]])
    return {"t": t, "z": z, "t_prev": t_prev, "z_prev": z_prev, "z_turn": z_turn, "v": v, "a": 0 * z}


def exact(model: Model, inputs: dict[str, Any], **values: Any) -> dict[str, list[Any]]:
    count = len(next(iter(inputs.values()))) if inputs else 1
    samples = [{k: float(x[n]) for k, x in inputs.items()} for n in range(count)]
    rows = run(model, samples, **values)
    return {s.name: [row[s.name] for row in rows] for s in model.statements}


def relative(found: Any, wanted: list[Any]) -> float:
    """Greatest difference over the greatest value."""
    pairs = list(zip(np.ravel(found).tolist(), wanted, strict=True))
    scale = max(abs(w) for _, w in pairs)
    return float(max(abs(f - w) for f, w in pairs) / scale) if scale else max(abs(f) for f, _ in pairs)


def test_a_contact_without_elastic_asperities_has_no_damping_by_this_model() -> None:
    """No number rather than a wrong one, up to the load F_1c: (A4) divides by the elastic energy."""
    compiled = build(models.contact_damping.variant(surface="fractal"), ())
    values = {"D_1": 2.3, "D_2": 2.3, "G_1": 1e-8, "G_2": 1e-8}
    F_1c = compiled.all(**values)["F_1c"]
    assert np.isnan(compiled(**values, F=0.999 * F_1c)) and compiled(**values, F=1.001 * F_1c) > 0


@pytest.mark.parametrize(("name", "options"), VARIANTS)
def test_every_quantity_and_derivative(name: str, options: dict[str, Any]) -> None:
    values = {k: options[k] for k in options if k == "b"}
    model = getattr(models, name)
    model = model.variant(**{k: v for k, v in options.items() if k != "b"}) if set(options) - {"b"} else model
    start = {"r_0": -0.7} if "r_0" in {p.name for p in model.scalar_parameters} else {}
    values |= start
    inputs = recording(model)
    wrt = tuple(p.name for p in model.scalar_parameters)
    compiled = build(model, wrt)
    wanted = exact(model, inputs, **values)
    found = compiled.all(**inputs, **values)
    for quantity, value in wanted.items():
        assert relative(found[quantity], value) < 1e-11, quantity
    jacobian = compiled.jacobian(**inputs, **values)
    outputs = (
        [model.outputs[0].name]
        if np.iscomplexobj(found[model.outputs[0].name])
        else [o.name for o in model.outputs]
    )
    for k, output in enumerate(outputs):
        columns = jacobian[k] if len(outputs) > 1 else jacobian
        for column, p in enumerate(wrt):
            default = values.get(p, model.parameter(p).default)
            h = mp.mpf("1e-12") * (abs(default) or 1)
            high, low = (
                exact(model, inputs, **values | {p: mp.mpf(repr(default)) + d})[output] for d in (h, -h)
            )
            slope = [(a - b) / (2 * h) for a, b in zip(high, low, strict=True)]
            assert relative(columns[..., column], slope) < 1e-9, (output, p)
