"""What is left of tables over frequency, such as one at each amplitude: smooth functions of both.

They are weighed against colours of the noise, which leave each table its own path: each has the likelihood
of what it leaves, with a price for its numbers (G. Schwarz, Ann. Statist. 6 (1978) 461).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from modelgen.diagnose.gate.leftover import NOTHING, Leftover
from modelgen.diagnose.hypotheses.evidence import deviance, effective
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import COLOUR_SWEEP
from modelgen.diagnose.search.screen import Tangent
from modelgen.fit.colour import coloured
from modelgen.fit.series import Array, Series

ORDERS = range(1, 9)
"""Powers of ln f that are tried, together with those of the other variable up to MOST."""
MOST = 2
JOINT = "functions of frequency that change with"
ALIKE = "functions of frequency, alike in all tables: of the device, or of the instrument's calibration"
SPARE = 10
"""Values beyond parameters and amounts that a description must leave: fewer are met by anything."""


def together(judge: Judge, fit: Fit) -> Leftover:
    """The gain of functions of frequency and of what else differs between tables: products of powers."""
    e = fit.hypothesis.experiment
    plain = Judge(tuple(s.whitener for s in e.series), judge.prior)
    fit = plain.look(fit.hypothesis, fit.theta)
    tangent, tables = Tangent.of(*plain.tangent(fit)), _Tables.of(e.series, e.model.axis)
    ports = e.model.ports
    port = min(ports, key=lambda p: p.kind != "stiffness").name if ports else "model"
    n, most = effective(fit.white), tables.most
    known = _price(plain, fit, tangent.r, 0)
    if most:  # an error of an amplitude shifts all of a table
        shifts = tables.columns([(0, k) for k in range(1, most + 1)])
        known = min(known, _price(plain, fit, *_without(tangent, shifts)))
    best = NOTHING
    for i, k in product(ORDERS, range(most + 1)):
        columns = tables.columns(list(product(range(1, i + 1), range(k + 1))))
        if n - fit.parameters - columns.shape[1] < SPARE:
            continue
        rest, amounts = _without(tangent, columns)
        gain = known - _price(plain, fit, rest, amounts)
        if gain > best.gain:
            explained = float(tangent.r @ tangent.r - rest @ rest)
            best = Leftover(gain, explained, port, f"{JOINT} {tables.name}" if k else ALIKE)
    return best


@dataclass(frozen=True, eq=False)
class _Tables:
    """Tables and, for each, its frequencies and what else differs (its `name`), both from −1 to 1; `most`:
    the highest power of that."""

    series: Sequence[Series]
    along: Sequence[Array]
    across: Sequence[Array]
    name: str
    most: int

    @staticmethod
    def of(series: Sequence[Series], axis: str) -> _Tables:
        name, x = _other(series)
        along = _scaled([s.inputs[axis] for s in series])
        across = _scaled([np.full(s.n, v) for s, v in zip(series, x, strict=True)])
        return _Tables(series, along, across, name, min(MOST, len(set(x)) - 1))

    def columns(self, orders: Sequence[tuple[int, int]]) -> Array:
        """(N, k) over the noise: Legendre's polynomials of each pair of orders, at each output."""
        outputs, blocks = sorted({r for s in self.series for r in s.rows}), []
        for s, u, v in zip(self.series, self.along, self.across, strict=True):
            shapes = np.stack([_legendre(i, u) * _legendre(k, v) for i, k in orders])
            each = np.equal.outer(s.rows, outputs)[:, :, None, None] * shapes
            white = s.whitener.apply(each.reshape(len(s.data), -1, s.n))  # (outputs, k, n)
            blocks.append(white.transpose(0, 2, 1).reshape(-1, white.shape[1]))
        return np.concatenate(blocks)


def _other(series: Sequence[Series]) -> tuple[str, list[float]]:
    """Name and values of the first constant that differs between the recordings; no name where none does."""
    for name in series[0].constants:
        x = [float(s.constants.get(name, np.nan)) for s in series]
        if np.all(np.isfinite(x)) and len(set(x)) > 1:
            return name, x
    return "", [0.0] * len(series)


def _scaled(x: Sequence[Array]) -> list[Array]:
    """From −1 to 1 over all recordings, by the logarithm of what is positive."""
    if min(float(v.min()) for v in x) > 0:
        x = [np.log(v) for v in x]
    low, high = min(float(v.min()) for v in x), max(float(v.max()) for v in x)
    return [(2 * v - low - high) / max(high - low, 1e-300) for v in x]


def _legendre(order: int, x: Array) -> Array:
    return np.asarray(np.polynomial.legendre.Legendre.basis(order)(x))


def _without(tangent: Tangent, columns: Array) -> tuple[Array, int]:
    """The residual without free amounts of `columns` beside the fit's own parameters, and how many count."""
    rest = tangent.off(columns)
    size = np.linalg.norm(rest, axis=0)
    keep = size > 1e-6 * np.linalg.norm(columns, axis=0)
    if not keep.any():
        return tangent.r, 0
    u, s, _ = np.linalg.svd(rest[:, keep] / size[keep], full_matrices=False)
    u = u[:, s > 1e-5 * s[0]]
    return tangent.r - u @ (u.T @ tangent.r), u.shape[1]


def _price(plain: Judge, fit: Fit, rest: Array, amounts: int) -> float:
    """−2 ln of the likelihood of what is left, independent or of the likeliest colour, with the price of all
    numbers."""
    parts = np.split(rest, np.cumsum([x.size for x in fit.white])[:-1])
    white = [x.reshape(y.shape) for x, y in zip(parts, fit.white, strict=True)]
    own = coloured(plain.whiteners, white, COLOUR_SWEEP)
    filters = [(1.0,) if w.ar is None else tuple(w.ar) for w in own]
    orders = len(filters[0]) - 1 if len(set(filters)) == 1 else sum(len(a) - 1 for a in filters)
    number = float(np.log(effective(fit.white)))
    innovations = [w.colour(e) for w, e in zip(own, white, strict=True)]
    coloured_price = deviance(innovations, plain.prior, robust=True) + orders * number
    return min(deviance(white, plain.prior, robust=True), coloured_price) + amounts * number
