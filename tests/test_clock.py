"""A model's clock may run in milliseconds, its frequency in kilohertz or radians per second: the physics that
is found is the same."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen.codegen import build
from modelgen.codegen.inputs import complete_inputs
from modelgen.diagnose import Verdict, diagnose
from modelgen.diagnose.clock import in_seconds
from modelgen.diagnose.whole_ports import whole
from modelgen.effects import CATALOGUE
from modelgen.language import (
    Equation,
    Input,
    Model,
    Output,
    Parameter,
    Port,
    State,
    acceleration_of,
    j,
    pi,
    rate_of,
)
from modelgen.recordings import Case, Noise, Recording

SIGMA = 0.01


def filtered(unit: str) -> Verdict:
    """A spring and a Maxwell arm over a clock in `unit`, recorded through a filter of 30 ms."""
    per = {"s": 1.0, "ms": 1e3}[unit]
    t, z = Input("t", unit, "time"), Input("z", "mm", "displacement")
    k, k_1 = Parameter("k", "N/mm", 2.0, (0.0, 100.0)), Parameter("k_1", "N/mm", 1.0, (0.0, 100.0))
    tau = Parameter("tau_1", unit, 0.4 * per, (0.01 * per, 10 * per))
    x = State("x", 0, rate=(z - State("x", 0, update=0, unit="mm")) / tau, unit="mm")
    F = Equation("F", k * z + k_1 * (z - x), "N")
    port = Port("force", "force", "F", (("z", z.symbol),))
    model = Model(
        "arm",
        inputs=(t, z),
        parameters=(k, k_1, tau),
        statements=(x, F),
        outputs=(Output("F"),),
        ports=(port,),
    )
    ts, rng = np.arange(1200) * 0.01, np.random.default_rng(4)
    zs = np.sin(2 * np.pi * 0.7 * ts) + 0.4 * np.sin(2 * np.pi * 1.9 * ts)
    foot, shown, records = 0.0, 2.0 * zs[0] + zs[0], []
    for a, b in zip(zs, np.append(zs[1:], zs[-1]), strict=True):
        records.append(shown)
        for z_i in a + (b - a) * (np.arange(20) + 0.5) / 20:
            foot += 5e-4 * (z_i - foot) / 0.4
            shown += 5e-4 * (2.0 * z_i + (z_i - foot) - shown) / 0.03
    force = np.array(records) + SIGMA * rng.standard_normal(ts.size)
    record = Recording("a", None, "fit", {"t": ts * per, "z": zs}, {"F": force})
    return diagnose(Case(None, "arm", (record,), noise=Noise({"F": SIGMA, "z": 0.0})), model)


@pytest.mark.parametrize("unit", ["s", "ms"])
def test_a_filter_is_found_by_any_clock(unit: str) -> None:
    (found,) = filtered(unit).effects
    assert found.id == "force_sensor_lag"
    assert found.parameters[0].unit == "s" and found.parameters[0].value == pytest.approx(0.03, rel=0.03)


def test_the_models_own_numbers_stay_in_their_units() -> None:
    told = {p.name: p.value for p in filtered("ms").parameters}
    assert told["tau_1"] == pytest.approx(400, rel=0.05) and told["k_1"] == pytest.approx(1.0, rel=0.05)


@pytest.mark.parametrize("named", [False, True])
@pytest.mark.parametrize("unit", ["Hz", "kHz", "rad/s"])
def test_a_capacitance_is_found_over_any_frequency(unit: str, named: bool) -> None:
    x = Input("x", unit, "axis")
    R, L = Parameter("R", "ohm", 5.0, (1e-3, 1e3)), Parameter("L", "H", 1.2e-3, (1e-6, 1.0))
    per = Parameter("per", "Hz/kHz", 1000.0, known=True)
    w = Equation("w", {"Hz": 2 * pi * x, "kHz": 2 * pi * per * x, "rad/s": 1 * x}[unit], "rad/s")
    Z = Equation("Z", R + j * w * L, "ohm")
    at = ((("omega", x.symbol if unit == "rad/s" else w.symbol),),) if named else ((),)
    model = Model(
        "coil", inputs=(x,), parameters=(R, L, per) if unit == "kHz" else (R, L), statements=(w, Z),
        outputs=(Output("Z"),), ports=(Port("terminals", "terminals", "Z", *at),),
    )  # fmt: skip
    omega, rng = 2 * np.pi * np.geomspace(20, 20e3, 150), np.random.default_rng(0)
    data = 5 + 1j * omega * 1e-3
    data /= 1 + 1j * omega * 3e-8 * data
    data *= 1 + 2e-4 * (rng.standard_normal(150) + 1j * rng.standard_normal(150))
    axis = omega / {"Hz": 2 * np.pi, "kHz": 2e3 * np.pi, "rad/s": 1.0}[unit]
    record = Recording("a", None, "fit", {"x": axis}, {"Z": data})
    (found,) = diagnose(Case(None, "coil", (record,), noise=Noise(relative={"Z": 2e-4})), model).effects
    assert found.id == "coil_capacitance" and found.parameters[0].value == pytest.approx(3e-8, rel=0.02)


@pytest.mark.parametrize(
    ("clock", "speed", "bend"), [("s", "mm/min", "mm/s**2"), ("ms", "um/ms", "um/ms**2")]
)
def test_a_model_says_the_same_by_another_clock(clock: str, speed: str, bend: str) -> None:
    per = {"s": 1.0, "ms": 1e3}[clock]
    t, z = Input("t", clock), Input("z", "mm")
    v, a = rate_of(z, "v", speed), acceleration_of(z, "a", bend)
    c, M = Parameter("c", f"N/({speed})", 0.3, (0, 10)), Parameter("M", f"N/({bend})", 0.02, (0, 10))
    tau = Parameter("tau_1", clock, 0.4 * per, (1e-3, 1e6))
    x = State("x", 0, rate=(z - State("x", 0, update=0, unit="mm")) / tau, unit="mm")
    k = Parameter("k", "N/mm", 1.0, (0, 10))
    F = Equation("F", c * v + M * a + k * x, "N")
    at = (("z", z.symbol), ("v", v.symbol), ("a", a.symbol))
    ports = (Port("force", "force", "F", at),)
    model = Model("arm", (t, z, v, a), (c, M, k, tau), (x, F), (Output("F"),), ports)
    ts = np.arange(300) * 0.01
    record = Recording("r", None, "fit", {"t": ts * per, "z": np.sin(5 * ts)}, {"F": 0 * ts})
    told = []
    for m, case in ((model, Case(None, "arm", (record,))), in_seconds(model, Case(None, "arm", (record,)))):
        inputs, _ = complete_inputs(m, dict(case.fit[0].inputs), {"t": None, "z": 0.0})
        told.append(np.asarray(build(m)(**inputs, **{p.name: p.default for p in (c, M, k, tau)})))
        units = {i.name: i.unit for i in m.inputs}
    assert np.allclose(*told, rtol=1e-9, atol=1e-12) and np.ptp(told[0]) > 1
    assert units["t"] == "s" and not np.any([u.endswith("min)") for u in units.values()])
    for laws in ("maxwell_branch", "inertia", "power_law_viscoelasticity"):
        whole_model = whole(m)
        fits = [(e, p) for e in CATALOGUE if e.id == laws for p in e.fits(whole_model)]
        assert fits and all(e.extend(whole_model, p) for e, p in fits)
