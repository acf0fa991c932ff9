"""Tanks that run out through valves: what is missing acts on a level that is known by the model alone."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from sympy import Symbol

from modelgen.diagnose import diagnose
from modelgen.diagnose.hypotheses.addition import Addition
from modelgen.effects import CATALOGUE
from modelgen.language import Abs, Equation, Input, Model, Parameter, Port, State, sqrt
from modelgen.recordings import Case, Recording

t, q = Input("t", "s"), Input("q", "m**3/s")
A = Parameter("A", "m**2", 0.5, (0.01, 10.0), "surface of the tank")
g = Parameter("g", "m**2/s", 1e-3, (1e-6, 0.1), "what the valve lets through")
h_0 = Parameter("h_0", "m", 0.5, (0.0, 10.0), "level at the start")
h = Symbol("h", real=True)
q_out = Equation("q_out", g * h, "m**3/s")
level = State("h", h_0, rate=(q - q_out.symbol) / A, unit="m", substeps=2)
tank = Model(
    "tank", (t, q), (A, g, h_0), (q_out, level), ("h",), (Port("valve", "force", "q_out", (("z", h),)),)
)


@pytest.mark.slow
def test_a_valve_that_is_laminar_first_and_turbulent_later() -> None:
    rng, time = np.random.default_rng(6), np.arange(1500) * 2.0
    flow = np.interp(time, np.arange(0, 3200, 250.0), rng.uniform(0.2, 2.2, 13))

    def rate(at: float, x: np.ndarray) -> list[float]:
        head = max(x[0], 0.0)  # = 0.1 q + 0.5 q²
        return [1e-3 * (np.interp(at, time, flow) - (np.sqrt(0.01 + 2 * head) - 0.1)) / 0.4]

    x = solve_ivp(rate, (0, time[-1]), [0.5], t_eval=time, max_step=2.0, rtol=1e-8).y[0]
    x = x + rng.normal(0, 2e-3, time.size)
    found = diagnose(
        Case(None, "tank", (Recording("r", None, "fit", {"t": time, "q": 1e-3 * flow}, {"h": x}),)), tank
    )
    assert [e.id for e in found.effects] == ["power_law_stiffness"]
    assert found.after.fit_over_noise < 1.1


def cascaded() -> Model:
    """A pump fills the upper tank, which runs out into the lower one, whose level is recorded."""
    u = Input("u", "V")
    k_1, k_2 = (Parameter(n, "cm**0.5/s", 0.05, (0.005, 0.5), "outlet") for n in ("k_1", "k_2"))
    k_p = Parameter("k_p", "cm/(s*V)", 0.05, (0.005, 0.5), "pump")
    starts = [Parameter(n, "cm", 4.0, (0.0, 15.0), "level at the start") for n in ("h_10", "h_20")]
    levels = [Symbol(n, real=True) for n in ("h1", "h2")]
    Q = [
        Equation(n, k * sqrt(Abs(x)), "cm/s")
        for n, k, x in zip(("Q_1", "Q_2"), (k_1, k_2), levels, strict=True)
    ]
    lost = Equation("L", 0, "cm/s", text="what else leaves the upper tank")
    flows = (k_p * u - Q[0] - lost, Q[0] - Q[1])
    states = [
        State(x.name, x_0, rate=flow, unit="cm", substeps=2)
        for x, x_0, flow in zip(levels, starts, flows, strict=True)
    ]
    rim = Port("rim", "force", "L", (("z", levels[0]), ("t", t)))
    return Model("cascaded", (t, u), (k_1, k_2, k_p, *starts), (*Q, lost, *states), ("h2",), (rim,))


@pytest.mark.slow
def test_an_upper_tank_that_runs_over() -> None:
    """Its level is not recorded."""
    rng, time = np.random.default_rng(8), np.arange(1000) * 4.0
    volts = np.interp(time, np.arange(0, 4300, 120.0), rng.uniform(1.2, 5.0, 36))

    def rate(at: float, x: np.ndarray) -> list[float]:
        over = 0.06 * max(x[0] - 9.2, 0.0)
        run = [k * np.sqrt(max(y, 0.0)) for k, y in zip((0.052, 0.058), x, strict=True)]
        return [0.048 * np.interp(at, time, volts) - run[0] - over, run[0] - run[1]]

    x = solve_ivp(rate, (0, time[-1]), [5.0, 6.0], t_eval=time, max_step=4.0, rtol=1e-7).y
    assert x[0].max() > 9.5
    h2 = x[1] + rng.normal(0, 0.03, time.size)
    found = diagnose(
        Case(None, "cascaded", (Recording("r", None, "fit", {"t": time, "u": volts}, {"h2": h2}),)),
        cascaded(),
    )
    assert found.effects[0].id == "end_stop"
    rim = next(p for p in found.effects[0].parameters if p.name.startswith(("z_", "c_")))
    assert abs(rim.value - 9.2) < 0.5
    assert found.after.fit_over_noise < 1.1


def siphoned(seed: int) -> Recording:
    """A siphon that starts above a level of 10.5 and breaks off below 6.5."""
    rng, time = np.random.default_rng(seed), np.arange(1500) * 3.0
    volts = np.interp(time, np.arange(0, 4800, 200.0), rng.uniform(1.5, 4.5, 24))
    x, on, levels = 6.0, False, []
    for u in volts:
        levels.append(x)
        for _ in range(10):
            on = x > 10.5 or (on and x > 6.5)
            away = 0.05 * np.sqrt(x) + on * 0.02 * np.sqrt(max(x - 2, 0.0))
            x = max(x + 0.3 * (0.045 * u - away), 0.1)
    shown = np.array(levels) + rng.normal(0, 0.05, time.size)
    return Recording(f"r{seed}", None, "fit", {"t": time, "u": volts}, {"h": shown})


@pytest.mark.slow
def test_a_siphon_is_named_with_reserve() -> None:
    u = Input("u", "V")
    k, k_p = Parameter("k", "cm**0.5/s", 0.05, (0.005, 0.5)), Parameter("k_p", "cm/(s*V)", 0.05, (0.005, 0.5))
    h_0 = Parameter("h_0", "cm", 6.0, (0.0, 20.0), "level at the start")
    h = Symbol("h", real=True)
    out = Equation("out", k * sqrt(Abs(h)), "cm/s")
    level = State("h", h_0, rate=k_p * u - out, unit="cm", substeps=2)
    outlet = Port("outlet", "force", "out", (("z", h), ("t", t)))
    model = Model("siphon", (t, u), (k, k_p, h_0), (out, level), ("h",), (outlet,))
    found = diagnose(Case(None, "siphon", (siphoned(1), siphoned(2)), per_recording=("h_0",)), model)
    assert found.effects[0].probability < 0.3
    assert any("still left is" in n for n in found.notes)


def test_a_motion_that_is_not_recorded_may_go_much_farther_than_the_base_says() -> None:
    """The best base may be so wrong that its upper tank is never filled to where the rim is."""
    model = cascaded()
    law = next(e for e in CATALOGUE if e.id == "end_stop" and e.strengths[0].name == "k_upper")
    (port,) = law.fits(model)
    tops = [
        Addition(law, port, {"z_upper": (0.0, 2.5)}, unseen=unseen)
        .extend(model)
        .parameter("end_stop_z_upper")
        .bounds[1]
        for unseen in (False, True)
    ]
    assert tops[0] == 2.5 and tops[1] > 10.0
