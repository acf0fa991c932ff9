"""The colour of the noise in recordings of one instrument: over time, what one recording shows to be white is
white in the others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from modelgen.diagnose.hypotheses.setting import Setting
from modelgen.fit.colour import coloured, filtered
from modelgen.fit.scatter import rounding
from modelgen.fit.series import Array, Series
from modelgen.fit.whitener import Whitener

AS_FAST = 1.05
"""Sampling intervals up to this many times another tell as much of what changes from sample to sample."""
REJECTED = 10.0
"""Log-likelihood by which a recording is rather white than of another's colour."""
SMEARED = 0.01
"""Share of samples with errors of the motion, or of rounding's part in the noise' variance, up to which a
recording's colour is the instrument's."""


def colours(
    s: Setting, plain: Sequence[Whitener], white: Sequence[Array]
) -> tuple[tuple[Whitener, ...], tuple[bool, ...]]:
    """Whiteners with the colour of the residuals `white` that `plain` left, and which recordings have one
    that is no noise's.

    Over time a recording has none where another, sampled as fast, is white and rejects it: the noise of one
    instrument is the same in both, so what is coloured is what the model misses. In sweeps an instrument
    errs as a function of the frequency, and each may hold others.
    """
    filters = coloured(plain, white, s.colour, s.model.is_time_model)
    if not s.model.is_time_model:
        return filters, (False,) * len(filters)
    step = [float(np.median(np.diff(x.inputs[s.model.axis]))) for x in s.series]

    def elsewhere(k: int, w: Whitener) -> bool:
        return any(
            v.order == 0 and step[j] <= AS_FAST * step[k] and _rejects(white[j], w)
            for j, v in enumerate(filters)
        )

    missed = tuple(
        w.order > 0 and _instruments(s.series[k], w) and elsewhere(k, w) for k, w in enumerate(filters)
    )
    return tuple(v if m else w for v, w, m in zip(plain, filters, missed, strict=True)), missed


def _rejects(white: Array, w: Whitener) -> bool:
    """Whether a residual (channels, n) is far likelier white than of the colour of `w`."""
    if w.ar is None or white.shape[1] < 2 * len(w.ar):
        return False
    plain = white[:, len(w.ar) - 1 :]
    left = filtered(w.ar, white)[:, len(w.ar) - 1 :]
    ratio = float(np.sum(left**2)) / max(float(np.sum(plain**2)), 1e-300)
    return plain.size / 2 * float(np.log(max(ratio, 1e-300))) > REJECTED


def _instruments(x: Series, w: Whitener) -> bool:
    """Whether a recording's colour may be neither that of its motion's errors nor of treads it stays on."""
    if w.share is not None and np.mean(w.share[w.share > 0] < 0.95) > SMEARED:
        return False
    treads = [
        (rounding(y) * float(np.median(v))) ** 2 for y, v in zip(x.data, x.whitener.weight, strict=True)
    ]
    return max(treads) < SMEARED
