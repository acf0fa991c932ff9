"""Samples that no law explains: fits of sweeps follow or are bent by them, a misfit over time hides them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modelgen.diagnose.hypotheses.bounds import moving
from modelgen.diagnose.hypotheses.evidence import bic, effective
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import ALARM
from modelgen.diagnose.noise.noise import FITS, GROSS, outliers_of
from modelgen.fit.series import Array, Series
from modelgen.fit.whitener import Whitener
from modelgen.recordings.runs import runs

HIDDEN = 100.0
"""Squares of newly found outliers, over the noise, that are worth a second search."""
PART = 0.2
"""… over time at least this part of those of all others."""
ABOVE = 4.0
"""Times what leaving out any sample nearby would take away, that leaving out an outlier does."""
RIDGE = 1e-9
"""Added to what a sample's own weight leaves of its residual."""
BURST = 8
"""Samples that a burst of glitches has at most."""
EDGE = 30.0
"""Times its neighbours' greatest square that the least of its own is: no resonance ends so."""
ROUNDS = 15
"""Turns of the fit with heavy tails."""


def by_chance(along: Sequence[Array], marks: Sequence[Array]) -> list[Array]:
    """`marks` (n,) bool of sweeps over frequencies `along` without those runs that stand at one frequency in
    all of three sweeps or more: a glitch knows nothing of the others, a narrow resonance is in each."""
    if len(marks) < AGAIN:
        return list(marks)
    places = [np.sort(f[m]) for f, m in zip(along, marks, strict=True)]
    found = []
    for f, m in zip(along, marks, strict=True):
        kept = m.copy()
        for a, b in runs(m):
            low, high = f[max(a - 1, 0) : b + 1].min(), f[max(a - 1, 0) : b + 1].max()
            kept[a:b] = not all(np.any((low <= x) & (x <= high)) for x in places)
        found.append(kept)
    return found


AGAIN = 3
"""Sweeps in all of which lone samples do not stand at the same frequency by chance."""


def laid_open(base: Fit, best: Fit, bare: Sequence[Series], marks: Sequence[Array]) -> list[Array] | None:
    """Outliers of each recording, (n,) bool, as a law that fits shows them; None where none that matters is
    new, or the law leaves more than noise itself.

    So are lone samples that the base follows, as on the top of a narrow resonance, and all about them pay for
    it: if without them the base leaves noise alone, or if the best law does not explain them. bare: the
    recordings with their outliers.
    """
    e = replace(best.hypothesis.experiment, series=tuple(bare))
    pulled, still = _gains_without(base), _gains_without(best)
    lone = [_stands_out(x) for x in pulled]
    taken = sum(float(x[m].sum()) for x, m in zip(pulled, lone, strict=True))
    alone = taken > 0 and base.chi2 - taken < FITS**2 * effective(base.white)
    found, weight = [], 0.0
    for k, (s, known) in enumerate(zip(bare, marks, strict=True)):
        pulls = lone[k] & (alone | (still[k] > HIDDEN))
        white = s.whitener.apply(e.raw(best.theta, k))
        found.append(outliers_of(e, best.theta, k) | abrupt(np.sum(white**2, axis=0)) | pulls)
        if not alone and np.mean(white[:, ~found[-1]] ** 2) > FITS**2:
            return None
        weight += float(np.sum(white[:, found[-1] & ~known] ** 2) + np.sum(pulled[k][pulls]))
    return found if weight > HIDDEN else None


def uncovered(best: Fit, bare: Sequence[Series], marks: Sequence[Array]) -> list[Array] | None:
    """Outliers of each record over time, (n,) bool, as the best law shows them; None where few are new beside
    those that were known, `marks`, or the law leaves more than noise. bare: the records with outliers."""
    e = replace(best.hypothesis.experiment, series=tuple(bare))
    found, new, left = [outliers_of(e, best.theta, k) for k in range(len(bare))], 0.0, 0.0
    for k, (s, now, known) in enumerate(zip(bare, found, marks, strict=True)):
        square = np.sum(s.whitener.apply(e.raw(best.theta, k)) ** 2, axis=0)
        if np.mean(square[~now]) > FITS**2 * len(s.data):
            return None
        new += float(np.sum(square[now & ~known]))
        left += float(np.sum(square[~now]))
    return found if new > max(HIDDEN, PART * left) else None


def unexplained(best: Fit, bare: Sequence[Series], marks: Sequence[Array]) -> tuple[Array, ...]:
    """`marks` without samples that the best law explains: they stood alone in what the base missed. bare: the
    records with outliers."""
    e, found = replace(best.hypothesis.experiment, series=tuple(bare)), []
    for k, (s, m) in enumerate(zip(bare, marks, strict=True)):
        square = np.mean(s.whitener.apply(e.raw(best.theta, k)) ** 2, axis=0)
        found.append(m & (square > ORDINARY**2))
    return tuple(found)


ORDINARY = 4.0
"""Times the noise that a sample is off at most which needs no other account."""


def rather(judge: Judge, best: Fit, without: Fit) -> bool:
    """Whether what was found first is by far the better account of all samples, those too that were taken out
    for the one found `without` them: each counts no more than an outlier does, as a narrow resonance may have
    a few."""

    def evidence(f: Fit) -> float:
        white = f.hypothesis.experiment.whitened(f.theta, judge.whiteners)
        own = ALARM * len(f.ids)
        return own + bic(white, judge.prior, f.parameters, robust=True, temper=judge.temper)

    return evidence(best) < evidence(without) - ALARM


def _stands_out(gain: Array) -> Array:
    """(n,) bool: samples without which a fit would gain far more than without any of three on either side."""
    near = np.lib.stride_tricks.sliding_window_view(np.pad(gain, 3, mode="reflect"), 7).copy()
    near[:, 3] = 0.0
    return (gain > HIDDEN) & (gain > ABOVE * near.max(axis=1))


def _gains_without(f: Fit) -> list[Array]:
    """(n,) of each recording: the squares that a fit would be rid of without each of its samples.

    rᵀ(I − H)⁻¹r with H its block of the hat matrix (R. D. Cook, S. Weisberg, Residuals and Influence in
    Regression (1982), ch. 2): where a fit follows an outlier, its residual is small.
    """
    e = f.hypothesis.experiment
    r, J = e.linearised(f.theta, [replace(s.whitener, root=None, ar=None) for s in e.series])
    J = J[:, moving(e.layout, f.theta)]
    q = np.linalg.qr(J / np.maximum(np.linalg.norm(J, axis=0), 1e-300))[0]
    r = r - q @ (q.T @ r)
    found, at = [], 0
    for s in e.series:
        end = at + s.data.size
        mine, hat = r[at:end].reshape(s.data.shape), q[at:end].reshape(*s.data.shape, -1)
        rest = (1 + RIDGE) * np.eye(len(mine)) - np.einsum("cnp,dnp->ncd", hat, hat)
        found.append(np.einsum("cn,nc->n", mine, np.linalg.solve(rest, mine.T[..., None])[..., 0]))
        at = end
    return found


def bursts(judge: Judge, base: Fit) -> list[Array]:
    """(n,) bool of each recording: runs of samples that begin and end abruptly, against a base that is fitted
    as if errors had a Cauchy distribution, t of one degree of freedom (K. L. Lange, R. J. A. Little, J. M. G.
    Taylor, J. Am. Stat. Assoc. 84 (1989) 881): least squares would be bent to them."""
    if base.chi2 < FITS**2 * effective(base.white):
        return [np.zeros(e.shape[1], dtype=bool) for e in base.white]
    h, theta = base.hypothesis, base.theta
    plain = [_evened(replace(w, root=None, ar=None)) for w in judge.whiteners]
    squares = [np.sum(e**2, axis=0) for e in h.experiment.whitened(theta, plain)]
    for _ in range(ROUNDS):
        share = [(1 + x / max(float(np.median(x)), 1e-300)) ** -0.5 for x in squares]
        eased = replace(judge, whiteners=tuple(w.masked(x) for w, x in zip(plain, share, strict=True)))
        theta = eased.fit(h, [theta]).theta
        white = h.experiment.whitened(theta, plain)
        squares = [np.sum(e**2, axis=0) for e in white]
    return [abrupt(x) for x in squares]


def _evened(w: Whitener) -> Whitener:
    """`w` by which no few samples weigh far more than those about them: noise that is relative is small where
    a glitch made the value small."""
    from scipy.ndimage import median_filter

    weight = np.abs(np.atleast_2d(w.weight)[0])
    around = HEAVY * median_filter(weight, 4 * BURST + 1)
    return w.masked(np.minimum(1.0, around / np.maximum(weight, 1e-300)))


HEAVY = 3.0
"""Times the weight of those about it that a sample has at most."""


def abrupt(square: Array) -> Array:
    """(n,) bool: runs of at most BURST samples whose squares tower above three on either side, and all."""
    far = square > GROSS**2 * max(float(np.median(square)), 1e-300)
    found = np.zeros(len(square), dtype=bool)
    for a, b in runs(far):
        beside = np.concatenate([square[max(a - 3, 0) : a], square[b : b + 3]])
        found[a:b] = b - a <= BURST and square[a:b].min() > EDGE * beside.max(initial=0.0)
    return found
