"""A model's clock may run in milliseconds, its frequency in kilohertz or radians per second: the physics that
is found is the same."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen.diagnose import Verdict, diagnose
from modelgen.language import Equation, Input, Model, Output, Parameter, Port, State, j, pi
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
