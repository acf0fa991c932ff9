"""Devices of a user's own whose motion is not recorded as an input but follows from what drives them, and
those whose output answers to a drive: an oscillator, a motor, a piezo stack. Truths by scipy."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from sympy import Symbol

from modelgen.diagnose import diagnose
from modelgen.diagnose.hypotheses.scales import motion_scales
from modelgen.effects import CATALOGUE
from modelgen.language import (
    Equation,
    Input,
    Model,
    Output,
    Parameter,
    Port,
    State,
    previous,
    rate_of,
    turning_point_of,
)
from modelgen.recordings import Case, Recording

t, u = Input("t", "s"), Input("u", "N")
m, c, k = (
    Parameter("m", "kg", 1.0, (1e-2, 1e2)),
    Parameter("c", "N*s/m", 3.0, (0.0, 1e3)),
    Parameter("k", "N/m", 1e3, (1.0, 1e6)),
)
y, w = Symbol("y", real=True), Symbol("w", real=True)
F_r = Equation("F_r", c * w + k * y, "N")
oscillator = Model(
    "oscillator",
    (t, u),
    (m, c, k),
    (
        F_r,
        State("y", 0, rate=w, unit="m", substeps=2),
        State("w", 0, rate=(u - F_r.symbol) / m, unit="m/s", substeps=2),
    ),
    ("y",),
    (Port("mechanical", "force", "F_r", (("z", y), ("v", w), ("t", t.symbol))),),
)


def recorded(what: str, noise: float = 2e-5, n: int = 1500) -> Case:
    """The oscillator's displacement under a multisine, with what it has beside a spring and a dashpot."""
    rng, time = np.random.default_rng(5), np.arange(n) * 0.004
    f = np.arange(1, 60) / time[-1] * 2
    force = 6 * np.sum(np.cos(2 * np.pi * np.outer(time, f) + rng.uniform(0, 6.3, 59)), axis=1) / 5
    drive = CubicSpline(time, force)

    def rate(at: float, x: np.ndarray) -> list[float]:
        z, v, h, late = x
        more = {
            "maxwell": h,
            "hysteresis": h,
            "friction": 1.5 * np.tanh(v / 2e-3),
            "z2v": 1e6 * z**2 * v,
            "absorber": 200 * (z - h) + 0.6 * (v - late),
            "play": -1500 * np.clip(z, -4e-4, 4e-4),
            "weight": 1.5,
        }.get(what, 0.0)
        slow = {"maxwell": 400 * v - h / 0.05, "hysteresis": 900 * v - 600 * abs(v) * h}.get(what, 0.0)
        if what == "absorber":
            slow = late
        return [v, (drive(at) - 4 * v - 1500 * z - more) / 1.2, slow, more / 0.1]

    x = solve_ivp(rate, (0, time[-1]), [0, 0, 0, 0], t_eval=time, rtol=1e-7, atol=1e-9, max_step=0.004).y
    z = x[0] + rng.normal(0, noise, n)
    return Case(None, "oscillator", (Recording("run", None, "fit", {"t": time, "u": force}, {"y": z}),))


@pytest.mark.parametrize(
    ("what", "ids"),
    [
        ("nothing", set()),
        pytest.param("maxwell", {"maxwell_branch"}, marks=pytest.mark.slow),
        pytest.param("friction", {"coulomb_friction"}, marks=pytest.mark.slow),
        pytest.param("absorber", {"second_mode"}, marks=pytest.mark.slow),
        pytest.param("play", {"backlash"}, marks=pytest.mark.slow),
        pytest.param("weight", {"constant_load"}, marks=pytest.mark.slow),
        pytest.param("hysteresis", {"second_dahl_element"}, marks=pytest.mark.slow),
    ],
)
def test_what_a_driven_oscillator_lacks(what: str, ids: set[str]) -> None:
    found = diagnose(recorded(what), oscillator)
    assert {e.id for e in found.effects} == ids and found.adequate == (not ids)


def test_a_port_that_tells_its_speed_alone_moves_as_far_as_that_goes() -> None:
    time = np.linspace(0, 2 * np.pi, 2001)
    port = Port("shaft", "force", "F_r", (("v", w),))
    found = motion_scales(oscillator, port, [{"w": 3 * np.cos(time)}], [time])
    assert found["displacement"][0] == pytest.approx(3.0, rel=1e-5)
    assert found["speed"][0] == pytest.approx(3.0, rel=1e-3)


def stack(unit: str = "um", drive: str = "V") -> Model:
    """A piezo stack's displacement, in proportion to the voltage; or another quantity, to another drive."""
    V, d = Input("V", drive), Parameter("d", f"{unit}/{drive}", 0.1, (1e-3, 10.0))
    before, turn, late = previous(V), turning_point_of(V), previous(t)
    x = Equation("x", d * V, unit)
    at = {
        "z": V,
        "v": rate_of(V, "dV", f"{drive}/s"),
        "z_prev": before,
        "z_turn": turn,
        "t": t,
        "t_prev": late,
    }
    port = Port("piezo", "force", "x", tuple((n, i.symbol) for n, i in at.items()))
    return Model("stack", (t, V, late, before, turn, at["v"]), (d,), (x,), (Output("x"),), (port,))


def test_what_answers_to_a_drive_lags_by_a_strength_below_zero() -> None:
    """A force goes before the displacement; a displacement and a piezo's force lag behind the voltage."""
    for id in ("second_dahl_element", "maxwell_branch"):
        e = next(e for e in CATALOGUE if e.id == id and e.fits(stack()))
        for unit, drive, least in (
            ("um", "V", -np.inf),
            ("N", "V", -np.inf),
            ("N", "um", 0.0),
            ("V", "V", 0.0),
        ):
            there = stack(unit, drive)
            p = e.parameters(there, there.ports[0])
            assert p[e.strengths[0].name].bounds[0] == least, (id, unit, drive)


def test_a_speed_of_rotation_may_be_negative(tmp_path: Path) -> None:
    from modelgen.recordings.columns import read_channels
    from modelgen.recordings.table import read_table

    model = Model("shaft", (t, u), (m,), (Equation("n", u / m, "N/kg"), Equation("r", 1 / t, "1/s")), ("r",))
    (tmp_path / "run.csv").write_text("t [s],u [N],r [1/s]\n1,0,-3\n2,1,4\n")
    from modelgen.fit.series import signature_of

    found = read_channels(read_table(tmp_path / "run.csv"), signature_of(model))
    assert found.outputs["r"].tolist() == [-3.0, 4.0]


@pytest.mark.slow
def test_a_damping_that_depends_on_where_the_mass_is() -> None:
    """1e6 z² v, of a motion that is not recorded: the law and its size."""
    found = diagnose(recorded("z2v"), oscillator)
    assert [e.id for e in found.effects] == ["position_dependent_damping"]
    size = {p.name: p for p in found.effects[0].parameters}["c_z2"]
    assert abs(size.value - 1e6) < 4 * size.std < 1e4 and found.after.fit_over_noise < 1.05


def test_residuals_of_two_units_are_not_added() -> None:
    from modelgen.diagnose.account.holdout import _rms
    from modelgen.fit.series import make_series

    two = Model(
        "two", (t, u), (m, c), (Equation("a", u / m, "N/kg"), Equation("b", u / c, "m/s")), ("a", "b")
    )
    data = {"a": np.sin(np.arange(20.0)), "b": np.zeros(20)}
    record = Recording("run", None, "fit", {"t": np.arange(20.0), "u": np.ones(20)}, data)
    series = make_series(two, Case(None, "two", (record,)), record)
    raw, white = np.stack([np.full(20, 3.0), np.full(20, 400.0)]), np.ones((2, 20))
    raw[:, 7], white[:, 7] = 1e6, 0.0  # an outlier, which weighs nothing
    assert _rms(two, [series], [raw], [white]) == pytest.approx(3.0)


def test_units_of_any_power_are_written_as_people_write_them() -> None:
    from modelgen.units import parse, tidy

    for unit, text in (("(N)/(m)**5", "N/m⁵"), ("1/s**10", "1/s¹⁰"), ("N*s**0.5/m", "N·s^0.5/m")):
        assert tidy(unit) == text and parse(text) == parse(unit)


def test_a_model_over_time_without_a_memory_may_lack_one() -> None:
    """A film that gives way to the square of a voltage, and creeps."""
    V, a = Input("V", "kV"), Parameter("a", "mm/kV**2", 0.1, (1e-4, 10.0))
    Q = Equation("Q", V**2, "kV**2")
    port = Port("film", "force", "x", (("z", Q.symbol), ("t", t.symbol)))
    film = Model("film", (t, V), (a,), (Q, Equation("x", a * Q, "mm")), ("x",), (port,))
    rng, time = np.random.default_rng(3), np.arange(1200) * 0.05
    volts = np.interp(time, np.arange(0, 61, 4.0), rng.uniform(0, 4, 16))
    late = solve_ivp(
        lambda at, x: (np.interp(at, time, volts) ** 2 - x) / 3,
        (0, 60),
        [volts[0] ** 2],
        t_eval=time,
        max_step=0.05,
    ).y[0]
    x = 0.11 * volts**2 + 0.02 * late + rng.normal(0, 4e-3, 1200)
    found = diagnose(
        Case(None, "film", (Recording("r", None, "fit", {"t": time, "V": volts}, {"x": x}),)), film
    )
    assert [e.id for e in found.effects] == ["maxwell_branch"] and found.effects[0].parameters[0].value < 0


@pytest.mark.parametrize("noise", [0.02, pytest.param(0.15, marks=pytest.mark.slow)])
def test_a_rate_may_be_taken_of_a_rate(noise: float) -> None:
    """In the model, and of what a next experiment would record: its noise is that of the displacement."""
    z = Input("z", "rad")
    v = rate_of(z, "v", "rad/s")
    a = rate_of(v, "a", "rad/s**2")
    J, b = Parameter("J", "kg*m**2/rad", 0.02, (0.0, 10.0)), Parameter("b", "N*m*s/rad", 0.2, (0.0, 100.0))
    T = Equation("T", J * a + b * v, "N*m")
    joint = Model("joint", (t, z, v, a), (J, b), (T,), ("T",), (Port("joint", "force", "T", (("z", z),)),))
    rng, time = np.random.default_rng(1), np.arange(600) * 0.01
    x, w = 2 * np.pi * 0.7 * time, 2 * np.pi * 0.7
    true = -0.02 * w**2 * np.sin(x) + 0.2 * w * np.cos(x) + 0.5 * np.tanh(20 * np.cos(x))
    inputs = {"t": time, "z": np.sin(x)}
    shown = {"T": true + noise * rng.normal(size=600)}
    found = diagnose(Case(None, "joint", (Recording("run", None, "fit", inputs, shown),)), joint)
    assert not found.adequate and found.after.fit_over_noise == pytest.approx(1, abs=0.15)
    assert all(e.separating_experiment for e in found.effects if e.equivalents)
    if noise < 0.1:
        assert [e.id for e in found.effects] == ["coulomb_friction"]
    else:
        assert any(e.equivalents for e in found.effects)
