"""Parameters that one recording cannot tell apart, and what would: a wider band, a second recording with
a known constant changed, or one of them measured by other means."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from modelgen.fit.problem import Matrix, Vector
from modelgen.fit.series import Series
from modelgen.fit.uncertainty import Uncertainty

if TYPE_CHECKING:
    from modelgen.fit.experiment import Experiment

BOUND = 0.999  # correlation beyond which two parameters are as one
VAGUE = 0.1  # relative standard deviation beyond which a parameter is hardly known
WORTH = 10.0  # times as well known: what an experiment must reach to be named
CHANGE = 0.2  # relative change of a known constant in a second recording
MEASURED = 0.02  # relative deviation of a parameter that is measured by other means


@dataclass(frozen=True)
class Remedy:
    """Something to record or measure, and the standard deviation of the least known parameter with it."""

    says: str
    std: float


@dataclass(frozen=True)
class Confusion:
    """Parameters that are as one in these data: the least known one, its deviation and unit, and remedies."""

    name: str
    others: tuple[str, ...]
    std: float
    unit: str
    remedies: tuple[Remedy, ...]

    def __str__(self) -> str:
        together = f"{', '.join((self.name, *self.others[:-1]))} and {self.others[-1]}"
        says = f"{together} are one parameter in these data ({self.name}: ± {self.std:.2g} {self.unit})"
        if not self.remedies:
            return f"{says}; measure one of them by other means"
        return f"{says}; told apart by {', or '.join(f'{r.says} (± {r.std:.2g})' for r in self.remedies)}"


def confusions(ex: Experiment, theta: Vector, known: Uncertainty) -> tuple[Confusion, ...]:
    """Groups tied by correlations beyond BOUND in which a parameter is hardly known; best remedies first."""
    with np.errstate(invalid="ignore", divide="ignore"):
        relative = known.std / np.abs(theta)
    tied = np.abs(known.correlation) > BOUND
    left = {k for k in range(theta.size) if np.isfinite(known.std[k])}
    found = []
    while left:
        group = [left.pop()]
        for i in group:  # grows while it is walked
            more = [j for j in left if tied[i, j]]
            group += more
            left.difference_update(more)
        worst = max(group, key=lambda k: float(relative[k]))
        if len(group) > 1 and relative[worst] > VAGUE:
            others = [k for k in sorted(group) if k != worst]
            found.append(_confusion(ex, theta, known, worst, others))
    return tuple(found)


def _confusion(
    ex: Experiment, theta: Vector, known: Uncertainty, worst: int, others: Sequence[int]
) -> Confusion:
    names, J = ex.layout.names, known.jacobian / known.noise
    info = J.T @ J
    measured = f"measured to {100 * MEASURED:.0f} %"
    tried = [
        *(Remedy(f"{names[k]} {measured}", _with(info, _prior(theta, k), worst)) for k in others),
        *_second(ex, theta, info, known.noise, worst),
        *_wider(ex, theta, known.noise, worst),
    ]
    std = float(known.std[worst])
    remedies = sorted((r for r in tried if r.std < std / WORTH), key=lambda r: r.std)
    unit = ex.layout.parameters[worst].unit
    return Confusion(names[worst], tuple(names[k] for k in others), std, unit, tuple(remedies))


def _prior(theta: Vector, k: int) -> Matrix:
    more = np.zeros((theta.size, theta.size))
    more[k, k] = 1 / (MEASURED * abs(theta[k])) ** 2 if theta[k] else 0.0
    return more


def _with(info: Matrix, more: Matrix, k: int) -> float:
    """Standard deviation of parameter k by both informations (p, p); infinite where neither tells of it."""
    whole = info + more
    told = np.flatnonzero(whole.diagonal() > 0)
    if k not in told:
        return np.inf
    whole, k = whole[np.ix_(told, told)], int(np.searchsorted(told, k))
    scale = np.sqrt(whole.diagonal())
    return float(np.sqrt(np.linalg.pinv(whole / np.outer(scale, scale), rcond=1e-15)[k, k]) / scale[k])


def _second(ex: Experiment, theta: Vector, info: Matrix, noise: float, k: int) -> list[Remedy]:
    """The first recording again, with one of the constants that the case states changed by a known amount."""
    found = []
    for name, value in ex.constants.items():
        if value and not ex.model.parameter(name).known:
            series = replace(ex.series[0], constants={**ex.series[0].constants, name: value * (1 + CHANGE)})
            std = _with(info, _information(ex, theta, series, noise), k)
            found.append(Remedy(f"a second recording with {name} changed by {100 * CHANGE:.0f} %", std))
    return found


def _wider(ex: Experiment, theta: Vector, noise: float, k: int) -> list[Remedy]:
    """The first recording over three times its band, half an octave and more to either side."""
    first, axis = ex.series[0], ex.model.axis
    if ex.model.is_time_model or not np.all(first.inputs[axis] > 0):
        return []
    x = first.inputs[axis]
    low, high = x.min() / 3, x.max() * 3
    wide = replace(first, inputs={**first.inputs, axis: np.geomspace(low, high, x.size)})
    unit = ex.model.inputs[0].unit
    std = _with(_information(ex, theta, wide, noise), np.zeros((theta.size, theta.size)), k)
    return [Remedy(f"a band from {low:.3g} {unit} to {high:.3g} {unit}", std)]


def _information(ex: Experiment, theta: Vector, series: Series, noise: float) -> Matrix:
    """JᵀJ (p, p) of a recording like the first one, whose noise is taken to be the same."""
    layout = replace(ex.layout, place=ex.layout.place[:1], held=ex.layout.held[:1])
    alone = replace(ex, layout=layout, series=(series,))
    _, J = alone.linearised(theta)
    return np.asarray(J.T @ J) / noise**2
