"""Steps of integration that are too long for a state: told in a fit, shortened in a diagnosis."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import modelgen as mg
from modelgen.diagnose import diagnose
from modelgen.errors import InputError
from modelgen.language import Equation, Input, Model, Parameter, Port, State, Symbol
from modelgen.models import load
from modelgen.recordings import Case, Noise, Recording
from modelgen.report.plots import stroke_of

TAU, GAIN, SIGMA = 0.12, 70.0, 0.3


def vessel() -> Model:
    """A pressure that follows a valve's voltage."""
    t, u = Input("t", "s"), Input("u", "V", "valve")
    tau = Parameter("tau", "s", 0.08, (1e-3, 2.0), "filling time")
    g = Parameter("g", "kPa/V", 60.0, (1.0, 500.0), "valve gain")
    p_0 = Parameter("p_0", "kPa", 100.0, (0.0, 1000.0), "pressure at first")
    x = Symbol("x", real=True)
    state = State("x", p_0, rate=(g * u - x) / tau, unit="kPa")
    out = Equation("p", x, "kPa")
    return Model("vessel", (t, u), (tau, g, p_0), (state, out), ("p",), (Port("gas", "channel", "p"),))


def recorded(dt: float, n: int = 300) -> Recording:
    """Exactly, of a voltage that runs straight between the samples."""
    t = np.arange(n) * dt
    u = 3 + 1.5 * np.sin(2.1 * t) + np.sin(0.7 * t + 1)
    p, e = np.full(n, 150.0), np.exp(-dt / TAU)
    for i in range(1, n):
        slope = (u[i] - u[i - 1]) / dt
        at = GAIN * (u[i - 1] + slope * (np.array([0.0, dt]) - TAU))
        p[i] = at[1] + (p[i - 1] - at[0]) * e
    noise = SIGMA * np.random.default_rng(1).standard_normal(n)
    return Recording("step", None, "fit", {"t": t, "u": u}, {"p": p + noise})


@pytest.mark.parametrize(("dt", "coarse"), [(0.02, False), (0.25, True)])
def test_long_steps_are_told_and_are_no_physics(dt: float, coarse: bool) -> None:
    model = vessel()
    case = Case(None, model.id, (recorded(dt),), noise=Noise(sigma={"p": SIGMA}))
    fit = mg.fit(model, case)
    assert any("substeps" in note for note in fit.notes) == coarse
    tau = next(e for e in fit.parameters if e.name == "tau")
    assert (abs(tau.value - TAU) > 3 * tau.std) == coarse  # silently wrong, were it not said
    verdict = diagnose(case, model)
    assert verdict.adequate
    assert any("as many steps" in note for note in verdict.notes) == coarse
    found = next(e for e in verdict.parameters if e.name == "tau")
    assert found.value == pytest.approx(TAU, abs=3 * found.std)


def test_what_runs_away_says_where_and_why() -> None:
    """Milliseconds that are called seconds."""
    slow = recorded(0.02)
    record = replace(slow, inputs={**slow.inputs, "t": 1e3 * slow.inputs["t"]})
    case = Case(None, "vessel", (record,), noise=Noise(sigma={"p": SIGMA}))
    with pytest.raises(InputError, match=r"in 'step' from t = \d+ s on: steps of 20 s are too long"):
        mg.fit(vessel(), case)


def test_a_force_is_drawn_over_the_displacement_at_its_port() -> None:
    """Not over the voltage that comes first."""
    t, u, x = Input("t", "s"), Input("u", "V"), Input("x", "mm")
    k, a = Parameter("k", "N/mm", 2.0, (0.0, 9.0)), Parameter("a", "N/V", 1.0, (0.0, 9.0))
    R = Equation("R", k * x, "N")
    F = Equation("F", a * u - R, "N")
    port = Port("rubber", "force", "R", (("z", x),))
    model = Model("muscle", (t, u, x), (k, a), (R, F), ("F",), (port,))
    time = np.linspace(0, 5, 200)
    inputs = {"t": time, "u": np.sin(time), "x": np.cos(3 * time)}
    force = np.sin(time) - 2 * inputs["x"] + 0.01 * np.random.default_rng(0).standard_normal(200)
    case = Case(None, "muscle", (Recording("a", None, "fit", inputs, {"F": force}),))
    (trace,) = mg.fit(model, case).traces
    assert stroke_of(trace) == "x"


def test_one_record_tells_how_the_extended_model_begins(tmp_path: Path) -> None:
    """Its C begins where the record did."""
    model, record = vessel(), recorded(0.02)
    lagged = record.outputs["p"].copy()
    lagged[3:] = record.outputs["p"][:-3]
    late = Recording("late", None, "fit", record.inputs, {"p": lagged})
    case = Case(None, model.id, (late,), noise=Noise(sigma={"p": SIGMA}))
    verdict = diagnose(case, model, out=tmp_path)
    assert not verdict.adequate and verdict.extended_model
    begins = next(e.value for e in verdict.parameters if e.name == "p_0")
    extended = load(f"{verdict.extended_model}:model")
    assert extended.parameter("p_0").default == pytest.approx(begins, rel=1e-6)
