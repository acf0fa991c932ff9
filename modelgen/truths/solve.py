"""How well the base model can hide an effect, and the strength at which it hides it to a wanted depth."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from .secret import NotDetectable

Responses = list[
    npt.NDArray[Any]
]  # one array a recording: complex Z (n,), force (n,), or k_s and angle (2, n)
Floats = npt.NDArray[np.float64]
Strength = Mapping[str, Mapping[str, Any]]
NOTHING: Strength = MappingProxyType({})
Whitener = Callable[[Responses, Responses], npt.NDArray[np.float64]]


@dataclass(frozen=True)
class Refit:
    """The base model nearest to a response.

    left          whitened misfit that is left
    r2            share of the responses' variance that it explains, noise aside
    bent          free parameter -> ln(value / true value)
    std           free parameter -> standard deviation of ln value, of the noise
    """

    left: Floats
    r2: float
    bent: dict[str, float]
    std: dict[str, float]

    @property
    def d2(self) -> float:
        """Whitened squared misfit."""
        return float(self.left @ self.left)

    @property
    def data(self) -> int:
        """How many whitened data d² is a sum over."""
        return len(self.left)

    @property
    def identifiable(self) -> tuple[str, ...]:
        """Parameters whose standard deviation is below a fifth of their value."""
        return tuple(n for n, s in self.std.items() if 0 < s < 0.2)

    @property
    def ratio(self) -> float:
        """Rms of the residual over the noise's, as it is expected of a recording with noise."""
        return float(np.sqrt(1 + self.d2 / self.data))


class Scene(Protocol):
    """A device, how it is recorded, and what of it is known."""

    def simulate(self, strength: Strength) -> Responses:
        """Noise-free responses of all recordings, those for the fit first."""

    def refit(self, y: Responses, beside: Strength = NOTHING) -> Refit:
        """The base model nearest to y over the fit recordings, with the effects `beside` as they are."""

    def white(self, i: int, e: Floats, data: Floats) -> Floats:
        """A residual e of recording i with its data, both (channels, n) in the channels' units (Re and Im of
        a complex one): over its noise, and without what one sample's noise tells of the next's."""


def refit_sweep(
    base: Callable[[Mapping[str, float]], Responses],
    true: Mapping[str, float],
    free: Sequence[str],
    whiten: Whitener,
    y: Responses,
) -> Refit:
    """Nonlinear least squares over the logarithms of the free parameters, from their true values."""

    def residual(x: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        p = dict(true)
        p.update({n: true[n] * np.exp(np.clip(xi, -30, 30)) for n, xi in zip(free, x, strict=False)})
        return whiten(y, base(p))

    x0 = np.zeros(len(free))
    fit = least_squares(
        residual, x0, method="lm", xtol=1e-12, ftol=1e-12, gtol=1e-12, max_nfev=60 * (len(x0) + 1)
    )
    info = np.linalg.pinv(fit.jac.T @ fit.jac)
    std = np.sqrt(np.clip(np.diag(info), 0, None))
    bent = {n: float(v) for n, v in zip(free, fit.x, strict=True)}
    nearest = base({**true, **{n: true[n] * np.exp(v) for n, v in bent.items()}})
    stds = dict(zip(free, map(float, std), strict=True))
    return Refit(fit.fun, explained(y, nearest), bent, stds)


def explained(y: Responses, base: Responses) -> float:
    """R² of `base` over all the recordings that it has: the mean over their channels."""
    whole = np.hstack([np.atleast_2d(a) for a in y[: len(base)]])
    lost = np.abs(whole - np.hstack([np.atleast_2d(b) for b in base])) ** 2
    spread = np.abs(whole - whole.mean(axis=1, keepdims=True)) ** 2
    return 1 - float(np.mean(lost.sum(axis=1) / spread.sum(axis=1)))


CHOSEN = ("law", "sign", "side", "power", "layers", "smooth")
"""What of an effect's form is one of a few, and not a number that a fit may change."""


SPAN_SIZE, SPAN = 30.0, 4.0
"""How many times larger or smaller than drawn the size of an effect, and every other number of its form, may
become to follow what isn't its own."""
GREAT = 1e6
"""Whitened misfit of a form that has no response."""


def nearest(scene: Scene, y: Responses, strength: Strength) -> Refit:
    """The base model with the effects of `strength` in it, nearest to y over the fit recordings, all numbers
    of their forms free: least squares over their logarithms, with the base refitted in each step."""
    free = [(e, n) for e, form in strength.items() for n in numbers(form)]

    def at(x: Floats) -> Refit:
        moved = {e: dict(form) for e, form in strength.items()}
        for (e, n), xi in zip(free, x, strict=True):
            moved[e][n] = float(moved[e][n]) * float(np.exp(xi))
        return scene.refit(y, moved)

    def left(x: Floats) -> Floats:
        with np.errstate(all="ignore"):
            try:
                found = at(x).left
            except (ValueError, np.linalg.LinAlgError):  # no response with such numbers
                return np.full(data, GREAT)
        return np.where(np.isfinite(found), found, GREAT)

    data = at(np.zeros(len(free))).data
    span = np.log([SPAN_SIZE if n == "size" else SPAN for _, n in free])
    fit = least_squares(
        left, np.zeros(len(free)), bounds=(-span, span), diff_step=1e-3, ftol=1e-4, xtol=1e-4, max_nfev=40
    )
    return at(fit.x)


def numbers(form: Mapping[str, Any]) -> list[str]:
    """Names of what a fit may change of an effect's form."""
    return [n for n, v in form.items() if n not in CHOSEN and float(v) != 0]


def tangents(scene: Scene, strength: Strength, effect: str) -> list[Responses]:
    """Changes of the responses with the logarithm of each number of one effect's form (its size among them),
    by central differences at its strength."""
    form, step, found = strength[effect], 0.02, []
    for name in numbers(form):
        up, down = (
            scene.simulate({**strength, effect: {**form, name: float(form[name]) * (1 + s)}})
            for s in (step, -step)
        )
        found.append([(a - b) / (2 * step) for a, b in zip(up, down, strict=True)])
    return found


def size_for(
    scene: Scene, effect: str, form: Mapping[str, Any], target: float, limit: float, least: float = np.inf
) -> tuple[float, Refit]:
    """The size of one effect at which the best base model leaves d² = target, to 1 %, and that base model.

    A secant in log-log, as d² grows nearly with the square of the size, kept inside a bracket.
    Where d² stays below the target up to `limit`, that is the size if d² is at least `least` there;
    raises NotDetectable if it isn't.
    """

    def at(size: float) -> Refit:
        return scene.refit(scene.simulate({effect: {**form, "size": size}}))

    size = min(float(form["size"]), limit)
    lo, hi = 0.0, np.inf
    points: list[tuple[float, float]] = []
    for _ in range(30):
        fit = at(size)
        points.append((np.log(size), np.log(max(fit.d2, 1e-30))))
        miss = np.log(target) - points[-1][1]
        if abs(miss) < 0.01:
            return size, fit
        if miss > 0 and size >= limit:
            if fit.d2 >= least:
                return size, fit
            raise NotDetectable(
                f"{effect}: the base model hides it to d² = {fit.d2:.3g} at its largest strength"
            )
        lo, hi = (size, hi) if miss > 0 else (lo, size)
        size = min(_next(points, np.log(target), lo, hi), limit)
    raise NotDetectable(f"{effect}: d² does not pass {target:.3g} smoothly")


def _next(points: list[tuple[float, float]], want: float, lo: float, hi: float) -> float:
    """The next size to try: along the last slope, or the middle of the bracket where that leaves it."""
    (x, y), slope = points[-1], 2.0
    if len(points) > 1 and abs(x - points[-2][0]) > 1e-9:
        slope = float(np.clip((y - points[-2][1]) / (x - points[-2][0]), 0.7, 8.0))
    size = float(np.exp(x + np.clip((want - y) / slope, -4, 4)))
    if lo < size < hi:
        return size
    return float(np.sqrt(lo * hi)) if lo > 0 else 0.3 * hi
