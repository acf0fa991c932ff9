"""Table 1: rms roughness of the surfaces, six places each, and the error of its mean."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from statistics import fmean, stdev

from modelgen.papers.number import Published
from modelgen.papers.paper import Table

ROD, COLUMN, PLUNGER = "rod", "magnetic column", "displacement plunger"
R_Q = {  # [µm]
    ROD: ("0.577", "0.490", "0.539", "0.706", "0.910", "0.744"),
    COLUMN: ("0.345", "0.307", "0.333", "0.394", "0.368", "0.338"),
    PLUNGER: ("0.315", "0.378", "0.338", "0.308", "0.303", "0.297"),
}
MEAN = {ROD: "0.661", COLUMN: "0.347", PLUNGER: "0.323"}
STANDARD = {ROD: "0.012", COLUMN: "0.011", PLUNGER: "0.011"}


def standard_error(values: list[float]) -> float:
    """s/√n of the mean of n values."""
    return float(stdev(values) / len(values) ** 0.5)


def _of(statistic: Callable[[list[float]], float], surface: str) -> float:
    return statistic([float(x) for x in R_Q[surface]])


SAME_FORMULA = "s/√6 of the six values is 0.0638 µm for the rod, 0.0123 and 0.0124 µm for the others"


def _rows(surface: str) -> tuple[Published, ...]:
    readings = tuple(
        Published(surface, f"R_q, place {k}", text, "um", given="read off the microscope")
        for k, text in enumerate(R_Q[surface], 1)
    )
    mean = Published(
        surface, "mean R_q", MEAN[surface], "um", "mean of the six values", partial(_of, fmean, surface)
    )
    error = Published(
        surface, "standard uncertainty", STANDARD[surface], "um", "s/√6 of the six values",
        partial(_of, standard_error, surface), wrong=SAME_FORMULA,
    )  # fmt: skip
    return (*readings, mean, error)


SURFACES = Table(
    "Table 1",
    "Rms roughness R_q of the surfaces and the standard uncertainty of its mean",
    tuple(n for surface in R_Q for n in _rows(surface)),
)
