"""The tables of the MRE paper, and the numbers of its text that can be checked."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import pi

import numpy as np

from modelgen.codegen import build
from modelgen.models.complex_stiffness import complex_stiffness
from modelgen.papers.mre.stages import FOUR
from modelgen.papers.mre.truth import STAGE_4, repeats
from modelgen.papers.number import Published
from modelgen.papers.paper import Table

LENGTH, AREA = 43.0, 256.0  # d [mm], a_s [mm²]: sec. 3.4
F_STATIC, A_STATIC, A_SWEEP = 0.1, 3.0, 0.4
SYMBOL = {"rho": "ρ"}
UNIT = {"k_D": "N/mm", "c_D": "N*s/mm", "h_D": "N", "rho": "1/mm", "J_e": "N", "J_es": "N"}
RAW = "needs the recordings of z and F_m, which are not published"
FEMM = "needs the magnets' size (drawn in Fig. 4b) and the B-H curves (Fig. 2), not given as numbers"
GAUSS = "a reading of the gaussmeter"
STANDS_IN = (
    "needs the recordings of z and F_m, which are not published; ours is from a synthetic one of the "
    "published stage-4 parameters with the noise of sec. 3.3"
)
TOO_STIFF = (
    "the model, fitted at 0.1 Hz, does not hold at other frequencies: its dashpot's force grows as f, the "
    "sample's stiffness as f^0.17"
)
SPREAD = (
    "needs the recordings. On a synthetic one the ten runs of stage 4 end in one point: least squares from "
    "stage 3's sets leaves no spread. Either the printed stage 4 had not converged, or its runs were not on "
    "one recording"
)

FIELD = (  # point, FEMM of S1 and S2, gaussmeter: B_x, B_y [mT]
    ("1", ("175", "-2"), ("176", "-2"), ("175", "")),
    ("2", ("-53", "-63"), ("-54", "-64"), ("", "-32")),
    ("3", ("136", "125"), ("138", "120"), ("185", "")),
    ("4", ("361", "0"), ("366", "0"), ("370", "")),
    ("5", ("219", "0"), ("220", "0"), ("183", "")),
)
STATIC = (  # sample, range of stress [kPa], k_s, c_s, h_s, the case in Table 4
    ("S1 M0", ("0.27", "9.70"), "0.40", "0.64", "0.205", "M0"),
    ("S1 M1", ("-2.10", "15.87"), "0.77", "1.23", "0.475", "M1"),
    ("S2 M0", ("-0.64", "12.65"), "0.57", "0.91", "0.300", ""),
    ("S2 M1", ("-4.00", "19.58"), "1.01", "1.61", "0.600", ""),
)
SWEEP = (  # frequency [Hz]; k_s of S1 and S2 and their difference [N/mm], at M0 and M1
    (1, ("0.60", "0.83", "0.23"), ("1.24", "1.50", "0.26")),
    (3, ("0.71", "0.96", "0.25"), ("1.48", "1.76", "0.28")),
    (5, ("0.78", "1.05", "0.27"), ("1.62", "1.89", "0.27")),
    (7, ("0.83", "1.11", "0.28"), ("1.71", "1.99", "0.28")),
    (9, ("0.87", "1.15", "0.28"), ("1.79", "2.06", "0.27")),
)
ESTIMATES = {  # stages 1 to 4 of Table 4
    "M0": (
        ("3.01", "0.099", "1.3", "6.63"),
        ("0.3494", "0.0811", "0.1972", "1.59", "0.20002", "0.16608"),
        ("0.3819", "0.0886", "0.0409", "1.46", "0.01673", "0.01351"),
        ("0.3834", "0.0912", "0.0353", "1.46", "0.01666", "0.01345"),
    ),
    "M1": (
        ("2.99", "0.1", "1.85", "6.64"),
        ("0.6602", "0.1130", "0.2906", "1.41", "0.14802", "0.11682"),
        ("0.6784", "0.1343", "0.2372", "1.46", "0.06506", "0.05300"),
        ("0.6797", "0.1374", "0.2309", "1.44", "0.06511", "0.05296"),
    ),
}
EXTREMES = {  # least and greatest of ten runs, Table 5
    "M0": (("0.3800", "0.3856"), ("0.0892", "0.0937"), ("0.0286", "0.0442"), ("0.99", "1.85")),
    "M1": (("0.6689", "0.6899"), ("0.1285", "0.1492"), ("0.1993", "0.2598"), ("1.18", "1.68")),
}


def _field() -> Table:
    numbers: list[Published] = []
    for point, *columns in FIELD:
        for name, pair in zip(("FEMM, S1", "FEMM, S2", "gaussmeter, S1"), columns, strict=True):
            read = name.startswith("gauss")
            numbers += [
                Published(f"point {point}, {name}", q, printed, "mT", given=GAUSS)
                if read
                else Published(f"point {point}, {name}", q, printed, "mT", lacks=FEMM)
                for q, printed in zip(("B_x", "B_y"), pair, strict=True)
                if printed
            ]
    gap = max(abs(float(r[3][k]) - float(r[1][k])) for r in FIELD for k in (0, 1) if r[3][k] and r[0] in "23")
    numbers.append(
        Published(
            "text, points 2 and 3", "worst |gaussmeter − FEMM|", "48", "mT", "|185 − 136|, from the table",
            lambda: gap, wrong="the table itself has 185 − 136 = 49 at point 3",
        )
    )  # fmt: skip
    return Table(
        "Table 1",
        "Magnetic flux density at five points. (Text: magnets N38; simulated: N30)",
        tuple(numbers),
    )


def force_amplitude(stress: tuple[str, str]) -> float:
    """A_Fm [N] from a range of stress [kPa]."""
    return (float(stress[1]) - float(stress[0])) / 2 * AREA * 1e-3


def mean_force(stress: tuple[str, str]) -> float:
    """The middle of the range of force [N]."""
    return (float(stress[1]) + float(stress[0])) / 2 * AREA * 1e-3


def steady(case: str, quantity: str, A: float = A_STATIC, f: float = F_STATIC) -> float:
    """k_s [N/mm] or h_s [N] of a steady cycle of the modified Dahl model with the published stage 4."""
    k_s, loss = build(complex_stiffness, wait=True)(f=f, A_z=A, **STAGE_4[case])
    return float(k_s if quantity == "k_s" else k_s * A * np.sin(np.radians(loss)))


def _static() -> Table:
    numbers: list[Published] = []
    for sample, stress, k_s, c_s, h_s, case in STATIC:
        amplitude = force_amplitude(stress)
        exact = f"A_F/(2πf A_z) from the printed stress is {amplitude / (0.2 * pi * A_STATIC):.4f}"
        rounded = f"{float(k_s) / (2 * pi * F_STATIC):.3f}"
        numbers += [
            Published(sample, "least strain", "0", "%", "(2) at z = −max z", _value(0.0)),
            Published(sample, "greatest strain", "13.95", "%", "(2): 2 A_z/d",
                      _value(200 * A_STATIC / LENGTH)),
            Published(sample, "least stress", stress[0], "kPa", lacks=RAW),
            Published(sample, "greatest stress", stress[1], "kPa", lacks=RAW),
            Published(sample, "k_s", k_s, "N/mm", "(4) from the printed range of stress",
                      _value(amplitude / A_STATIC)),
            Published(sample, "c_s", c_s, "N*s/mm", "(5): A_F/(2πf A_z) = k_s/(2πf), no damping in it",
                      _value(amplitude / A_STATIC / (2 * pi * F_STATIC)),
                      wrong=f"{exact}; the printed value follows from k_s rounded to {k_s}: {rounded}"),
            _width(sample, h_s, case),
        ]  # fmt: skip
    return Table(
        "Table 2",
        "Loops at 3 mm and 0.1 Hz. Printed (5) has A_z for the amplitude of ż: the dot is lost",
        tuple(numbers),
    )


def _width(sample: str, printed: str, case: str) -> Published:
    if not case:
        return Published(sample, "h_s", printed, "N", lacks=RAW + "; no parameters are given for S2")
    A, f = (float(x) for x in ESTIMATES[case][0][:2])
    return Published(
        sample, "h_s", printed, "N", "(6) in the steady loop of Table 4, stages 1 and 4",
        partial(steady, case, "h_s", A, f),
        missed=f"the fitted loop is not the measured one, its J_e is {ESTIMATES[case][3][4]} N; {RAW}",
    )  # fmt: skip


def _sweep() -> Table:
    numbers: list[Published] = []
    for f, *fields in SWEEP:
        for M, (s1, s2, gap) in zip(("M0", "M1"), fields, strict=True):
            numbers += [
                Published(f"{f} Hz, {M}", "k_s of S1", s1, "N/mm",
                          "modified Dahl model with the published stage 4 at 0.4 mm",
                          partial(steady, M, "k_s", A_SWEEP, float(f)),
                          missed=TOO_STIFF),
                Published(f"{f} Hz, {M}", "k_s of S2", s2, "N/mm", lacks=RAW + "; no model is given for S2"),
                Published(f"{f} Hz, {M}", "k_d", gap, "N/mm", "difference of the printed stiffnesses",
                          _value(float(s2) - float(s1))),
            ]  # fmt: skip
    return Table(
        "Table 3",
        "Equivalent stiffness against frequency, 0.4 mm. k_d is what more iron does, and hardly depends on "
        "the field (0.23 to 0.28 at M0 and M1): the text concludes the opposite. What the field does is M1 "
        "less M0, 0.64 to 0.92 N/mm",
        tuple(numbers),
    )


def _value(x: float) -> Callable[[], float]:
    return lambda: x


def _estimates() -> Table:
    numbers: list[Published] = []
    for case, (first, *later) in ESTIMATES.items():
        numbers += _first_stage(case, first)
        for k, stage in enumerate(later):
            numbers += [
                Published(f"{case}, stage {k + 2}", SYMBOL.get(q, q), printed, UNIT[q],
                          "mean of ten runs, J_es inside",
                          partial(_mean, case, k, q), lacks=STANDS_IN)
                for q, printed in zip((*FOUR, "J_e", "J_es"), stage, strict=True)
            ]  # fmt: skip
    four = {q: [float(ESTIMATES[c][3][FOUR.index(q)]) for c in ("M0", "M1")] for q in ("k_D", "c_D")}
    numbers += [
        Published("text, M1 against M0", f"rise of {q}", printed, UNIT[q], "from the printed stage 4",
                  _value(four[q][1] - four[q][0]))
        for q, printed in (("k_D", "0.3"), ("c_D", "0.046"))
    ]  # fmt: skip
    return Table(
        "Table 4",
        "Parameter estimates after each stage, mean of ten runs. ρ is in 1/mm, printed as s/mm",
        tuple(numbers),
    )


def _first_stage(case: str, printed: tuple[str, ...]) -> list[Published]:
    stress = {s[5]: s[1] for s in STATIC}[case]
    how = "stage 1: extremes, auto- and cross-correlation"
    row = f"{case}, stage 1"
    return [
        *(
            Published(row, q, text, unit, how, partial(_first, case, name), lacks=STANDS_IN)
            for q, name, unit, text in zip(
                ("A_zD", "f_zD", "Δt_m"), ("A", "f", "shift"), ("mm", "Hz", "s"),
                (printed[0], printed[1], printed[3]), strict=True,
            )
        ),
        Published(
            row, "F_0", printed[2], "N", "middle of Table 2's range of stress, times a_s",
            _value(mean_force(stress)),
            missed="the middle of the range is the mean over a cycle for a loop alike in both halves; " + RAW,
        ),
    ]  # fmt: skip


def _first(case: str, name: str) -> float:
    return float(getattr(repeats(case)[0].cycle, name))


def found(case: str, stage: int, quantity: str) -> np.ndarray:
    """One quantity after a stage (0 for stage 2) in each of the ten runs."""
    stages = [run.stages[stage] for run in repeats(case)]
    return np.array([s.values[quantity] if quantity in s.values else getattr(s, quantity) for s in stages])


def _mean(case: str, stage: int, quantity: str) -> float:
    return float(found(case, stage, quantity).mean())


def _extreme(case: str, quantity: str, greatest: bool) -> float:
    values = found(case, 2, quantity)
    return float(values.max() if greatest else values.min())


def _extremes() -> Table:
    numbers = [
        Published(f"case {case}", f"{name} {SYMBOL.get(q, q)}", text, UNIT[q], f"{name} of ten runs, stage 4",
                  partial(_extreme, case, q, name == "greatest"), lacks=SPREAD)
        for case, rows in EXTREMES.items()
        for q, pair in zip(FOUR, rows, strict=True)
        for name, text in zip(("least", "greatest"), pair, strict=True)
    ]  # fmt: skip
    return Table("Table 5", "Least and greatest value in ten runs of stage 4", tuple(numbers))


NOISE = Table(
    "Sec. 3.3, 3.4",
    "Numbers of the text",
    (
        Published("displacement", "standard deviation", "2.88e-4", "mm", given="of the encoder"),
        Published("force", "standard deviation", "1.85e-3", "N", given="of the force sensor"),
        Published(
            "residual magnetism", "rise of F_m after 6 h in the field", "0.15", "N",
            lacks=RAW + "; modelgen loops --against tells such a rise from two recordings",
        ),
    ),
)  # fmt: skip
TABLES = (_field(), NOISE, _static(), _sweep(), _estimates(), _extremes())
