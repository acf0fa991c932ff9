"""Figures 7, 8, 10 to 12, 15 and 16 of the MRE paper, from the model, Table 3 and synthetic recordings."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from modelgen.codegen import build
from modelgen.models.complex_stiffness import complex_stiffness
from modelgen.papers.mre.material import loops, table_3_jointly
from modelgen.papers.mre.stages import fitted_to
from modelgen.papers.mre.sweep import SETS, fit_sweep, spring_and_springpot, sweep, swept
from modelgen.papers.mre.tables import A_SWEEP
from modelgen.papers.mre.truth import STAGE_4, moving_average, record, repeats
from modelgen.papers.paper import Figure
from modelgen.report.axes import dots, linear_ticks
from modelgen.report.svg import AFTER, BEFORE, DATA, INK, MARK, MUTED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

COLOUR = {"M0": BEFORE, "M1": AFTER}
EVERY = 400  # samples of 4 kHz from one drawn point to the next
RANGE = np.geomspace(0.1, 10.0, 120)  # [Hz]


def _histories(canvas: Canvas) -> None:
    upper, lower = canvas.subplots(2, 1, sharex=True)
    for case, colour in COLOUR.items():
        t, z, F = (moving_average(x)[::EVERY] for x in record(case))
        upper.plot(t, z, color=colour)
        lower.plot(t, F, color=colour, label=case)
    lower.legend(frameon=False, labelcolor=INK, loc="upper right", ncols=2)
    _finish(upper, "", "z [mm]")
    _finish(lower, "t [s]", "F_m [N]")


def _loops(canvas: Canvas) -> None:
    axes = canvas.subplots()
    for case, colour in COLOUR.items():
        _, z, F = record(case)
        dots(axes, z[::80], F[::80], DATA, 1.6)
        found = loops(case)
        axes.plot(found.z.mean(axis=0), found.F.mean(axis=0), color=colour, label=case)
        h, F_0 = found.mean()["h_s"][0], found.mean()["F_0"][0]
        axes.plot([0, 0], [F_0 - h, F_0 + h], color=MARK, linewidth=1.0, marker="_")
    axes.legend(frameon=False, labelcolor=INK, fontsize=8)
    _finish(axes, "z [mm]", "F_m [N]")


def _stiffness(canvas: Canvas, sample: str) -> None:
    for axes, M in zip(canvas.subplots(1, 2), ("M0", "M1"), strict=True):
        name = f"{sample} {M}"
        f, k_s = sweep(name)
        if sample == "S1":
            F = build(complex_stiffness, wait=True)
            axes.plot(RANGE, F(f=RANGE, A_z=A_SWEEP, **STAGE_4[M])[0], color=MUTED,
                      dashes=(3, 2), label="Dahl, published")  # fmt: skip
        for model, held, colour, label in (
            (complex_stiffness, {"rho": 1.46}, BEFORE, "Dahl, refitted"),
            (spring_and_springpot(), {"k_0": 0.0}, AFTER, "springpot"),
        ):
            found = fit_sweep(model, name, held)
            values = held | {p.name: p.value for p in found.parameters}
            values |= {"A_z": A_SWEEP} if model is complex_stiffness else {}
            axes.plot(RANGE, build(model, wait=True)(f=RANGE, **values)[0], color=colour, label=label)
        if sample == "S1":
            cycles = swept(name).values
            dots(axes, cycles["f"][::4], cycles["k_s"][::4], MARK, 2.4)
            axes.plot([], [], ".", color=MARK, markersize=4, label="synthetic sweep")
        axes.plot(f, k_s, "o", color=INK, markersize=3.5, label="Table 3")
        axes.set_ylim(0, 2 * k_s.max())
        axes.set_title(name)
        _finish(axes, "f [Hz]", "k_s [N/mm]")
    axes.legend(frameon=False, labelcolor=INK, fontsize=8, ncols=2)


def _samples(canvas: Canvas) -> None:
    axes = canvas.subplots()
    value = {p.name: p.value for p in table_3_jointly().parameters}
    for name, colour, line in zip(SETS, (BEFORE, AFTER, BEFORE, AFTER), ("-", "-", "--", "--"), strict=True):
        f, k_s = sweep(name)
        C = value["C"] + value["C_M"] * name.endswith("M1") + value["C_P"] * name.startswith("S2")
        modulus = C * (2 * np.pi * RANGE) ** value["alpha"]
        axes.plot(RANGE, modulus, line, color=colour, label=name)
        axes.plot(f, k_s, "o", color=colour, markersize=3.5)
    axes.set_ylim(0, 2.5)
    axes.legend(frameon=False, labelcolor=INK, ncols=4, loc="upper left")
    _finish(axes, "f [Hz]", "k_s [N/mm]")


def _validation(canvas: Canvas, case: str) -> None:
    left, right = canvas.subplots(1, 2)
    run = repeats(case)[0]
    ex = fitted_to(run.cycle)
    z = ex.series[0].inputs["z"]
    left.plot(z, run.cycle.F, "o", color=DATA, markersize=2.2, markeredgewidth=0, label="recording")
    for k, colour in ((0, MUTED), (1, BEFORE), (2, AFTER)):
        theta = np.array([run.stages[k].values[n] for n in ex.layout.names])
        error = ex.raw(theta, 0)[0]
        left.plot(z, run.cycle.F + error, color=colour, label=f"stage {k + 2}")
        if k:
            right.plot(z, 1e3 * error, color=colour, label=f"stage {k + 2}")
    left.legend(frameon=False, labelcolor=INK, fontsize=8)
    _finish(left, "z [mm]", "F [N]")
    _finish(right, "z [mm]", "F_r − F_m [mN]")


def _finish(axes: Axes | Any, x: str, y: str) -> None:
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    linear_ticks(axes.xaxis, 6)
    linear_ticks(axes.yaxis, 5)


LOOP = "a synthetic recording with the published stage-4 parameters and the noise of sec. 3.3; "
FIGURES = (
    Figure(
        "Fig. 7", "displacement and force over time, S1 at 3 mm",
        LOOP + "the measured one is not published", _histories, (9.0, 4.0),
    ),
    Figure(
        "Fig. 8", "loops of S1",
        LOOP + "dots: samples as recorded, lines: the mean of the fitted cycles, bars: ±h_s (6). "
        "Fig. 9, of S2, "
        "cannot be drawn: no parameters are given for it", _loops, (9.0, 4.2),
    ),
    Figure(
        "Fig. 10", "equivalent stiffness of S1 against frequency, 0.4 mm",
        "the published model, fitted at 0.1 Hz, leaves the frame; refitted to Table 3 it bends the wrong "
        "way, a springpot of two parameters does not. Of the synthetic sweep: every fourth cycle. "
        "At 0.6 and 0.8 mm there are curves, but no numbers",
        partial(_stiffness, sample="S1"), (9.0, 3.4),
    ),
    Figure(
        "Fig. 11", "equivalent stiffness of S2", "as above; no model of S2 is published",
        partial(_stiffness, sample="S2"), (9.0, 3.4),
    ),
    Figure(
        "Fig. 12", "both samples",
        "Table 3 and one springpot fitted to all of it, whose modulus varies with field and iron",
        _samples, (9.0, 3.4),
    ),
    *(
        Figure(
            number, f"validation, S1 {case}",
            "one run of the four stages on a synthetic recording: loops, and what is left of them. The "
            f"paper's own recording leaves {left} mN rms after stage 4",
            partial(_validation, case=case), (9.0, 3.6),
        )
        for number, case, left in (("Fig. 15", "M0", "17"), ("Fig. 16", "M1", "65"))
    ),
)  # fmt: skip
