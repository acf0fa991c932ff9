"""Equivalent stiffness against frequency: models fitted to Table 3, and a synthetic sweep measured by "
"loops."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np

from modelgen.codegen import build
from modelgen.fit.fitting import fit
from modelgen.fit.loops import Loops, measure_loops
from modelgen.fit.result import FitResult
from modelgen.language import Equation, Input, Model, Output, Parameter, arg, pi, powj
from modelgen.models.complex_stiffness import complex_stiffness
from modelgen.models.fractional_kelvin_voigt import fractional_kelvin_voigt
from modelgen.papers.mre.tables import A_SWEEP, SWEEP, steady
from modelgen.papers.mre.truth import NOISE_F, NOISE_Z, Array
from modelgen.papers.paper import Cell, Found
from modelgen.recordings import Case, Noise, Recording

SETS = ("S1 M0", "S1 M1", "S2 M0", "S2 M1")
ROUNDING = 0.005 / 3**0.5  # [N/mm] standard deviation of Table 3's rounding
LOWEST, HIGHEST, DURATION, RATE = 0.3, 10.0, 120.0, 400.0  # of the sweep (sec. 3.3): [Hz], [s], [Hz]


def spring_and_springpot() -> Model:
    """K = k_0 + C (jω)^α: k_s = |K|, loss angle arg K, at any amplitude."""
    f = Input("f", "Hz", "frequency")
    k_0 = Parameter("k_0", "N/mm", 0.1, (0.0, 10.0), "spring")
    C = Parameter("C", "N/mm", 0.5, (0.0, 10.0), "modulus of the springpot at 1 rad/s")
    alpha = Parameter("alpha", "1", 0.2, (0.0, 1.0), "its order")
    unit = Parameter("unit_omega", "rad/s", 1.0, text="the unit 1 rad/s", known=True)
    omega = Equation("omega", 2 * pi * f / unit, "1", text="angular frequency over 1 rad/s")
    K = Equation("K", k_0 + C * powj(omega, alpha), "N/mm", text="complex stiffness")
    k_s = Equation("k_s", abs(K.symbol), "N/mm", "(4)", "equivalent stiffness")
    loss = Equation("loss_angle", arg(K.symbol) * 180 / pi, "deg", text="loss angle")
    return Model(
        "springpot", (f,), (k_0, C, alpha, unit), (omega, K, k_s, loss), (Output("k_s"), Output("loss_angle"))
    )


def sweep(name: str) -> tuple[Array, Array]:
    """f [Hz] and k_s [N/mm] (5,) of a sample and field in Table 3."""
    sample, M = name.split()
    f = np.array([float(row[0]) for row in SWEEP])
    column = int(sample[1]) - 1
    k_s = np.array([float((m1 if M == "M1" else m0)[column]) for _, m0, m1 in SWEEP])
    return f, k_s


def table_3(name: str, constants: Mapping[str, float]) -> Recording:
    """A set of Table 3 as a recording."""
    f, k_s = sweep(name)
    return Recording(name, None, "fit", {"f": f}, {"k_s": k_s}, constants=constants)


def fit_sweep(model: Model, name: str, constants: Mapping[str, float]) -> FitResult:
    """One set of Table 3 with its rounding as noise."""
    at = dict(constants) | ({"A_z": A_SWEEP} if "A_z" in {p.name for p in model.parameters} else {})
    case = Case(None, model.id, (table_3(name, at),), noise=Noise(sigma={"k_s": ROUNDING}))
    return fit(model, case)


MODELS: tuple[tuple[str, Model, dict[str, float], int], ...] = (
    ("a spring", spring_and_springpot(), {"C": 0.0, "alpha": 0.2}, 1),
    ("Kelvin–Voigt", complex_stiffness, {"h_D": 0.0, "rho": 1.46}, 2),
    ("modified Dahl", complex_stiffness, {"rho": 1.46}, 3),
    ("springpot", spring_and_springpot(), {"k_0": 0.0}, 2),
    ("spring and springpot", spring_and_springpot(), {}, 3),
)


def against_sweep() -> Found:
    """How well each model follows Table 3: rms of the relative misfit [%] in each set."""
    rows: list[tuple[Cell, ...]] = []
    published: list[Cell] = []
    for name in SETS:
        f, k_s = sweep(name)
        if name.startswith("S1"):
            ours = np.array([steady(name[3:], "k_s", A_SWEEP, x) for x in f])
            published.append(100 * float(np.sqrt(np.mean((ours / k_s - 1) ** 2))))
        else:
            published.append("–")
    rows.append(("modified Dahl, published stage 4", "0", *published))
    for label, model, held, count in MODELS:
        rows.append(
            (label, str(count), *(100 * _misfit(fit_sweep(model, name, held), name) for name in SETS))
        )
    return Found(
        (
            "Table 3's rounding alone is 0.14 to 0.48 %. The published set, fitted at 0.1 Hz, is several "
            "times too stiff at 9 Hz; refitted, spring, dashpot and friction still miss by 5 %, ten times "
            "the rounding: their stiffness grows as f² before it grows as f, the measured one is concave",
            "two parameters of a springpot, C(jω)^α with α about 0.16, do what no set of the paper's model "
            "does. In time it is the fractional Kelvin–Voigt model, which ships, fits and exports like the "
            "others that the paper lists: Kelvin–Voigt, Bouc–Wen, LuGre, four-parameter viscoelastic",
        ),
        ("rms misfit over rms k_s [%]", "parameters", *SETS),
        tuple(rows),
    )  # fmt: skip


def _misfit(found: FitResult, name: str) -> float:
    return found.rms["N/mm"]["fit"] / float(np.sqrt(np.mean(sweep(name)[1] ** 2)))


@cache
def springpot(name: str) -> dict[str, float]:
    """C [N/mm] and α of a set of Table 3."""
    found = fit_sweep(spring_and_springpot(), name, {"k_0": 0.0})
    return {n: found[n].value for n in ("C", "alpha")}


@cache
def swept(name: str = "S1 M0") -> Loops:
    """Cycles of a synthetic sweep at 0.4 mm, with Table 3's springpot for truth and the noise of sec. 3.3."""
    t = np.arange(0, DURATION, 1 / RATE)
    rise = np.log(HIGHEST / LOWEST) / DURATION
    z = -A_SWEEP * np.cos(2 * np.pi * LOWEST * np.expm1(rise * t) / rise)
    model = build(fractional_kelvin_voigt, wait=True)
    F = model(t=t, z=z, k_D=0.0, F_0=0.0, z_rest=float(z[0]), **springpot(name))
    rng = np.random.default_rng(4)
    less = (RATE / 4000.0) ** 0.5  # each sample the mean of ten
    noise = [less * x * rng.standard_normal(t.size) for x in (NOISE_Z, NOISE_F)]
    return measure_loops(t, z + noise[0], np.asarray(F) + noise[1], skip=1)


def along_a_sweep() -> Found:
    """k_s, c_loss and loss angle of the synthetic sweep in groups of cycles, and the truth."""
    found, true = swept(), springpot("S1 M0")
    angle = 90 * true["alpha"]
    rows: list[tuple[Cell, ...]] = []
    for group in found.groups(8):
        mean = found.mean(group)
        f = found.values["f"][group]
        k_s = float(np.mean(true["C"] * (2 * np.pi * f) ** true["alpha"]))
        loss = float(np.mean(np.sin(np.radians(angle)) * k_s / (2 * np.pi * f)))
        rows.append((f"{mean['f'][0]:.3g}", str(group.size), k_s, mean["k_s"][0], loss, mean["c_loss"][0],
                     angle, mean["loss_angle"][0], mean["loss_angle"][1]))  # fmt: skip
    return Found(
        (
            "a sweep from 0.3 to 10 Hz in two minutes at 0.4 mm, cycle by cycle: the truth is the springpot "
            "fitted to Table 3's S1 M0, in time (fractional Kelvin–Voigt, whose ladder of Maxwell arms is "
            "good to 0.3 % and makes what differs here). The loss angle at 1 to 9 Hz, which the paper does "
            "not give, could be had from its recordings to a few hundredths of a degree",
        ),
        (
            "f [Hz]",
            "cycles",
            "k_s",
            "found [N/mm]",
            "c_loss",
            "found [N·s/mm]",
            "loss angle",
            "found [°]",
            "±",
        ),
        tuple(rows),
    )
