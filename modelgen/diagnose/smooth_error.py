"""A smooth relative error of an instrument that nobody stated: a Gaussian process over ln f in sweeps' noise.

It is what a residual is compared with before physics is claimed: marginal likelihood with the process' size
and length maximised (C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning (2006),
ch. 5), the fit's own parameters free beside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modelgen.diagnose.evidence import Smooth
from modelgen.diagnose.refit import Fit, Judge
from modelgen.fit.series import Array, Whitener

LENGTHS = (0.15, 0.3, 0.6, 1.2)
"""Correlation lengths in ln f that are tried."""
SIZES = (0.35, 0.7, 1.4, 2.8, 5.6)
"""Sizes in standard deviations of the independent noise."""
RARE = 4.0
"""−2 ln of the prior of an error, by its size."""
SURE = 20.0
"""ΔBIC that the process must gain to be taken into the noise: forty of them are tried."""


def smooth_error(judge: Judge, fit: Fit) -> tuple[float, float, Smooth | None]:
    """(BIC with white noise, what the best process gains, that process) of sweeps; none where one is stated.

    White or not, the fit's parameters follow at first order. Errors of many times the noise are rare.
    """
    e = fit.hypothesis.experiment
    plain = tuple(
        replace(w, root=s.whitener.root, ar=None, band=None, undo=None)
        for s, w in zip(e.series, judge.whiteners, strict=True)
    )
    r, J = e.linearised(fit.theta, plain)
    lnf = [np.log(s.inputs[e.model.axis]) for s in e.series]
    channels = [len(s.data) for s in e.series]
    size = np.concatenate(
        [np.tile(_relative(s.size, w), c) for s, w, c in zip(e.series, plain, channels, strict=True)]
    )
    used = size > 0
    n = int(np.count_nonzero(used))
    q, _ = np.linalg.qr(np.where(used[:, None], J, 0.0) / np.maximum(np.linalg.norm(J, axis=0), 1e-300))
    left = float(np.sum((r - q @ (q.T @ r)) ** 2))
    none = n * float(np.log(left / n))
    white = none + fit.parameters * float(np.log(n)) - 2 * fit.hypothesis.log_common
    if any(s.measure == "real" or s.whitener.root is not None for s in e.series):
        return white, 0.0, None
    gained, found = 0.0, None  # type: tuple[float, Smooth | None]
    for shared in (False, True) if len(lnf) > 1 else (False,):
        for length in LENGTHS:
            B = size[:, None] * _modes(lnf, channels, length, shared)
            for rms, d in _deviances(r, q, B, n):
                gain = none - d - 2 * float(np.log(n)) - RARE * rms
                if gain > max(gained, SURE):
                    gained, found = gain, Smooth(rms, length, shared)
    return white, gained, found


def _relative(size: Array, w: Whitener) -> Array:
    """(n,) the output over its noise, by its median: 1 for a noise relative to |Z|; 0 where masked."""
    x = np.abs(size) * np.abs(w.weight[0] if w.weight.ndim == 2 else w.weight)
    return np.asarray(x / np.median(x[x > 0]))


def _modes(lnf: Sequence[Array], channels: Sequence[int], length: float, shared: bool) -> Array:
    """(N, k) factor of the process' correlation: interpolated from knots a third of its length apart."""
    low, high = min(x.min() for x in lnf), max(x.max() for x in lnf)
    knots = np.linspace(low, high, int(np.ceil(3 * (high - low) / length)) + 2)
    K = np.exp(-0.5 * ((knots[:, None] - knots[None, :]) / length) ** 2)
    values, vectors = np.linalg.eigh(K)
    keep = values > 1e-6 * values[-1]
    root = vectors[:, keep] * np.sqrt(values[keep])
    blocks = [np.stack([np.interp(x, knots, c) for c in root.T], axis=1) for x in lnf]
    k = root.shape[1]
    own = [(m, c) for m, count in enumerate(channels) for c in range(count)]
    groups = sorted({c if shared else (m, c) for m, c in own}, key=str)
    out = []
    for m, c in own:
        row = np.zeros((len(lnf[m]), k * len(groups)))
        at = groups.index(c if shared else (m, c)) * k
        row[:, at : at + k] = blocks[m]
        out.append(row)
    return np.concatenate(out)


def _deviances(r: Array, q: Array, B: Array, n: int) -> list[tuple[float, float]]:
    """(rms, −2 ln of the profile likelihood) of r ~ N(0, σ² (1 + rms² B Bᵀ)), free amounts of q's columns
    beside."""
    u, s, _ = np.linalg.svd(B, full_matrices=False)
    keep = s > 1e-4 * s[0]
    u, s = u[:, keep], s[keep]
    a = u.T @ np.column_stack([r, q])
    rr, qr, qq = r @ r, q.T @ r, q.T @ q
    out = []
    for rms in SIZES:
        w = (rms * s) ** 2
        down = (w / (1 + w))[:, None] * a
        xr, Q = qr - a[:, 1:].T @ down[:, 0], qq - a[:, 1:].T @ down[:, 1:]
        left = rr - a[:, 0] @ down[:, 0] - xr @ np.linalg.lstsq(Q, xr, rcond=1e-10)[0]
        out.append((rms, n * float(np.log(max(left, 1e-12) / n)) + float(np.sum(np.log1p(w)))))
    return out


def with_smooth(whiteners: Sequence[Whitener], lnf: Sequence[Array], found: Smooth) -> tuple[Whitener, ...]:
    """Whiteners that count the process as noise.

    A shared error is √m as large in each of m sweeps, so that their mean is as uncertain."""
    rms = found.rms * (np.sqrt(len(whiteners)) if found.shared else 1.0)
    out = []
    for w, x in zip(whiteners, lnf, strict=True):
        K = np.eye(len(x)) + rms**2 * np.exp(-0.5 * ((x[:, None] - x[None, :]) / found.length) ** 2)
        out.append(replace(w, ar=None, band=None, undo=None, root=np.linalg.inv(np.linalg.cholesky(K))))
    return tuple(out)
