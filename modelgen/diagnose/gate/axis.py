"""A frequency that is not the one that was set: what is left of sweeps is gone where each sample stands for
one that is off by what the load does to the source, or by a smooth function of itself.

An oscillator that is pulled by a reactance shears a resonance as a spring that hardens does, at any level.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from modelgen.diagnose.gate.corrected import corrected
from modelgen.diagnose.gate.gains import CHECKED, gain_of
from modelgen.diagnose.gate.in_frequency import SPARE, whitened
from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.search.screen import Tangent
from modelgen.fit.series import Array, Series

PULLED = "a source that its load pulls: the frequency is off by up to {0} of it, as {1} of Z goes"
BOWED = "a frequency axis that is bowed, alike in all sweeps"
LOADS = ("the sine of the phase", "the cosine of the phase", "the imaginary part", "the real part")
BENDS = range(2, 7)
"""Half waves over ln f that an axis may be bowed by, all up to one of them together."""
MOST = 0.1
"""Share of a frequency by which it may be off: more is noticed."""


def mistaken(judge: Judge, base: Fit) -> tuple[Fit, str, float] | None:
    """The base fitted anew at the likeliest of frequencies f (1 + Σ a u), what that says, and the price of
    it; None where no a gains anything."""
    series, axis = base.hypothesis.experiment.series, base.hypothesis.experiment.model.axis
    n, tangent = effective(base.white), Tangent.of(*judge.tangent(base))
    gain, found = CHECKED, None
    for says, among, shapes in [*_pulled(series), *_bowed([s.inputs[axis] for s in series])]:
        if n - base.parameters - shapes[0].shape[1] < SPARE:
            continue
        columns = whitened(judge, series, np.concatenate(_slopes(base, shapes)))
        price = 2 * float(np.log(among))
        if (gained := gain_of(tangent, columns, n, price)[0]) > gain:
            gain, found = gained, (says, price, shapes)
    if found is None:
        return None
    says, price, shapes = found

    def slopes(fit: Fit) -> Array:
        return whitened(judge, series, np.concatenate(_slopes(fit, shapes)))

    def without(amounts: Array) -> tuple[Series, ...]:
        off = [np.clip(u @ amounts, -MOST, MOST) for u in shapes]
        moved = zip(series, off, strict=True)
        return tuple(replace(s, inputs={**s.inputs, axis: s.inputs[axis] * (1 + x)}) for s, x in moved)

    fit, amounts = corrected(judge, base, slopes, without)
    off = max(float(np.abs(u @ amounts).max()) for u in shapes)
    return fit, says.format(off), price + len(amounts) * float(np.log(n))


Shapes = tuple[str, int, list[Array]]
"""Words, among how many alike, and for each sweep (n, k) what its frequencies are off by."""


def _pulled(series: Sequence[Series]) -> Iterator[Shapes]:
    top = max(float(s.size.max()) for s in series)
    for k, name in enumerate(LOADS):
        says = PULLED.format("{0:.2g}", name)
        yield says, len(LOADS), [_loads(s, top)[:, [k]] for s in series]


def _loads(s: Series, top: float) -> Array:
    """(n, 4) what the load may pull by, in the order of `LOADS`."""
    Z = s.reference
    unit = Z / np.maximum(s.size, 1e-300)
    return np.stack([unit.imag, unit.real, Z.imag / top, Z.real / top], axis=1)


def _bowed(frequencies: Sequence[Array]) -> Iterator[Shapes]:
    low, high = min(f.min() for f in frequencies), max(f.max() for f in frequencies)
    for most in BENDS:
        waves = np.pi * np.arange(1, most + 1)
        yield (
            BOWED,
            len(BENDS),
            [np.cos(np.log(f / low)[:, None] / np.log(high / low) * waves) for f in frequencies],
        )


def _slopes(fit: Fit, loads: Sequence[Array]) -> list[Array]:
    """(n, k) complex changes of each sweep's readings with the amounts of its `loads`."""
    e = fit.hypothesis.experiment
    slopes = []
    for k, (s, u) in enumerate(zip(e.series, loads, strict=True)):
        modelled = (e.raw(fit.theta, k) + s.data) * np.array([[1], [1j]])
        slopes.append(np.gradient(modelled.sum(axis=0), np.log(s.inputs[e.model.axis]))[:, None] * u)
    return slopes
