"""A line in the spectrum of what a fit over time leaves: something that does not follow the motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from modelgen.diagnose.gate.channels import port_at, shown
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.gate.spectrum import filled, highest, share_of, standing_out, step, tuned
from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.functions import LINE
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.noise.noise import scatter
from modelgen.fit.series import Array
from modelgen.language import Model


def _follows(model: Model, fit: Fit, grid: Array, width: float) -> Array:
    """Frequencies of `grid` at which the motion itself, or a harmonic of it, has power: what happens there
    follows it. Where no motion is recorded, what drives it stands for it."""
    moved = {i.derived[1] for i in model.inputs if i.derived and i.derived[0] == "rate"}
    moved = moved or {i.name for i in model.inputs if not i.derived and i.name != model.axis}
    near = np.zeros(len(grid), dtype=bool)
    for s, name in ((s, name) for s in fit.hypothesis.experiment.series for name in sorted(moved)):
        t, z = s.inputs[model.axis], s.inputs[name]
        even = filled(t, z - z.mean())
        power = np.abs(np.fft.rfft(even * np.hanning(len(even)))) ** 2
        if not power.max() > 0:  # a free decay: nothing drives it
            continue
        f = np.arange(len(power)) / step(t) / len(even)
        strong = f[power > 1e-3 * power.max()]
        for order in range(1, 10):
            near |= (
                (grid > order * strong.min() - 2 * width) & (grid < order * strong.max() + 2 * width)
                if order == 1
                else _close(grid, order * f[np.argmax(power)], 3 * width)
            )
    return near


def _close(grid: Array, f: float, width: float) -> Array:
    return np.asarray(np.abs(grid - f) < width)


FAR, WHOLE = 2.0, 0.3
"""Where a fit leaves FAR times the noise, a line is no account of it unless it holds this share of its
power."""


def _far(fit: Fit) -> bool:
    pairs = zip(fit.hypothesis.experiment.series, fit.white, strict=True)
    rough = np.mean([scatter(s, x) ** 2 for s, e in pairs for x in e])
    return float(np.mean([np.mean(e**2) for e in fit.white])) > FAR**2 * max(1.0, float(rough))


LOWEST = 5
"""Harmonics that a line may be of a stronger wave."""


def line(model: Model, fit: Fit, n: int) -> Leftover:
    """The strongest spectral line of the residual, over the spectrum around it, all recordings together; or
    lines of other frequencies in each, as the mains have them where a sampling folds them down.

    The price is that of having looked at every frequency.
    """
    long = [(s, e) for s, e in zip(fit.hypothesis.experiment.series, fit.white, strict=True) if s.n >= 200]
    outputs = [n for s, _ in long for n in shown(model, s)]
    named = [(s.name, s.inputs[model.axis], x) for s, e in long for x in e]
    none = Leftover(0.0, 0.0, "sensor", "")
    if not named:
        return none
    series = [(t, x) for _, t, x in named]
    span = max(float(t[-1] - t[0]) for t, _ in series)
    top = max(highest(t) for t, _ in series)
    grid = np.arange(4.0 / span, 0.98 * top, 0.5 / span)
    if not len(grid):
        return none
    each = np.stack([standing_out(t, x, grid) for t, x in series])
    each[:, _follows(model, fit, grid, 1.0 / span)] = 0.0
    common = grid < 0.98 * min(highest(t) for t, _ in series)
    total = each.sum(axis=0) * common
    k = int(np.argmax(total))
    looked = 2 * float(np.log(len(grid)))
    gain = 2 * float(total[k]) - (2 * len(series) + 1) * float(np.log(n)) - looked
    apart = 2 * each.max(axis=1) - 3 * float(np.log(n)) - looked - 2 * float(np.log(len(series)))
    if float(np.sum(apart[apart > 0])) > max(gain, 0.0) and not _far(fit):
        found = [
            tuned([x], float(f), 0.5 / span) for x, f in zip(series, grid[each.argmax(axis=1)], strict=True)
        ]
        port = _port(model, outputs[int(np.argmax(apart))])
        return _apart([name for name, *_ in named], found, apart, port)
    # a slope that is taken out makes harmonics stand out more than the wave that they belong to
    waves = [float(grid[k]) / m for m in range(1, LOWEST + 1)]
    waves = [f for f in waves if f == waves[0] or total[int(np.argmin(np.abs(grid - f)))] > 0]
    f = tuned(series, max(waves, key=lambda f: share_of(series, f)), 0.5 / span)
    if _far(fit) and share_of(series, f) < WHOLE:
        return none
    says = f"a line at {f:.4g} Hz that does not follow the motion"
    port = _port(model, outputs[int(np.argmax(each[:, k]))])
    return Leftover(gain, 2 * float(total[k]), port, says, (LINE, f), line=f)


def _port(model: Model, output: str) -> str:
    """The sensor with which an output was recorded."""
    return port_at(model, output, "sensor") or "sensor"


def _apart(names: Sequence[str], f: Sequence[float], gains: Array, port: str) -> Leftover:
    """Lines of other frequencies `f` in the recordings in which they gain something."""
    where = [f"{x:.4g} Hz in {name}" for name, x, g in zip(names, f, gains, strict=True) if g > 0]
    lines = "a line" if len(where) == 1 else "lines"
    says = f"{lines} at {', '.join(where)}, not following the motion"
    gain, strongest = float(np.sum(gains[gains > 0])), f[int(np.argmax(gains))]
    return Leftover(gain, gain, port, says, (LINE, strongest), line=strongest)


def gained_beside(judge: Judge, base: Fit, best: Fit, f: float) -> float:
    """What `best` gains on `base` in BIC once both may have a wave of the frequency `f` in each recording."""
    left = [float(sum(np.sum(e**2) for e in _without(judge, fit, f))) for fit in (base, best)]
    n = effective(best.white)
    return n * float(np.log(left[0] / left[1])) - (best.parameters - base.parameters) * float(np.log(n))


WIDE = 6
"""Waves about a line, as a tone that wanders has them."""


def _without(judge: Judge, fit: Fit, f: float) -> list[Array]:
    """Whitened residuals of a fit less what waves of the frequency `f` can take of them."""
    e = fit.hypothesis.experiment
    found = []
    for s, w, r in zip(e.series, judge.whiteners, fit.white, strict=True):
        t = s.inputs[e.model.axis]
        near = 2 * np.pi * (f + np.arange(-WIDE, WIDE + 1) / 2 / float(t[-1] - t[0]))
        waves = np.concatenate([np.cos(np.outer(near, t)), np.sin(np.outer(near, t))])
        columns = np.stack([w.apply(np.broadcast_to(x, s.data.shape))[0] for x in waves], axis=1)
        q = np.linalg.qr(columns)[0]
        found.append(r[0] - q @ (q.T @ r[0]))
    return found
