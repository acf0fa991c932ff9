"""Models of a user's own whose ports say little: what their recordings tell beside is filled in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

import modelgen as mg
from modelgen.diagnose import diagnose
from modelgen.diagnose.whole_ports import whole
from modelgen.effects import CATALOGUE
from modelgen.language import Equation, Input, Model, Parameter, Port, State, j, pi
from modelgen.models import load
from modelgen.recordings import Case, Recording

t, z = Input("t", "s"), Input("z", "mm")
k_0, k_1 = Parameter("k_0", "N/mm", 5.8, (0.3, 2e2)), Parameter("k_1", "N/mm", 3.9, (0.3, 2e2))
tau, F_0 = Parameter("tau", "s", 0.2, (0.01, 1.0)), Parameter("F_0", "N", 0.0, (-1e2, 1e2))
Q = State("q", z, rate=(z - sp.Symbol("q")) / tau, unit="mm", substeps=2)
F = Equation("F", k_0 * z + k_1 * (z - Q) + F_0, "N")
AT = (("z", z.symbol), ("t", t.symbol))
zener = Model("zener", (t, z), (k_0, k_1, tau, F_0), (Q, F), ("F",), (Port("mechanical", "force", "F", AT),))


def test_a_port_that_says_only_where_it_is_gets_its_motion_and_its_sensor() -> None:
    model = whole(zener)
    force, sensor = model.ports
    assert {"z", "v", "a", "z_prev", "z_turn", "t", "t_prev"} == {n for n, _ in force.variables}
    assert sensor.kind == "sensor" and sensor.equation == "F" != force.equation
    of_dahl = {e.id for e in CATALOGUE if e.kinds[0] == "force" and e.fits(load("modified_dahl"))}
    assert of_dahl <= {e.id for e in CATALOGUE if e.fits(model)}


def test_the_motion_of_a_law_may_come_through_a_linkage_with_play() -> None:
    """Where nothing is integrated along it: there a port for play is filled in. A joint that gives is left to
    who declares it: in series with a spring and a dashpot it is what a material's relaxation is."""
    law = Equation("F", k_0 * z + F_0, "N")
    model = whole(replace(zener, parameters=(k_0, F_0), statements=(law,)))
    there = {e.id for e in CATALOGUE if e.fits(model)}
    assert "backlash" in there and "contact_compliance" not in there
    play = next(e for e in CATALOGUE if e.id == "backlash" and e.kinds == ("displacement",))
    loose = play.extend(model, play.fits(model)[0])
    T = np.linspace(0, 2, 401)
    given = {"t": T, "z": np.sin(2 * np.pi * T), "k_0": 2.0, "F_0": 0.0}
    amount = next(p.name for p in loose.parameters if p.name.endswith("_g"))
    force = mg.build(loose)(**given, **{amount: 0.1, "backlash_away": 0.0})
    late = T > 1  # a lag of the half gap: at the ends of the stroke the spring is at z ∓ g
    assert force[late].max() == pytest.approx(2.0 * 0.9, rel=1e-3)
    assert force[late].min() == pytest.approx(-2.0 * 0.9, rel=1e-3)
    assert not any(p.kind == "displacement" for p in whole(zener).ports)


def test_a_declared_sensor_gets_the_time() -> None:
    """Else delay and lag have no place there, and nothing says so."""
    model = whole(replace(zener, ports=(Port("thermocouple", "sensor", "F"),)))
    assert {"t", "t_prev"} == {n for n, _ in model.ports[0].variables}
    assert {"sensor_delay", "force_sensor_lag"} <= {e.id for e in CATALOGUE if e.fits(model)}


u, T_0, g = (
    Input("u", "W"),
    Parameter("T_0", "K", 293.0, (200.0, 400.0)),
    Parameter("g", "K/W", 2.0, (0.1, 9.0)),
)
tau_h = Parameter("tau_h", "s", 5.0, (0.5, 50.0))
HEAT = sp.Symbol("T", real=True)
warm = State("T", T_0, rate=(g * u - (HEAT - T_0)) / tau_h, unit="K", substeps=2)
shown = Equation("T_m", HEAT, "K")
heater = Model("heater", (t, u), (T_0, g, tau_h), (warm, shown), ("T_m",))


def test_whatever_is_recorded_comes_through_a_sensor() -> None:
    """A thermometer is late, too; but a load cell alone creeps under a load."""
    there = {e.id for e in CATALOGUE if e.fits(whole(heater))}
    assert {"sensor_delay", "force_sensor_lag"} <= there and "sensor_creep" not in there
    power = Equation("P_m", u, "W")
    both = whole(replace(heater, statements=(warm, shown, power), outputs=("T_m", "P_m")))
    assert [(p.name, p.kind) for p in both.ports] == [("sensor_T_m", "sensor"), ("sensor_P_m", "sensor")]
    named = whole(replace(heater, ports=(Port("sensor", "terminals", "T_m"),)))
    assert [(p.name, p.kind) for p in named.ports] == [("sensor", "terminals"), ("sensor_", "sensor")]


def test_a_thermometer_that_is_late() -> None:
    """Heated along a random course of steps, its reading 0.6 s late, exactly as of a line."""
    rng, T = np.random.default_rng(4), np.arange(0.0, 120.0, 0.2)
    records = []
    for role, n in (("fit", 1), ("fit", 2), ("holdout", 3)):
        heat = np.repeat(rng.uniform(0.0, 10.0, 1 + T.size // 25), 25)[: T.size]
        true = np.asarray(mg.build(heater)(t=T, u=heat, T_0=295.0, g=1.7, tau_h=4.0))
        late = np.interp(T - 0.6, T, true) + 0.02 * rng.standard_normal(T.size)
        records.append(Recording(f"run_{n}", None, role, {"t": T, "u": heat}, {"T_m": late}))
    verdict = diagnose(Case(None, "late", tuple(records)), heater)
    assert {"sensor_delay"} <= {verdict.effects[0].id, *verdict.effects[0].equivalents}
    assert verdict.after.fit_over_noise == pytest.approx(1.0, abs=0.1)


def test_what_is_filled_in_changes_no_number() -> None:
    T = np.linspace(0, 3, 301)
    given = {"t": T, "z": np.sin(5 * T)}
    assert np.array_equal(mg.build(zener)(**given), mg.build(whole(zener))(**given))


def test_a_model_that_says_all_stays_as_it_is() -> None:
    for name in ("modified_dahl", "lugre", "electrodynamic_transducer", "complex_stiffness"):
        assert whole(load(name)) == load(name)


@pytest.mark.parametrize("declared", [False, True])
def test_ports_over_frequency_get_the_angular_frequency(declared: bool) -> None:
    f, R, L = Input("f", "Hz"), Parameter("R", "ohm", 5.0, (0.1, 1e2)), Parameter("L", "H", 1e-3, (1e-6, 1.0))
    w = (Equation("w", 2 * pi * f, "rad/s"),) if declared else ()
    Z = Equation("Z", R + j * 2 * pi * f * L, "ohm")
    model = whole(Model("coil", (f,), (R, L), (*w, Z), ("Z",), (Port("coil", "electrical_impedance", "Z"),)))
    assert str(dict(model.ports[0].variables)["omega"]) == ("w" if declared else "omega")
    assert any(e.id == "semi_inductance" and e.fits(model) for e in CATALOGUE)
    assert mg.build(model)(f=100.0) == pytest.approx(5 + 0.2j * np.pi)


def test_what_is_in_series_lies_within_the_terminals() -> None:
    """A capacitance across the terminals shunts what eddy currents add, in whichever order both are added."""
    f, R = Input("f", "Hz"), Parameter("R", "ohm", 5.0, (0.1, 1e2))
    bare = Model("coil", (f,), (R,), (Equation("Z", R, "ohm"),), ("Z",), (Port("coil", "terminals", "Z"),))
    model = whole(bare)
    assert mg.build(model)(f=100.0) == mg.build(bare)(f=100.0)
    turn = next(e for e in CATALOGUE if e.id == "eddy_shunt" and "electrical_impedance" in e.kinds)
    cable = next(e for e in CATALOGUE if e.id == "coil_capacitance" and "terminals" in e.kinds)
    given = {"f": 1e3, "eddy_shunt_L_2": 2e-3, "eddy_shunt_omega_2": 4e3, "coil_capacitance_C": 1e-6}
    s = 2j * np.pi * 1e3
    wanted = 1 / (1e-6 * s + 1 / (5 + 2e-3 * s / (1 + s / 4e3)))
    for effects in ((turn, cable), (cable, turn)):
        made = model
        for e in effects:
            made = e.extend(made, e.fits(made)[0])
        assert mg.build(made)(**given) == pytest.approx(wanted)


def test_a_capacitance_that_is_told_by_its_impedance() -> None:
    """What is known of capacitances acts on it, and not on what is one over it."""
    f, C, R = (
        Input("f", "Hz"),
        Parameter("C", "F", 1e-6, (1e-9, 1e-3)),
        Parameter("R", "ohm", 5.0, (0.1, 1e2)),
    )
    w = Equation("w", 2 * pi * f, "rad/s")
    Z_C, Z = Equation("Z_C", 1 / (j * w * C), "ohm"), Equation("Z", R + sp.Symbol("Z_C"), "ohm")
    port = Port("film", "capacitance", "Z_C", (("omega", w.symbol),))
    model = whole(Model("film", (f,), (R, C), (w, Z_C, Z), ("Z",), (port,)))
    assert model[model.ports[0].equation].unit == "F"
    loss = next(e for e in CATALOGUE if e.id == "dielectric_loss")
    lossy = loss.extend(model, model.ports[0])
    given = {"f": np.array([50.0, 5e3]), "R": 5.0, "C": 1e-6}
    s = 2j * np.pi * given["f"]
    assert mg.build(model)(**given) == pytest.approx(5 + 1 / (s * 1e-6), rel=1e-12)
    assert mg.build(lossy)(**given, dielectric_loss_n=0.1) == pytest.approx(
        5 + 1 / (s**0.9 * 1e-6), rel=1e-12
    )


def test_a_cell_says_itself_what_is_in_series() -> None:
    for name in ("piezoelectric_transducer", "magnetostrictive_transducer"):
        assert whole(load(name)) == load(name)


def test_names_that_are_taken_are_left_alone() -> None:
    taken = Parameter("z_rate", "1", 1.0, (0.0, 2.0))
    model = Model("m", (t, z), (k_0, taken), (Equation("F", k_0 * taken * z, "N"),), ("F",), zener.ports)
    assert "z_rate_" in {i.name for i in whole(model).inputs}


def test_a_speed_that_is_recorded_stays_the_ports_own() -> None:
    v, c = Input("v", "mm/s"), Parameter("c", "N*s/mm", 0.1, (0.0, 1.0))
    at = (*AT, ("v", v.symbol))
    law = Equation("F", k_0 * z + c * v, "N")
    model = whole(Model("m", (t, z, v), (k_0, c), (law,), ("F",), (Port("mount", "force", "F", at),)))
    assert dict(model.ports[0].variables)["v"] == v.symbol
    assert ("rate", "z") in [i.derived for i in model.inputs]


def test_a_port_takes_a_state_or_an_input_for_its_symbol() -> None:
    assert Port("mechanical", "force", "F", (("z", Q), ("t", t))) == Port(
        "mechanical", "force", "F", (("z", Q.symbol), ("t", t.symbol))
    )


def recorded(force: np.ndarray, T: np.ndarray, motion: np.ndarray) -> Case:
    return Case(None, "own", (Recording("r", None, "fit", {"t": T, "z": motion}, {"F": force}),))


@pytest.mark.slow
def test_a_stop_is_found_by_a_model_that_says_only_where_it_is() -> None:
    """A standard linear solid and a bumper of Hertz, Hunt and Crossley."""
    rng = np.random.default_rng(11)
    T = np.arange(0, 20, 0.01)
    x = sum(
        a * np.sin(w * T + p)
        for a, w, p in zip((1.2, 0.8, 0.5), (2.1, 4.7, 9.3), (0.3, 1.0, 2.0), strict=True)
    )
    stretch, kept = np.zeros_like(x), np.exp(-0.01 / 0.15)  # of the arm's spring, exact for straight steps
    for i in range(1, len(x)):
        stretch[i] = stretch[i - 1] * kept + (x[i] - x[i - 1]) * 0.15 / 0.01 * (1 - kept)
    over = np.maximum(x - 1.4, 0.0)
    bump = 9.0 * over**1.5 * (1 + 0.05 * np.gradient(x, T) * (over > 0))
    force = 7.0 * x + 4.0 * stretch + bump - 3.0 + 0.03 * rng.standard_normal(len(T))
    found = diagnose(recorded(force, T, x), zener)
    assert [e.id for e in found.effects] == ["end_stop"]


def test_a_hum_is_no_other_account_of_what_is_named() -> None:
    """A damper with valves, and the mains beside the force at most of the noise."""
    rng = np.random.default_rng(12)
    T = np.arange(0, 8, 0.004)
    x = 3 * np.sin(2 * np.pi * 1.3 * T) + np.sin(2 * np.pi * 4.1 * T)
    v = np.gradient(x, T, edge_order=2)
    force = 4.0 * x + 0.3 * v + 0.05 * np.logaddexp(0, v / 0.5) * 0.5
    noise = 0.25 * rng.standard_normal(len(T)) + 0.3 * np.sin(2 * np.pi * 50.02 * T + 1.0)
    found = diagnose(recorded(force + noise, T, x), load("kelvin_voigt"))
    assert [e.id for e in found.effects] == ["asymmetric_damping"]
    assert any("50.0" in note and "does not follow the motion" in note for note in found.notes)


@pytest.mark.slow
def test_what_a_law_of_another_form_leaves_is_no_second_effect() -> None:
    """An orifice with a laminar core, p = b v √(v² + v_0²): a square law misses it by a few hundredths."""
    rng = np.random.default_rng(13)
    T = np.arange(0, 8, 0.005)
    x = 3 * np.sin(2 * np.pi * 0.7 * T) + 2 * np.sin(2 * np.pi * 2.3 * T + 1)
    v = np.gradient(x, T, edge_order=2)
    force = 2.0 * x + 0.2 * v + 0.02 * v * np.sqrt(v**2 + 4.0**2)
    force += 0.004 * np.std(force) * rng.standard_normal(len(T))
    found = diagnose(recorded(force, T, x), load("kelvin_voigt"))
    assert [e.id for e in found.effects] == ["quadratic_damping"]
