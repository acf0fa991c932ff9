"""The catalogue: what effects are at null, what they do beyond it, and whether their laws are those they are named for."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from interpreter import Reading

from modelgen.effects import CATALOGUE, FAMILIES, Effect, family
from modelgen.effects.effect import Shape
from modelgen.language import Model, Port
from modelgen.models import load

CONTRACT = """contact_damping structural_damping power_law_viscoelasticity maxwell_branch cubic_stiffness
asymmetric_stiffness payne_softening stress_softening quadratic_damping inertia second_dahl_element stribeck_friction
dahl_exponent backlash end_stop magnetic_pull offset_drift temperature_drift sensor_delay force_sensor_lag
semi_inductance eddy_shunt coil_capacitance coil_ac_resistance leakage_inductance permeability_relaxation second_mode
distributed_rod radiation_load contact_compliance""".split()
IMPEDANCE = "electrodynamic_transducer"
MODELS = (IMPEDANCE, "magnetostrictive_transducer", "complex_stiffness", "modified_dahl")

t = np.linspace(0, 2, 401)
f = np.geomspace(20, 5000, 60)


def motion(z: np.ndarray, v: np.ndarray, a: np.ndarray) -> dict[str, np.ndarray]:
    before = np.concatenate([z[:1], z[:-1]])
    return {
        "t": t,
        "z": z,
        "t_prev": np.concatenate([t[:1], t[:-1]]),
        "z_prev": before,
        "z_turn": before,
        "v": v,
        "a": a,
    }


def sine(A: float = 1.0, hz: float = 1.0, phase: float = 0.3) -> dict[str, np.ndarray]:
    w = 2 * np.pi * hz
    x = w * t + phase
    return motion(A * np.sin(x), A * w * np.cos(x), -A * w**2 * np.sin(x))


def inputs(model: str) -> dict[str, np.ndarray]:
    if model != "modified_dahl":
        return {"f": np.geomspace(0.1, 20, 40) if model == "complex_stiffness" else f}
    one, two = sine(1.0, 1.0, 0.3), sine(0.5, 3.1, 1.0)
    return motion(one["z"] + two["z"], one["v"] + two["v"], one["a"] + two["a"])


CASES = [(m, e, p) for m in MODELS for e in CATALOGUE for p in e.fits(load(m))]
NAMES = [f"{m}-{e.id}-{p.kind}-{e.strengths[0].name}" for m, e, p in CASES]
SHAPES = {
    "n": 0.6,
    "a": 0.6,
    "alpha": 0.4,
    "Q": 5.0,
    "v_s": 2.0,
    "v_0": 0.05,
    "s_c": 30.0,
    "n_R": 50.0,
    "n_K": 50.0,
}
LARGE = {"1": 0.6, "omega": 3e3, "1/max(omega)": 2e-5, "displacement": 0.5, "position": 0.4}


def shape_value(q: Shape, model: str) -> float:
    slow = model in ("modified_dahl", "complex_stiffness")
    if q.name in SHAPES:
        return SHAPES[q.name]
    if q.name.startswith("g_"):
        return 3.0
    if q.scale in ("omega", "time", "duration"):
        return (
            {"omega": 20.0, "time": 0.1, "duration": 3.0}[q.scale]
            if slow
            else {"omega": 3e3, "time": 3e-4}[q.scale]
        )
    return LARGE.get(q.scale, 1e-5)


@cache
def base(model: str) -> tuple[Reading, dict[str, Any]]:
    reading = Reading(load(model))
    return reading, reading(inputs(model))


@cache
def extended(model: str, e: Effect, port: Port) -> Reading:
    return Reading(e.extend(replace(load(model), checked=False), port))


def outputs(model: Model, values: dict[str, Any]) -> np.ndarray:
    return np.array(
        [values[o.name] for o in model.outputs if not np.iscomplexobj(values[o.name])]
        + [
            part(values[o.name])
            for o in model.outputs
            if np.iscomplexobj(values[o.name])
            for part in (np.real, np.imag)
        ]
    )


def run(model: str, e: Effect, port: Port, strength: float) -> np.ndarray:
    reading = extended(model, e, port)
    p = e.parameters(load(model), port)
    shapes = {p[q.name].name: shape_value(q, model) for q in e.shapes}
    values = reading(inputs(model), **{p[e.strengths[0].name].name: strength}, **shapes)
    return outputs(reading.model, values)


def test_every_effect_of_the_contract_is_there() -> None:
    ids = {e.id for e in CATALOGUE}
    assert set(CONTRACT) <= ids
    assert all(set(members) <= set(CONTRACT) for members in FAMILIES.values())
    assert family("eddy_shunt") == "eddy" and family("inertia") == "inertia"
    fitted = {e.id for _, e, _ in CASES}
    assert set(CONTRACT) <= fitted


def test_laws_of_one_id_have_parameters_of_their_own() -> None:
    for m in MODELS:
        names = [(e.id, q.name) for e in CATALOGUE if e.fits(load(m)) for q in (*e.strengths, *e.shapes)]
        assert len(names) == len(set(names)), m


@pytest.mark.parametrize(("model", "e", "port"), CASES, ids=NAMES)
def test_null_is_the_old_model_and_its_derivative_tells(model: str, e: Effect, port: Port) -> None:
    old = outputs(load(model), base(model)[1])
    null = e.strengths[0].null
    assert np.allclose(run(model, e, port, null), old, rtol=1e-12, atol=1e-13 * np.abs(old).max())
    h = 1e-9
    for _ in range(20):  # strengths are in units of all sizes
        size = np.abs(run(model, e, port, null + h) - old).max() / np.abs(old).max()
        if 1e-7 < size < 1e-5:
            break
        h *= min(max(1e-6 / size, 1e-3), 1e3) if size > 1e-12 else 1e3
    slopes = [(run(model, e, port, null + x) - old) / x for x in (h, h / 3)]
    rms = [np.sqrt(np.mean(s**2)) for s in slopes]
    assert np.isfinite(rms).all() and rms[0] > 0
    assert rms[1] == pytest.approx(rms[0], rel=0.1)


def test_all_effects_compose() -> None:
    for m in MODELS:
        model, done = replace(load(m), checked=True), {}
        for e in CATALOGUE:
            for port in e.fits(load(m)):
                p = e.parameters(model, port)
                model = e.extend(model, port)
                done |= {p[q.name].name: q.null for q in e.strengths}
                done |= {p[q.name].name: shape_value(q, m) for q in e.shapes}
        old = outputs(load(m), base(m)[1])
        new = outputs(model, Reading(model)(inputs(m), **done))
        assert np.allclose(new, old, rtol=1e-11, atol=1e-12 * np.abs(old).max()), m
