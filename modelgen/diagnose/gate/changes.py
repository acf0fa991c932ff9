"""What changes while it is recorded and has no law for that: a stiffness, a dashpot or a sensor's gain that
is pumped at a frequency of its own, and a force or a stiffness that jumps at one moment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.gate.spectrum import highest, standing_out, tuned
from modelgen.diagnose.gate.tried import JUMP, Tried, best_of, channel_of, in_channel
from modelgen.diagnose.hypotheses.functions import ORDERS, PUMP, scaled, scaled_speed
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.search.screen import Tangent
from modelgen.fit.series import Array
from modelgen.language import Model

CHANGING = {"z": "a stiffness", "v": "a damping", "F": "a gain of the force channel"}
"""What may change, by what the change is in proportion to."""
FEWEST = 200
"""Samples of a record in which a frequency is looked for."""
PERIODS = 4.0
"""In a record, at least: what is slower is a drift."""
LINE = 30.0
"""Times the spectrum around it that a product of displacement and speed has where what follows the motion
would change at a frequency, too."""
WAVES = 6
"""Of what changes more slowly."""
MOMENTS = 60
"""At which a jump is tried in each recording."""


@dataclass(frozen=True, eq=False)
class Output:
    """An output, by its port, and for each record its channel, displacement z, speed v and modelled force F,
    in units of their size."""

    port: str
    channels: tuple[int, ...]
    z: Sequence[Array]
    v: Sequence[Array]
    F: Sequence[Array]

    @classmethod
    def of(cls, model: Model, fit: Fit, place: tuple[str, str]) -> Output:
        """That of a `place` (port, output)."""
        e, (port, name) = fit.hypothesis.experiment, place
        at = tuple(channel_of(model, s, name) for s in e.series)
        z = scaled([s.inputs[model.moved] for s in e.series])
        v = scaled_speed([s.inputs[model.derived_from(model.moved)["rate"]] for s in e.series])
        modelled = [e.raw(fit.theta, k) + s.data for k, s in enumerate(e.series)]
        F = scaled([x[c] for x, c in zip(modelled, at, strict=True)])
        return cls(port, at, z, v, F)

    def columns(self, fit: Fit, plain: Judge, k: int, terms: Array) -> Array:
        """Whitened columns (N, m) of `terms` (m, n) of the record k, nothing in the others."""
        blocks = []
        for i, (s, w) in enumerate(zip(fit.hypothesis.experiment.series, plain.whiteners, strict=True)):
            if i == k:
                blocks.append(in_channel(w, terms, self.channels[k], len(s.data)))
            else:
                blocks.append(np.zeros((s.data.size, len(terms))))
        return np.concatenate(blocks)


def changes(model: Model, fit: Fit, plain: Judge, tangent: Tangent, at: Output) -> list[Tried]:
    """What is pumped, what wanders, and what jumps, one of each kind at an output."""
    axis, unit = model.axis, next(i.unit for i in model.inputs if i.name == model.axis)
    pumped = [x for by in CHANGING if (x := _pumped(axis, fit, plain, tangent, at, by)) is not None]
    slow = [_wandering(axis, fit, plain, tangent, at, by) for by in CHANGING]
    jumps = [_jump((axis, unit), fit, plain, tangent, at, by) for by in ("", "z")]
    return pumped + slow + jumps


def _pumped(axis: str, fit: Fit, plain: Judge, tangent: Tangent, at: Output, by: str) -> Tried | None:
    """What changes with a sine of one frequency, in proportion to `by`, of its own phase in each record.

    Residual times `by` has a line there, over the spectrum around it; the price is that of having looked.
    """
    series = fit.hypothesis.experiment.series
    long = [k for k, s in enumerate(series) if s.n >= FEWEST and np.any(getattr(at, by)[k])]
    if not long:
        return None
    times = [series[k].inputs[axis] for k in long]
    span = max(float(t[-1] - t[0]) for t in times)
    grid = np.arange(PERIODS / span, 0.98 * min(map(highest, times)), 0.5 / span)
    if not len(grid):
        return None
    looked = 2 * float(np.log(len(grid) * len(CHANGING)))
    products = [
        (t, fit.white[k][at.channels[k]] * getattr(at, by)[k]) for k, t in zip(long, times, strict=True)
    ]
    each = [standing_out(t, x, grid) for t, x in products]
    if 2 * float(np.max(np.sum(each, axis=0))) < looked:
        return None
    for shown, k, t in zip(each, long, times, strict=True):
        x = getattr(at, by)[k]
        shown[np.any([standing_out(t, x * y, grid) > LINE for y in _motions(at, k)], axis=0)] = 0.0
    total = np.sum(each, axis=0)
    f = tuned(products, float(grid[int(np.argmax(total))]), 0.5 / span)
    pairs = zip(long, times, strict=True)
    columns = [_waves(fit, plain, at, by, k, 2 * np.pi * f * t[None]) for k, t in pairs]
    says = f"{CHANGING[by]} that changes at {f:.4g} Hz, which does not follow the motion"
    like = Leftover(0.0, 0.0, at.port, says, (PUMP,))
    found = best_of(tangent, np.concatenate(columns, axis=1), plain.prior, fit.white, like)
    left = replace(found.left, gain=found.left.gain - looked, terms=(PUMP, f, by, ORDERS))
    return replace(found, left=left, price=found.price + looked)


def _waves(fit: Fit, plain: Judge, at: Output, by: str, k: int, turns: Array) -> Array:
    """Columns of the cosines and sines of `turns` (m, n) in the record k, in proportion to `by`."""
    x = getattr(at, by)[k]
    return at.columns(fit, plain, k, x * np.concatenate([np.cos(turns), np.sin(turns)]))


def _wandering(axis: str, fit: Fit, plain: Judge, tangent: Tangent, at: Output, by: str) -> Tried:
    """What changes slowly in the course of a record, in proportion to `by`: waves of twice the longest record
    and their harmonics, in each record its own."""
    times = [s.inputs[axis] for s in fit.hypothesis.experiment.series]
    f = 0.5 / max(float(t[-1] - t[0]) for t in times)
    orders = np.arange(1, WAVES + 1)[:, None]
    columns = [_waves(fit, plain, at, by, k, 2 * np.pi * f * orders * t) for k, t in enumerate(times)]
    like = Leftover(0.0, 0.0, at.port, f"{CHANGING[by]} that changes in the course of a record", (PUMP,))
    found = best_of(tangent, np.concatenate(columns, axis=1), plain.prior, fit.white, like)
    return replace(found, left=replace(found.left, terms=(PUMP, f, by, WAVES)))


def _motions(at: Output, k: int) -> list[Array]:
    """What a force that follows the motion of the record k may be in proportion to."""
    z, v = at.z[k], at.v[k]
    return [z, np.abs(z), z**3, v, np.abs(v), np.sign(v)]


def _jump(axis: tuple[str, str], fit: Fit, plain: Judge, tangent: Tangent, at: Output, by: str) -> Tried:
    """The best jump at one moment of one recording, of the force or of what is in proportion to `by`, there
    or in all that follow, too: a clamp slips, a sensor is knocked, something cracks. axis: its name and
    unit."""
    series = fit.hypothesis.experiment.series
    like = Leftover(0.0, 0.0, at.port, "", (JUMP,))

    def best(k: int, moments: Array, stays: bool) -> tuple[Tried, int, int, bool]:
        columns = _steps(fit, plain, at, by, k, moments, stays)
        found = best_of(tangent, columns, plain.prior, fit.white, like)
        return found, k, int(moments[found.left.terms[1]]), stays

    last = len(series) - 1
    places = [(k, stays) for k in range(len(series)) for stays in ((False, True) if k < last else (False,))]
    grids = [np.linspace(0, s.n, MOMENTS + 2)[1:-1].astype(int) for s in series]
    _, k, i, stays = max((best(k, grids[k], stays) for k, stays in places), key=lambda x: x[0].left.gain)
    wide = series[k].n // (MOMENTS + 1) + 1
    near = np.linspace(max(i - wide, 1), min(i + wide, series[k].n - 1), MOMENTS).astype(int)
    found, k, i, stays = best(k, np.unique(near), stays)
    looked = 2 * float(np.log(len(places) * MOMENTS))
    what = CHANGING[by].replace("a ", "the ", 1) if by else "the force"
    says = f"a jump of {what} at {series[k].inputs[axis[0]][i]:.4g} {axis[1]} in {series[k].name}"
    left = replace(found.left, gain=found.left.gain - looked, says=says + (", which stays" if stays else ""))
    return replace(found, left=left, price=found.price + looked)


def _steps(fit: Fit, plain: Judge, at: Output, by: str, k: int, moments: Array, stays: bool) -> Array:
    """Columns (N, moments) of what is 1, or in proportion to `by`, from each of the moments on in record k,
    and in all later ones if it `stays`."""
    series = fit.hypothesis.experiment.series
    x = [np.asarray(getattr(at, by)[i]) if by else np.ones(s.n) for i, s in enumerate(series)]
    columns = at.columns(fit, plain, k, (np.arange(series[k].n) >= moments[:, None]) * x[k])
    for i in range(k + 1, len(x) if stays else 0):
        columns += at.columns(fit, plain, i, x[i][None])
    return columns
