"""The catalogue: what effects are at null, what they do beyond it, and whether their laws are those they
are named for."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from interpreter import Reading
from sympy import Abs, symbols

from modelgen.effects import CATALOGUE, FAMILIES, Effect, family, load_effects, search_range
from modelgen.effects.effect import Shape
from modelgen.effects.start import put
from modelgen.errors import InputError
from modelgen.language import Model, Port
from modelgen.models import load

CONTRACT = (
    "contact_damping", "structural_damping", "power_law_viscoelasticity", "maxwell_branch",
    "cubic_stiffness", "asymmetric_stiffness", "payne_softening", "stress_softening", "quadratic_damping",
    "inertia", "second_dahl_element", "stribeck_friction", "dahl_exponent", "backlash", "end_stop",
    "magnetic_pull", "offset_drift", "temperature_drift", "sensor_delay", "force_sensor_lag",
    "semi_inductance", "eddy_shunt", "coil_capacitance", "coil_ac_resistance", "leakage_inductance",
    "permeability_relaxation", "second_mode", "distributed_rod", "radiation_load", "contact_compliance",
)  # fmt: skip
IMPEDANCE = "electrodynamic_transducer"
MODELS = (IMPEDANCE, "magnetostrictive_transducer", "complex_stiffness", "modified_dahl")

t = np.linspace(0, 1, 201)
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
    "A_c": 0.5,
    "z_2": 0.3,
    "n": 0.6,
    "a": 0.6,
    "alpha": 0.4,
    "Q": 5.0,
    "v_0": 0.05,
    "s_c": 30.0,
    "n_R": 50.0,
    "n_K": 50.0,
}
LARGE = {"1": 0.6, "omega": 3e3, "1/max(omega)": 2e-5, "displacement": 0.5, "position": 0.4, "speed": 2.0}


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
    power = 1 if e.secant and rms[1] < 0.5 * rms[0] else 0  # of what begins with the square of its strength
    assert rms[1] == pytest.approx(rms[0] / 3**power, rel=0.1)


@pytest.mark.parametrize(
    ("m", "most"),
    [*((m, 99) for m in MODELS[:-1]), ("modified_dahl", 4)],
)
def test_all_effects_compose(m: str, most: int) -> None:
    """The first laws of all ids, the second ones, …: an account never has two of one id at a port. So many at
    a time: where each step is solved by trials, each effect multiplies what the others cost to write down."""
    laws: dict[tuple[str, str], list[tuple[Effect, Port]]] = {}
    for e in CATALOGUE:
        for port in e.fits(load(m)):
            laws.setdefault((e.id, port.name), []).append((e, port))
    old = outputs(load(m), base(m)[1])
    every = [[of[k] for of in laws.values() if k < len(of)] for k in range(max(map(len, laws.values())))]
    for part in (some[n : n + most] for some in every for n in range(0, len(some), most)):
        model, done = replace(load(m), checked=True), {}
        for e, port in part:
            p = e.parameters(model, port)
            model = e.extend(model, port)
            done |= {p[q.name].name: q.null for q in e.strengths}
            done |= {p[q.name].name: shape_value(q, m) for q in e.shapes}
        new = outputs(model, Reading(model)(inputs(m), **done))
        assert np.allclose(new, old, rtol=1e-11, atol=1e-12 * np.abs(old).max()), m


# -- effects of the user's own -------------------------------------------------------------------------------

OWN = """
from modelgen.effects import Effect, Strength
from modelgen.effects.effect import add

half_power = Effect(
    "half_power_damping", ("force",), "drag with the root of speed", "nobody yet",
    (Strength("c", "{port}"),),
    add(lambda at, p: p["c"] * at["z"] / 7),
    needs=("z",),
)
both = (half_power,)
"""


def test_a_users_file_gives_effects(tmp_path: Any) -> None:
    file = tmp_path / "mine.py"
    file.write_text(OWN.replace('"{port}"', '"{port}/{z}"'))
    (mine,) = load_effects(file)
    assert mine.id == "half_power_damping"
    assert [e.id for e in load_effects(f"{file}:both")] == [mine.id]
    model = load("modified_dahl")
    new = mine.extend(replace(model, checked=False), mine.fits(model)[0])
    assert new.parameter("half_power_damping_c").unit == "N/mm"
    assert load_effects("mine.py", tmp_path)[0].id == mine.id


def test_what_is_wrong_with_a_users_file_is_said_in_one_line(tmp_path: Any) -> None:
    (tmp_path / "none.py").write_text("x = 1\n")
    (tmp_path / "broken.py").write_text("x = 1\ny = (\n")
    (tmp_path / "fails.py").write_text("\nx = 1 / 0\n")
    (tmp_path / "mine.py").write_text(OWN)
    (tmp_path / "mixed.py").write_text(OWN + "\nALL = (half_power, 3)\n")
    for spec, says in {
        "mixed.py": "'ALL[1]' in 'mixed.py' is of type int, wanted an Effect",
        "gone.py": "no file 'gone.py'",
        "mine.txt": "'mine.txt' is no file with effects",
        "none.py": "'none.py' has no effect in it",
        "broken.py": "broken.py, line 2",
        "fails.py": "fails.py, line 2: ZeroDivisionError",
        "mine.py:half_pwer": "'mine.py' has no 'half_pwer', did you mean 'half_power'?",
        "mine.py:add": "'add' in 'mine.py' is of type function, wanted an Effect",
    }.items():
        with pytest.raises(InputError) as why:
            load_effects(spec, tmp_path)
        assert str(why.value).startswith(says) and "\n" not in str(why.value)


def test_a_wrong_unit_in_a_users_effect_is_found(tmp_path: Any) -> None:
    (tmp_path / "mine.py").write_text(OWN)
    (mine,) = load_effects("mine.py", tmp_path)
    model = replace(load("modified_dahl"), checked=False)
    with pytest.raises(InputError, match=r"F_r.*can't be added"):
        mine.extend(model, mine.fits(model)[0])


def test_search_ranges_follow_the_recordings() -> None:
    scales = {"omega": [100.0, 1e4], "port": [50.0, 80.0]}
    e = next(e for e in CATALOGUE if e.id == "distributed_rod")
    assert search_range(e.strengths[0], scales) == pytest.approx((0.0025e-8, 160e-8))
    assert search_range(Shape("w", "rad/s", "omega", 0.5, 2.0), scales) == (50.0, 2e4)
    assert search_range(Shape("c", "m/N", "1/(omega*port)", 1.0, 1.0), scales) == pytest.approx(
        (1 / 8e5, 1 / 5e3)
    )
    assert search_range(Shape("n", "1", "1", 0.3, 0.9), {}) == (0.3, 0.9)
    with pytest.raises(KeyError, match="speed"):
        search_range(Shape("v", "mm/s", "speed", 0.1, 1.0), scales)


def test_ports_are_taken_in_order_of_preference_and_by_what_they_offer() -> None:
    model = load(IMPEDANCE)
    damping = next(e for e in CATALOGUE if e.id == "contact_damping" and "stiffness" in e.kinds)
    assert [p.kind for p in damping.fits(model)] == ["mechanical_impedance"]
    rest = replace(model, ports=tuple(p for p in model.ports if p.kind != "mechanical_impedance"))
    assert [p.kind for p in damping.fits(rest)] == ["stiffness"]
    bare = replace(model, ports=tuple(replace(p, variables=()) for p in model.ports))
    assert damping.fits(bare) == ()
    assert not any(e.fits(load("contact_damping")) for e in CATALOGUE if e.needs)


def test_what_fits_a_users_ports_needs_none_of_their_other_variables() -> None:
    """Each port tells its effects no more than they ask for, the others but their equation."""
    model = load("modified_dahl")
    for e in CATALOGUE:
        for port in e.fits(model):
            told = tuple((k, v) for k, v in port.variables if k in e.needs)
            bare = tuple(
                replace(q, variables=told if q.equation == port.equation else ()) for q in model.ports
            )
            less = replace(model, ports=bare)
            here = next(q for q in less.ports if q.equation == port.equation and q.kind == port.kind)
            e.extend(less, here)


def test_what_is_put_in_the_place_of_a_part_is_there_wherever_the_part_is() -> None:
    x, y = symbols("x y", real=True)
    deep = x
    for _ in range(8):  # in 256 places
        deep = deep + Abs(deep, evaluate=False)
    new = put(deep, {x: y})
    assert new.free_symbols == {y}
    assert put(Abs(x) + x * y, {x: -3}).subs(y, 2) == -3
    assert put(x + 1, {}, of=lambda s: 2 * y if s == x else s) == 2 * y + 1
