"""Errors that are no accidents: a sensor that saturates, and the mains in a sweep."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from modelgen.diagnose.gate.leftover import Leftover
from modelgen.fit.scatter import local_scatter
from modelgen.fit.series import Array, Series

MAINS = (50.0, 60.0)
ORDERS = (1, 2, 3, 5, 7)
"""Harmonics in which the mains are strong."""
HITS = 3
"""Lines, over all sweeps, that make the mains."""
LOUD = 25.0
"""|e|² of a whitened sample that is 5 standard deviations off."""
FEW = 4
"""Outliers at the top of a record that make a plateau."""
NOISE = 1.5
"""Standard deviations of the noise that values of a plateau have at most: more is no single value."""
MANY, DENSE = 12, 4.0
"""Samples that make a plateau without any outlier, and how many times those in the band below it."""
TOP = 0.01
"""Share of a record that is its top."""
BESIDE = 3
"""Samples before and after a plateau that weigh nothing either: of these it was chosen by their noise."""
STILL = 0.9
"""A record that stays at one value for more than this share of its samples rests there."""


def saturation(
    series: Sequence[Series], white: Sequence[Array], marks: Sequence[Array]
) -> tuple[Leftover | None, list[Array]]:
    """A plateau at an end of a record, which the model has not; and the samples on it, and on others like it
    in all records. marks: what stands off its neighbours."""
    says, gain = "", 0.0
    on = [np.zeros(s.n, dtype=bool) for s in series]
    for k, (s, e, m) in enumerate(zip(series, white, marks, strict=True)):
        for side in (1.0, -1.0):
            end = _plateau(s, e[0], side)
            end = _cut(s, e[0], m, side) if end is None else end
            if end is None or len(end) > STILL * s.n:
                continue
            level = float(np.median(s.data[0][end]))
            says = says or (
                f"the record ends at {level:.4g} {s.unit}: its sensor saturates or the part lifts off"
            )
            gain += float(np.sum(e[0][end] ** 2))
            spoilt = np.zeros(s.n, dtype=bool)
            spoilt[end] = True
            on[k] |= np.convolve(spoilt, np.ones(2 * BESIDE + 1), "same") > 0
    return (Leftover(gain, gain, "force", says) if says else None), on


def _cut(s: Series, e: Array, marks: Array, side: float) -> Array | None:
    """Outliers of one sign at one end of a record, all at one value, which the model exceeds."""
    at, x = np.flatnonzero(marks), s.data[0]
    end = at[side * x[at] >= np.quantile(side * x, 1 - TOP)]
    end = np.intersect1d(end, np.flatnonzero(side * e > 0))  # e = model − data over noise
    if len(end) < FEW:
        return None
    share = np.ones(len(x)) if s.whitener.share is None else np.maximum(s.whitener.share, 1e-6)
    spread = float(np.std(x[end])) * float(np.mean(np.abs(s.whitener.weight[0] / share)[end]))
    beyond = np.count_nonzero(side * x > np.max(side * x[end]))
    high = np.sqrt(LOUD) < 0.7 * float(np.max(side * (e / share)[end]))
    return end if spread < NOISE and beyond < len(end) and high else None


def _plateau(s: Series, e: Array, side: float) -> Array | None:
    """Many samples at the end of a record and few before it, where the model goes on.

    A smooth top has in the band below it 0.4 times as many as in the last one.
    """
    x = side * s.data[0]
    sigma = local_scatter(s.data[0])
    steps = np.diff(np.unique(x))
    band = max(6 * sigma, 3 * float(np.min(steps, initial=np.inf)) if steps.size else 0.0)
    middle = np.median(np.lib.stride_tricks.sliding_window_view(np.pad(x, 3, mode="reflect"), 7), axis=1)
    under = middle.max() - x  # of single spikes the top knows nothing
    end = np.flatnonzero(np.abs(under) < band)
    below = np.count_nonzero(np.abs(under - 1.5 * band) <= 0.5 * band)
    model = side * e[end] / np.maximum(np.abs(s.whitener.weight[0][end]), 1e-300) + x[end]
    unsure = float(np.median(1 / np.maximum(np.abs(s.whitener.weight[0][end]), 1e-300))) if end.size else 0.0
    goes_on = float(np.std(model)) > 5 * max(
        float(np.std(x[end])), sigma, unsure
    )  # its motion may be in error
    beyond = int(np.count_nonzero(under < -band))
    return end if len(end) >= max(MANY, beyond) and len(end) > DENSE * below and goes_on else None


def mains(f: Sequence[Array], white: Sequence[Array], port: str) -> tuple[Leftover | None, list[Array]]:
    """A line at a multiple of 50 or 60 Hz that sweeps have in common, or several in one; and its samples,
    with those at the first, where a resonance may hide it.

    f: (n,) frequencies of each sweep; white: (channels, n) whitened residuals. Single outliers fall on a
    harmonic now and then, HITS of them, two on the same one, hardly ever; of many that lie anywhere, some do.
    """
    for base in MAINS:
        found = [_on_lines(x, e, base) for x, e in zip(f, white, strict=True)]
        hits: Array = np.array([[n in lines for n in ORDERS] for lines in found])
        if hits.sum() < HITS or (len(f) > 1 and hits.sum(axis=0).max() < 2):
            continue
        if _chance(f, white, base) > ALIKE:
            continue
        marks = [
            np.any([np.abs(x - base) < base / 8, *lines.values()], axis=0)  # the first is strongest
            for x, lines in zip(f, found, strict=True)
        ]
        size = float(sum(np.sum(e[:, m] ** 2) for e, m in zip(white, marks, strict=True)))
        where = ", ".join(f"{base * n:.0f}" for k, n in enumerate(ORDERS) if hits[:, k].any())
        says = f"lines at {where} Hz and nothing beside them: mains of {base:.0f} Hz, picked up on the way"
        return Leftover(size, size, port, says), marks
    return None, [np.zeros(len(x), dtype=bool) for x in f]


def _on_lines(f: Array, e: Array, base: float) -> dict[int, Array]:
    """Orders of `base` on which a sweep is loud, and quiet beside; with the samples that each spoils, (n,)
    bool."""
    p = _over_quiet(e)
    found = {}
    for n in ORDERS:
        away = np.abs(f - n * base)
        nearest = np.argsort(away)[:3]
        beside = (away > base / 5) & (away < base / 2)
        loud = np.max(p[nearest]) > LOUD and away[nearest[0]] < base / 8
        if loud and not (beside.any() and np.median(p[beside]) > 4):
            found[n] = away < max(base / 8, 1.01 * away[nearest[0]])
    return found


def _over_quiet(e: Array) -> Array:
    """|e|² (n,) of residuals (channels, n), over what it is of most: noise has the median of a χ² of as many
    degrees as there are channels."""
    from scipy.special import gammaincinv

    power = np.sum(e**2, axis=0)
    return np.asarray(power / (float(np.median(power)) / (2 * gammaincinv(len(e) / 2, 0.5)) or 1.0))


ALIKE = 1e-4
"""Probability by chance above which loud samples on the lines are like the other loud ones."""


def _chance(f: Sequence[Array], white: Sequence[Array], base: float) -> float:
    """How likely so many of the loud samples are on lines of `base` if they may lie anywhere."""
    from scipy.special import bdtrc

    loud = np.concatenate([_over_quiet(e) > LOUD for e in white])
    lines = np.concatenate([_beside_lines(x, base) for x in f])
    return float(bdtrc(np.sum(loud & lines) - 1, np.sum(loud), np.mean(lines)))


def _beside_lines(f: Array, base: float) -> Array:
    """(n,) bool: the samples nearest to a line."""
    found = np.zeros(len(f), dtype=bool)
    for n in ORDERS:
        nearest = np.argsort(np.abs(f - n * base))[:3]
        if np.abs(f[nearest[0]] - n * base) < base / 8:
            found[nearest] = True
    return found
