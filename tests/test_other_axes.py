"""Axes that are no frequency: time in another unit than seconds, a position that passes through zero."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from modelgen.diagnose.ground import prepare
from modelgen.diagnose.noise.smooth_error import smooth_error
from modelgen.fit.trace import Trace
from modelgen.language import Equation, Input, Model, Parameter, Port
from modelgen.recordings import Case, Noise, Recording
from modelgen.report.plots import _axis, stroke_of


def trace(axis: str, unit: str) -> Trace:
    x, e = np.geomspace(1.0, 1e4, 50), np.zeros((1, 50))
    none = np.zeros(50, dtype=bool)
    inputs = {axis: x, "x": np.sin(x)}
    return Trace("a", "fit", axis, unit, "N", "real", x, x, x, x, e, e, none, inputs)


@pytest.mark.parametrize(
    ("axis", "unit", "stroke", "scale"),
    [("t", "s", "x", "linear"), ("t", "ms", "x", "linear"), ("t", "min", "x", "linear"),
     ("f", "kHz", "", "log"), ("z", "", "", "log")],
)  # fmt: skip
def test_time_is_told_by_its_dimension(axis: str, unit: str, stroke: str, scale: str) -> None:
    t = trace(axis, unit)
    assert stroke_of(t) == stroke
    axes = Figure().subplots()
    _axis(axes, t, t.x, [])
    assert axes.get_xscale() == scale


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_an_axis_through_zero_has_no_logarithm() -> None:
    z, k = Input("z", "mm"), Parameter("k", "N/mm", 2.0, (0.0, 100.0))
    port = Port("force", "force", "F", (("z", z.symbol),))
    model = Model("spring", (z,), (k,), (Equation("F", k * z, "N"),), ("F",), (port,))
    at = np.linspace(-1.0, 1.0, 200)
    F = 2 * at + 0.01 * np.random.default_rng(0).standard_normal(200)
    record = Recording("a", None, "fit", {"z": at}, {"F": F})
    ground = prepare(model, Case(None, "spring", (record,), noise=Noise(sigma={"F": 0.01})), 0)
    white, gain, process = smooth_error(ground.judge, ground.base)
    assert np.isfinite(white) and gain == 0.0 and process is None
