"""A smooth relative error of an instrument that nobody stated: a Gaussian process over ln f in sweeps' noise.

It is what a residual is compared with before physics is claimed: marginal likelihood with the process' size
and length maximised (C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning (2006),
ch. 5), the fit's own parameters free beside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from modelgen.diagnose.hypotheses.evidence import Smooth
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.fit.series import Array, Series
from modelgen.fit.together import Together, smooth_modes
from modelgen.fit.whitener import Whitener

LENGTHS = (0.15, 0.3, 0.6, 1.2, 2.4)
"""Correlation lengths in ln f that are tried."""
SIZES = (0.35, 0.7, 1.4, 2.8, 5.6)
"""Sizes in standard deviations of the independent noise."""
RARE = 4.0
"""−2 ln of the prior of an error, by its size."""
SURE = 20.0
"""ΔBIC that the process must gain to be taken into the noise: for one sweep 25 are tried, for several 50."""


def smooth_error(
    judge: Judge, fit: Fit, beside: Sequence[Array] = (), sizes: Sequence[float] = ()
) -> tuple[float, float, Smooth | None]:
    """(BIC with white noise, what the best process gains, that process) of sweeps; none where one is stated.

    White or not, the fit's parameters follow at first order, as do amounts of the changes `beside` it
    (channels, k, n) of each sweep, of which there are none. Errors of many times the noise are rare. sizes:
    how large it is in each sweep; alike if not given, as an instrument's is.
    """
    e = fit.hypothesis.experiment
    plain = tuple(
        replace(w, root=s.whitener.root, ar=None, band=None, undo=None)
        for s, w in zip(e.series, judge.whiteners, strict=True)
    )
    r, J = e.linearised(fit.theta, plain)
    if beside:
        white_of = (w.apply(x).transpose(0, 2, 1) for w, x in zip(plain, beside, strict=True))
        J = np.column_stack([J, np.concatenate([x.reshape(-1, x.shape[2]) for x in white_of])])
    channels = [len(s.data) for s in e.series]
    over = [q * x for q, x in zip(quietness(e.series, plain), sizes or [1.0] * len(channels), strict=True)]
    size = np.concatenate(
        [
            np.tile(q * _relative(s.size, w), c)
            for s, w, c, q in zip(e.series, plain, channels, over, strict=True)
        ]
    )
    used = size > 0
    n = int(np.count_nonzero(used))
    q, _ = np.linalg.qr(np.where(used[:, None], J, 0.0) / np.maximum(np.linalg.norm(J, axis=0), 1e-300))
    left = float(np.sum((r - q @ (q.T @ r)) ** 2))
    none = n * float(np.log(left / n))
    white = none + fit.parameters * float(np.log(n)) - 2 * fit.hypothesis.log_common
    if any(s.measure == "real" or s.whitener.root is not None for s in e.series):
        return white, 0.0, None
    lnf = [np.log(s.inputs[e.model.axis]) for s in e.series]  # of sweeps alone: other axes pass through zero
    gained, found = 0.0, None  # type: tuple[float, Smooth | None]
    sweeps = [len(x) for x in lnf]
    for length in LENGTHS:
        modes = smooth_modes(lnf, length)
        for shared in (False, True) if len(lnf) > 1 else (False,):
            seen = _seen(modes, _groups(sweeps, channels, shared), size, np.column_stack([r, q]))
            for rms, d in _deviances(r, q, *seen, n):
                gain = none - d - 2 * float(np.log(n)) - RARE * rms
                if gain > max(gained, SURE):
                    gained, found = gain, Smooth(rms, length, shared)
    return white, gained, found


def quietness(series: Sequence[Series], whiteners: Sequence[Whitener]) -> list[float]:
    """By how much the independent noise of each sweep is less than that of the noisiest, relative to what is
    measured: an error of the instrument is none the smaller where many readings are averaged."""
    over = map(_over_noise, (s.size for s in series), whiteners)
    median = [float(np.median(x[x > 0])) if np.any(x > 0) else np.inf for x in over]
    return [x / min(median) if np.isfinite(x) else 1.0 for x in median]


def part_of_reading(series: Sequence[Series], found: Smooth) -> float:
    """How large an error is beside what is measured: its standard deviation over |output|."""
    over = [_over_noise(s.size, s.whitener) for s in series]
    return found.rms / min(float(np.median(x[x > 0])) for x in over if np.any(x > 0))


def _over_noise(size: Array, w: Whitener) -> Array:
    """(n,) |output| over its noise; 0 where masked."""
    return np.abs(size) * np.abs(w.weight[0] if w.weight.ndim == 2 else w.weight)


def _relative(size: Array, w: Whitener) -> Array:
    """(n,) the output over its noise, by its median: 1 for a noise relative to |Z|; 0 where masked."""
    x = _over_noise(size, w)
    return np.asarray(x / np.median(x[x > 0]))


def _groups(sizes: Sequence[int], channels: Sequence[int], shared: bool) -> list[list[tuple[int, slice]]]:
    """(sweep, rows of the residual) that one and the same error spoils, for each error: a channel of a sweep,
    or of all."""
    groups: dict[tuple[int, int], list[tuple[int, slice]]] = {}
    row = 0
    for m, (n, count) in enumerate(zip(sizes, channels, strict=True)):
        for c in range(count):
            groups.setdefault((0 if shared else m, c), []).append((m, slice(row, row + n)))
            row += n
    return list(groups.values())


def _seen(
    modes: Sequence[Array], groups: Sequence[Sequence[tuple[int, slice]]], size: Array, columns: Array
) -> tuple[Array, Array]:
    """(squared singular values of all modes, `columns` (N, p) in their directions): a few modes of each
    error, so their Gram matrix is the quick way there."""
    squares, parts = [], []
    for group in groups:
        B = np.concatenate([size[rows, None] * modes[m] for m, rows in group])
        a = np.concatenate([columns[rows] for _, rows in group])
        values, vectors = np.linalg.eigh(B.T @ B)
        keep = values > 1e-8 * values[-1]
        squares.append(values[keep])
        parts.append(vectors[:, keep].T @ (B.T @ a) / np.sqrt(values[keep])[:, None])
    return np.concatenate(squares), np.concatenate(parts)


def _deviances(r: Array, q: Array, square: Array, a: Array, n: int) -> list[tuple[float, float]]:
    """(rms, −2 ln of the profile likelihood) of r ~ N(0, σ² (1 + rms² B Bᵀ)), free amounts of q's columns
    beside; `square`, `a`: B's singular values squared, and r and q in its directions."""
    rr, qr, qq = r @ r, q.T @ r, q.T @ q
    out = []
    for rms in SIZES:
        w = rms**2 * square
        down = (w / (1 + w))[:, None] * a
        xr, Q = qr - a[:, 1:].T @ down[:, 0], qq - a[:, 1:].T @ down[:, 1:]
        left = float(rr - a[:, 0] @ down[:, 0] - xr @ np.linalg.lstsq(Q, xr, rcond=1e-10)[0])
        out.append((rms, n * float(np.log(max(left, 1e-12) / n)) + float(np.sum(np.log1p(w)))))
    return out


def with_smooth(
    whiteners: Sequence[Whitener], lnf: Sequence[Array], found: Smooth, over: Sequence[float] = ()
) -> tuple[Whitener, ...]:
    """Whiteners that count the process as noise; over: `quietness` of the sweeps, 1 if not given.

    A shared error is √m as large in each of m sweeps, so that their mean is as uncertain."""
    rms = found.rms * (np.sqrt(len(whiteners)) if found.shared else 1.0)
    alike = _unit(tuple(x.tobytes() for x in lnf), found.length)
    roots = [
        (one if w.share is None else one.weighed(w.share)).scaled(q * rms)
        for w, one, q in zip(whiteners, alike, over or [1.0] * len(whiteners), strict=True)
    ]
    return tuple(
        replace(w, ar=None, band=None, undo=None, root=r) for w, r in zip(whiteners, roots, strict=True)
    )


@lru_cache(maxsize=8)
def _unit(lnf: tuple[bytes, ...], length: float) -> list[Together]:
    """A process of size 1 in each sweep; plans of a further one ask for the same again and again."""
    return [Together.of(modes) for modes in smooth_modes([np.frombuffer(x) for x in lnf], length)]
