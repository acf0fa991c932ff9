"""Axes of the figures: each has ticks, and no two of them look alike."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from modelgen.report.axes import linear_ticks, log_ticks


@pytest.mark.parametrize("ends", [(1.1, 1.4), (31.0, 39.0), (16.0, 19.9), (1e3, 1.1e3), (1.0, 2e5)])
def test_a_logarithmic_axis_has_ticks(ends: tuple[float, float]) -> None:
    figure = Figure()
    axes = figure.subplots()
    axes.set_xscale("log")
    axes.plot(ends, ends)
    log_ticks(axes.xaxis, np.array(ends))
    figure.draw_without_rendering()
    inside = [
        t.label1.get_text()
        for t in axes.xaxis.get_major_ticks()
        if ends[0] * 0.98 <= t.get_loc() <= ends[1] * 1.02
    ]
    assert len(set(inside)) == len(inside) >= 2


@pytest.mark.parametrize(
    "ends", [(123450.0, 123480.0), (0.5, 0.50006), (1.00001e6, 1.00003e6), (2e-4, 2.0003e-4), (0.0, 3.0)]
)
def test_no_two_ticks_look_alike(ends: tuple[float, float]) -> None:
    figure = Figure()
    axes = figure.subplots()
    axes.plot(ends, ends)
    linear_ticks(axes.xaxis)
    figure.draw_without_rendering()
    shown = [t.get_text() for t in axes.get_xticklabels()]
    assert len(set(shown)) == len(shown) >= 2
