"""What is left over time beside a noise that is all there as it was stated: neighbours scatter by that, so
what else is left, slower, is another thing, although coloured noise would account for it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.hypotheses.refit import Fit, plain_white
from modelgen.diagnose.hypotheses.setting import COLOUR_TIME, Outcome, Setting
from modelgen.diagnose.noise.noise import scatter
from modelgen.fit.colour import autoregression, filtered
from modelgen.fit.series import Array

AS_STATED = 0.93, 1.08
"""Scatter between neighbours, over the noise, by which it is the one that was stated, and the same by the
upper half of the spectrum. Noise that has its colour within what was stated scatters far less."""
MORE = 1.04
"""Times the noise that is left, at least: so much may a statement be off."""
CLEAR = 40.0
"""ΔBIC of the colour, at the level that was stated."""
BEGINS = 0.1
"""Part of a record that its beginning may spoil: what a sample had been through shows there."""
SHORT = 200
"""Samples of a record that tells nothing of this."""
WINDOWS = 8
"""Parts of a record in which it is looked for where most is left."""


def not_stated(setting: Setting, outcome: Outcome) -> Leftover | None:
    """What is left beside the stated noise, if there is anything; None where none was stated, or where an
    effect is claimed."""
    stated = all(s.stated for s in setting.series) and not setting.averaged
    if not setting.model.is_time_model or not stated or outcome.best.ids:
        return None
    white = [e[:, int(BEGINS * e.shape[1]) :] for e in plain_white(outcome.best)]
    if min(e.shape[1] for e in white) < SHORT:
        return None
    level = [float(np.mean([scatter(s, x) for x in e])) for s, e in zip(setting.series, white, strict=True)]
    left = np.sqrt(np.sum([np.sum(e**2) for e in white]) / sum(map(np.count_nonzero, white)))
    if not AS_STATED[0] < np.median(level) < AS_STATED[1] or left < MORE:
        return None
    gain = _gain(white, level)
    if gain < CLEAR or not AS_STATED[0] < _fast(white) < AS_STATED[1]:
        return None
    return Leftover(gain, gain, _port(setting), _says(setting, outcome.best, white, level))


def _fast(white: Sequence[Array]) -> float:
    """Rms of residuals by the upper half of their spectrum: where anything slower shows, it is not there."""
    upper = []
    for e in white:
        window = np.hanning(e.shape[1])
        power = np.abs(np.fft.rfft(window * e, axis=1)) ** 2 / np.sum(window**2)
        upper.append(power[:, power.shape[1] // 2 :].ravel())
    return float(np.sqrt(np.mean(np.concatenate(upper))))


def _gain(white: Sequence[Array], level: Sequence[float]) -> float:
    """What colours of their own gain where independent noise has the `level` that neighbours show."""
    total = 0.0
    for e, s in zip(white, level, strict=True):
        a = autoregression(e, COLOUR_TIME)
        less = np.sum(e**2) - np.sum(filtered(a, e) ** 2)
        total += float(less / s**2 - (len(a) - 1) * np.log(e.size))
    return total


def _says(setting: Setting, best: Fit, white: Sequence[Array], level: Sequence[float]) -> str:
    """How much it is, in which recording most, when, and about which frequency."""
    from scipy.signal import periodogram  # half a second, which a diagnosis seldom needs

    size = [np.sqrt(max(np.mean(e**2) - s**2, 0.0)) for e, s in zip(white, level, strict=True)]
    k = int(np.argmax(size))
    s, e = setting.series[k], white[k]
    t = s.inputs[setting.model.axis][-e.shape[1] :]
    parts = np.array_split(np.arange(len(t)), WINDOWS)
    strong = [float(np.mean(e[:, part] ** 2)) for part in parts]
    at = parts[int(np.argmax(strong))]
    f, power = periodogram(e[:, at], 1 / float(np.median(np.diff(t))), window="hann")
    peak = f[1:][int(np.argmax(power.sum(axis=0)[1:]))]
    unit = next(i.unit for i in setting.model.inputs if i.name == setting.model.axis)
    return (
        "beside the noise that was stated, by which neighbours scatter, something slower is left, "
        f"{size[k]:.2g} times as large in '{s.name}', most from {t[at[0]]:.4g} to {t[at[-1]]:.4g} {unit}, "
        f"about {peak:.3g} {'Hz' if unit == 's' else f'1/{unit}'}"
    )


def _port(setting: Setting) -> str:
    names = [p.name for p in setting.model.ports if p.kind == "force"]
    return names[0] if len(names) == 1 else ""
