"""What planned recordings would do to rivals that are linear in their parameters: quickly told of many, and
mostly more than is true."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modelgen.diagnose.experiment.foresee import HOPELESS, chance
from modelgen.diagnose.experiment.menu import Plan
from modelgen.diagnose.experiment.rivals import Rivals
from modelgen.diagnose.experiment.simulate import Made, alone, joined, planned, simulated
from modelgen.diagnose.hypotheses.refit import Fit
from modelgen.fit.series import Array, Series
from modelgen.fit.whitener import Whitener

RARE = 0.03
"""Probability up to which it does not matter what would be if a hypothesis were true."""
RIDGE = 1e-13
"""Added to the unit diagonal of normal matrices: what nothing tells stays where it is."""


@dataclass(frozen=True, eq=False)
class _View:
    """A rival at a planned recording: its outputs (channels, n), their derivatives (channels, p, n), and the
    normal matrix (p, p) of the recordings that are there."""

    fit: Fit
    out: Array
    slopes: Array
    before: Array


def hopes(rivals: Rivals, plan: Plan, times: Sequence[int], odds: Sequence[float]) -> Array:
    """What `plan` would be worth, were all rivals linear in their parameters, if averaged so many times:
    (len(times),). odds: of each of the hypotheses to be true; the least likely ones count nothing."""
    empty = planned(rivals, plan)
    views: dict[int, _View] = {}
    worth = np.zeros(len(times))
    for i, truth in enumerate(rivals.fits):
        asked = odds[i] > RARE and rivals.others(i)
        new = simulated(rivals, truth, plan, empty) if asked else None
        if new is None:
            continue
        least, noise = np.ones(len(times)), [new.whitener(n) for n in times]
        for rival in rivals.others(i):
            if id(rival) not in views:
                views[id(rival)] = _view(rivals, rival, empty)
            least = np.minimum(least, _chances(rivals, truth, views[id(rival)], new, noise))
            if least.max() < HOPELESS:
                break
        worth += odds[i] * least
    return worth / sum(x for x in odds if x > RARE)


def _step(A: Array, g: Array) -> Array:
    """A⁻¹ g; what nothing tells stays where it is."""
    unit = 1 / np.sqrt(np.maximum(np.diag(A), 1e-300))
    return np.asarray(unit * np.linalg.solve(A * unit * unit[:, None] + RIDGE * np.eye(len(g)), g * unit))


def _view(rivals: Rivals, fit: Fit, empty: Series) -> _View:
    e, theta = joined(fit, rivals.k, empty)
    last = alone(e)
    with np.errstate(all="ignore"):
        out, jac = last.prepared[0].jacobian(last.local(theta, 0), empty.measure)
    rows, slopes = list(empty.rows), np.zeros((len(empty.rows), len(theta), empty.n))
    for column, at in enumerate(last.layout.place[0]):
        if at >= 0:
            slopes[:, at] += jac[rows, column]
    before = np.zeros((len(theta), len(theta)))
    size = len(fit.theta)
    before[:size, :size] = rivals.normal(fit)
    return _View(fit, out[rows], slopes, before)


def _chances(rivals: Rivals, truth: Fit, view: _View, new: Made, noise: Sequence[Whitener]) -> Array:
    """Under each `noise`; 1 where a rival has no derivative: only a fit can tell."""
    e, p = view.out - new.plain.data, view.slopes.shape[1]
    found = []
    for w in noise:
        with np.errstate(over="ignore", invalid="ignore"):
            r = w.apply(e).ravel()
            J = w.apply(view.slopes).transpose(0, 2, 1).reshape(-1, p)
            A, g, rr = view.before + J.T @ J, J.T @ r, float(r @ r)
        if not (np.all(np.isfinite(A)) and np.all(np.isfinite(g)) and np.isfinite(rr)):
            found.append(1.0)
            continue
        more = max(rr - float(_step(A, g) @ g), 0.0) / (rivals.scale * rivals.judge.temper)
        found.append(chance(view.fit.bic - truth.bic + more, more))
    return np.array(found)
