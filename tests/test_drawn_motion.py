"""What is missing is drawn over how a thing moves, where it moves: in the clock's units, by the model's own
speed, and not over what drives it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import verdicts

from modelgen.cli import main
from modelgen.fit.trace import Trace
from modelgen.language import Equation, Input, Model, Parameter, Port, acceleration_of, rate_of
from modelgen.report.html import page
from modelgen.report.lack import _motion

OSCILLATOR = """
from sympy import Symbol
from modelgen.language import Equation, Input, Model, Parameter, Port, State
t, u = Input("t", "s"), Input("u", "V")
m, k, T = Parameter("m", "kg", 1.0), Parameter("k", "N/m", 1e3), Parameter("T", "N/V", 1.0, known=True)
y, w = Symbol("y", real=True), Symbol("w", real=True)
F = Equation("F", k * y, "N")
states = (State("y", 0, rate=w, unit="m"), State("w", 0, rate=(T * u - F.symbol) / m, unit="m/s"))
osc = Model("osc", (t, u), (m, k, T), (F, *states), ("y",), (Port("force", "force", "F", (("z", y),)),))
"""


def record(unit: str = "mm", clock: str = "s", **more: np.ndarray) -> Trace:
    """A sine of 1 Hz and amplitude 1 over four periods."""
    t = np.linspace(0.0, 4.0, 2001)
    x = np.sin(2 * np.pi * t)
    t = t * {"s": 1.0, "ms": 1e3}[clock]
    e, none = np.ones((1, t.size)), np.zeros(t.size, dtype=bool)
    inputs = {"t": t, "x": x, **more}
    return Trace("a", "fit", "t", clock, "N", "real", t, x, x, x, e, e, none, inputs, {"t": clock, "x": unit})


def spring(*more: Input, unit: str = "mm") -> Model:
    """A force over x; the model takes `more`."""
    t, x, k = Input("t", "s"), Input("x", unit), Parameter("k", f"N/({unit})", 1.0)
    port = Port("force", "force", "F", (("z", x.symbol),))
    return Model("spring", (t, x, *more), (k,), (Equation("F", k * x, "N"),), ("F",), (port,))


def lacking(trace: Trace) -> verdicts.Verdict:
    """A verdict that shows what is missing from `trace` over its motion."""
    return replace(verdicts.missing_backlash(400), curve=None, mismatch=(), traces=(trace,))


def test_speed_is_in_the_units_of_the_clock() -> None:
    trace = record(clock="ms")
    (_, _), (speed, v), (acceleration, a) = _motion(trace, trace.units, None)
    assert (speed, acceleration) == ("speed [mm/ms]", "acceleration [mm/ms²]")
    assert np.max(v) == pytest.approx(2e-3 * np.pi, rel=1e-3)
    assert np.max(a) == pytest.approx((2e-3 * np.pi) ** 2, rel=1e-2)


def test_what_is_called_v_is_a_speed_only_if_it_is_the_stroke_s() -> None:
    mains = np.full(2001, 230.0)
    trace = record(v=mains, a=mains)
    for model in (None, spring(Input("v", "V"), Input("a", "A"))):
        (_, _), (_, v), (_, a) = _motion(trace, trace.units, model)
        assert np.max(v) == pytest.approx(2 * np.pi, rel=1e-3)
        assert np.max(a) == pytest.approx((2 * np.pi) ** 2, rel=1e-2)


def test_the_model_s_own_speed_is_drawn_in_its_own_unit() -> None:
    x = Input("x", "mm")
    model = spring(rate_of(x, "fast", "m/s"), acceleration_of(x, "push", "m/s**2"))
    fast, push = np.full(2001, 0.5), np.full(2001, 7.0)
    trace = record(fast=fast, push=push)
    trace = replace(trace, units={**trace.units, "fast": "m/s", "push": "m/s**2"})
    _, (speed, v), (acceleration, a) = _motion(trace, trace.units, model)
    assert (speed, acceleration) == ("speed [m/s]", "acceleration [m/s²]")
    assert v is fast and a is push
    _, _, (acceleration, _) = _motion(trace, trace.units, spring(rate_of(x, "fast", "m/s")))
    assert acceleration == "acceleration [m/s²]"


def test_a_power_has_no_speed() -> None:
    """Neither by its unit alone, nor beside a port that moves along something else."""
    text = page(lacking(record("W")))
    assert "speed [" not in text and "over t [s] and x [W]" in text
    heated = spring(unit="W")
    assert "speed [" not in page(lacking(record("W")), model=heated)
    mm = lacking(record("mm"))
    assert "speed [mm/s]" in page(mm, model=spring())
    other = replace(
        spring(Input("q", "mm")), ports=(Port("force", "force", "F", (("z", Input("q", "mm")),)),)
    )
    assert "speed [" not in page(mm, model=other)


def test_a_verdict_in_seconds_is_not_labelled_with_the_model_s_clock() -> None:
    t, x, k = Input("t", "ms"), Input("x", "mm"), Parameter("k", "N/mm", 1.0)
    port = Port("force", "force", "F", (("z", x.symbol),))
    model = Model("spring", (t, x), (k,), (Equation("F", k * x, "N"),), ("F",), (port,))
    assert "speed [mm/s]" in page(lacking(record()), model=model)


def test_the_command_tells_the_page_what_moves(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "osc.py").write_text(OSCILLATOR)
    rows = "".join(f"{k},{k % 2},{k % 3}\n" for k in range(20))
    (tmp_path / "osc.csv").write_text("t [s],u [V],y [m]\n" + rows)
    case = tmp_path / "osc.toml"
    case.write_text('model = "osc.py:osc"\n[noise]\ny = 1e-3\n[[recording]]\nfile = "osc.csv"\n')
    trace = record()
    # a motion by its unit: that it drives the mass, the model alone can tell
    trace = replace(trace, inputs={"t": trace.x, "u": trace.inputs["x"]}, units={"t": "s", "u": "mm"})
    monkeypatch.setattr("modelgen.cli.diagnosing.diagnose", lambda *_, **__: lacking(trace))
    to = tmp_path / "osc.html"
    assert main(["diagnose", str(case), "--report", str(to), "--out", str(tmp_path / "out")]) == 0
    text = to.read_text()
    assert "The motion there is not recorded" in text and "speed [" not in text
