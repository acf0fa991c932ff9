"""A frequency that is not the one that was set: what is left of sweeps is gone where each sample stands for
a frequency that is off by what the load does to the source.

An oscillator that is pulled by a reactance shears a resonance as a spring that hardens does, at any level.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modelgen.diagnose.gate.corrected import corrected
from modelgen.diagnose.gate.gains import CHECKED, gain_of
from modelgen.diagnose.gate.in_frequency import whitened
from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.search.screen import Tangent
from modelgen.fit.series import Array, Series

SAYS = "a source that its load pulls: the frequency is off by up to {0:.2g} of it, as {1} of Z goes"
TRIED = ("the sine of the phase", "the cosine of the phase", "the imaginary part", "the real part")
MOST = 0.1
"""Share of a frequency by which it may be off: more is noticed."""


def pulled(judge: Judge, base: Fit) -> tuple[Fit, str, float] | None:
    """The base fitted anew at frequencies f (1 + a u), of the `TRIED` u the likeliest, what that says, and
    the price of it; None where no a gains anything."""
    series = base.hypothesis.experiment.series
    n = effective(base.white)
    price = 2 * float(np.log(len(TRIED))) + float(np.log(n))
    loads = [_loads(s) for s in series]
    columns = whitened(judge, series, np.concatenate(_slopes(base, loads)))
    tangent = Tangent.of(*judge.tangent(base))
    gains = [gain_of(tangent, columns[:, [k]], n, price)[0] for k in range(len(TRIED))]
    which = int(np.argmax(gains))
    if gains[which] < CHECKED:
        return None
    chosen = [u[:, [which]] for u in loads]
    top = max(float(np.abs(u).max()) for u in chosen)
    axis = base.hypothesis.experiment.model.axis

    def slopes(fit: Fit) -> Array:
        return whitened(judge, series, np.concatenate(_slopes(fit, chosen)))

    def without(amounts: Array) -> tuple[Series, ...]:
        a = float(np.clip(amounts[0], -MOST / top, MOST / top))
        f = [s.inputs[axis] * (1 + a * u[:, 0]) for s, u in zip(series, chosen, strict=True)]
        return tuple(replace(s, inputs={**s.inputs, axis: x}) for s, x in zip(series, f, strict=True))

    fit, amounts = corrected(judge, base, slopes, without)
    return fit, SAYS.format(abs(float(amounts[0])) * top, TRIED[which]), price


def _loads(s: Series) -> Array:
    """(n, 4) what the load may pull by."""
    Z = s.reference
    unit, top = Z / np.maximum(s.size, 1e-300), max(float(s.size.max()), 1e-300)
    return np.stack([unit.imag, unit.real, Z.imag / top, Z.real / top], axis=1)


def _slopes(fit: Fit, loads: Sequence[Array]) -> list[Array]:
    """(n, k) complex changes of each sweep's readings with the amounts of its `loads`."""
    e = fit.hypothesis.experiment
    slopes = []
    for k, (s, u) in enumerate(zip(e.series, loads, strict=True)):
        modelled = (e.raw(fit.theta, k) + s.data) * np.array([[1], [1j]])
        slopes.append(np.gradient(modelled.sum(axis=0), np.log(s.inputs[e.model.axis]))[:, None] * u)
    return slopes
