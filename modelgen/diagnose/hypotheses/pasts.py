"""What it costs that no one knows what a sample had been through before each record.

BIC's price of a number, ln n, is that of one which every further sample tells better. What the states of an
effect were before a record shows at its beginning alone, and often not at all: there it costs by how much
narrower it is known afterwards, ln det(1 + W S W) with S the information on it that no other parameter
takes up, W the widths of what was thought possible (Laplace's approximation of the evidence).
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from modelgen.fit.experiment import Layout
from modelgen.fit.series import Array

RENAMED = 1e-9
"""Share of the information, relative to the greatest, below which parameters say the same."""


def is_past(layout: Layout, pasts: Collection[str]) -> Array:
    """Which of θ, (p,) bool, are values of `pasts` in one of the recordings."""
    return np.array([n.partition("[")[0] in pasts for n in layout.names], dtype=bool)


def price(told: Array, marked: Array, others: Array, widths: Array, temper: float) -> float:
    """−2 ln of the evidence that the `marked` (p,) of the numbers cost beside the `others`.

    told: information JᵀJ (p, p) of whitened residuals, of which `temper` in a row count as one. widths: (p,)
    standard deviations of what was thought possible.
    """
    size = np.sqrt(np.diag(told))
    told = told / np.outer(size, size).clip(min=1e-300)
    beside = told[np.ix_(others, marked)]
    rest = beside.T @ np.linalg.pinv(told[np.ix_(others, others)], RENAMED) @ beside
    width = (size * widths)[marked]
    own = (told[np.ix_(marked, marked)] - rest) * np.outer(width, width)
    return float(np.linalg.slogdet(np.eye(len(own)) + own / temper)[1])


def widths_of(layout: Layout, theta: Array) -> Array:
    """Standard deviations of what was thought possible: evenly between bounds, else as much as the value."""
    spans = np.array([p.bounds[1] - p.bounds[0] for p in layout.parameters])
    return np.where(np.isfinite(spans), spans / np.sqrt(12.0), np.abs(theta))
