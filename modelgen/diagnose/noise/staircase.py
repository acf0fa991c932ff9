"""What rounding to a grid leaves: an error that repeats with the reading, a grid step at a time.

Where steps Δ are wide beside the noise σ before them, the mean error of a rounded reading y goes with y
in the period of the step: −Σₖ aₖ sin(2πky/Δ), aₖ = (−1)ᵏ Δ/(πk) exp(−2π²k²σ²/Δ²) (Widrow and Kollár,
Quantization Noise, 2008, ch. 5 and appendix G). It lasts where a motion turns or rests, as a force does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modelgen.diagnose.hypotheses.refit import Fit
from modelgen.fit.scatter import rounding
from modelgen.fit.series import Array, Series
from modelgen.fit.together import Together

HARMONICS = 4
"""Of those left out none has more than a fifth of the first one's amplitude, and only where nothing
scatters."""
MATTERS = 1.0
"""Variance of a harmonic's mode, over that of a sample's own noise, from which it counts."""


def rounded(series: Sequence[Series], fit: Fit) -> tuple[Series, ...]:
    """Recordings over time whose samples have the errors of rounding together, as functions of what `fit`
    predicts. Neither phase (an instrument's zero) nor amplitude is taken for known."""
    e = fit.hypothesis.experiment
    return tuple(_rounded(s, e.raw(fit.theta, k)) for k, s in enumerate(series))


def _rounded(s: Series, error: Array) -> Series:
    step = np.sqrt(12.0) * rounding(s.data[0])
    if len(s.data) > 1 or step == 0.0 or s.whitener.root is not None:
        return s
    weight = s.whitener.weight[0]
    noise = 1.0 / (float(np.max(weight)) * step)  # where errors of the motion add least, in steps
    before = max(noise**2 - 1 / 12, 0.0)
    columns = []
    for k in range(1, HARMONICS + 1):
        size = step / (np.pi * k) * np.exp(-2 * (np.pi * k) ** 2 * before) / np.sqrt(2.0)
        turn = 2 * np.pi * k / step * (error[0] + s.data[0])
        pair = size * weight * np.stack([np.cos(turn), np.sin(turn)])
        columns += [x for x in pair if x @ x > MATTERS]
    if not columns:
        return s
    return replace(s, whitener=replace(s.whitener, root=Together.of(np.stack(columns, axis=1))))
