"""Banded covariances of noise along the samples: of smoothed errors of the motion, a colour beside them.

Errors of a displacement reach its smoothed value and rates through the rows of a matrix R that is banded, and
a filter A of the colour through its own few coefficients: s² + A (D + R Rᵀ) Aᵀ has a banded Cholesky factor.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from modelgen.fit.whitener import Array, Smear, Whitener
from modelgen.recordings.savgol import kernels

WIDEST = 200
"""Half-width of smoothing, in samples, up to which its noise is told apart: the cost goes with its square."""


def beside(w: Whitener, rows: Array) -> Whitener:
    """`w` with noise of covariance R Rᵀ (`rows` as `smears` gives them) beside its own, which is 1."""
    return replace(
        w, ar=np.ones(1), band=factor(np.ones(1), 1.0, np.zeros(len(rows)), through(np.ones(1), rows))
    )


def smears(smear: Smear, weight: Array) -> Array:
    """(n, 2 m + 1) rows of a matrix R, centred on its diagonal: R Rᵀ is the covariance of what white noise of
    the displacement leaves in the output, in units of its own noise 1/`weight` (n,)."""
    half, most = _halves(smear.window)
    rows, by = np.zeros((len(half), 2 * most + 1)), smear.by * weight
    for h, at in _alike(half):
        rows[at, most - h : most + h + 1] = by[:, at].T @ _unit(h)
    return rows


def smoothing(window: Array, e: Array) -> Array:
    """(3, n) what errors e (n,) of the displacement make of its smoothed value and derivatives, each in its
    standard deviation; smoothed again they are taken to be 0 beyond the ends."""
    half, most = _halves(window)
    around, found = np.pad(e, most), np.zeros((3, len(half)))
    for h, at in _alike(half):
        reached = around[most - h : len(around) - most + h]
        found[:, at] = _unit(h) @ np.lib.stride_tricks.sliding_window_view(reached, 2 * h + 1)[at].T
    return found


def _halves(window: Array) -> tuple[Array, int]:
    """Half-widths of windows (n,) as they count here, and the greatest."""
    half = np.clip(window, 4, WIDEST).astype(int)
    return half, int(half.max())


def _alike(half: Array) -> Iterator[tuple[int, Array]]:
    """Each half-width, and the samples that have it."""
    for h in np.unique(half).tolist():
        yield h, np.flatnonzero(half == h)


def _unit(half: int) -> Array:
    """(3, 2 half + 1) sums over a window, each of length 1, that are a sample's smoothed value and
    derivatives: local quintics (Savitzky and Golay, Anal. Chem. 36 (1964) 1627), in the narrowest window the
    value itself and the derivatives of the polynomial through nine."""
    c = kernels(2 * half + 1, 8 if half == 4 else 5)
    return np.asarray(c / np.linalg.norm(c, axis=1, keepdims=True))


def _autocovariance(a: Array) -> Array:
    """(p + 1,) of autoregressive noise, innovations of variance 1: Σ_j a_j γ_|k−j| = δ_k (Yule, Walker)."""
    p = len(a) - 1
    k, j = np.mgrid[: p + 1, : p + 1]
    equations = np.zeros((p + 1, p + 1))
    np.add.at(equations, (k, abs(k - j)), a[j])
    return np.asarray(np.linalg.solve(equations, np.eye(1, p + 1)[0]))


def through(a: Array, rows: Array) -> Array:
    """(width, n) of A R Rᵀ Aᵀ, its diagonal and those below: what the filter makes of noise with these
    `rows` of R, (n, 2 m + 1)."""
    p, n = len(a) - 1, len(rows)
    width = p + rows.shape[1]
    turned = np.zeros((n, width))  # A R, its row i beginning with noise i − p − m
    for j in range(p + 1):
        turned[j:, p - j : width - j] += a[j] * rows[: n - j]
    band = np.zeros((width, n), order="F")
    dense = np.zeros((AT_ONCE + width - 1, AT_ONCE + 2 * width - 1))
    for i in range(0, n, AT_ONCE):  # dense products of a few rows with all that overlap with them
        some = turned[i : i + len(dense)]
        dense[:] = 0.0
        _slanting(dense, some.shape)[:] = some
        reach = dense[:, : len(dense)]
        band[:, i : i + AT_ONCE] = _slanting(reach[:AT_ONCE] @ reach.T, (min(AT_ONCE, n - i), width)).T
    return band[: min(width, n)]


AT_ONCE = 64
"""Rows that are multiplied at once."""


def _slanting(dense: Array, shape: tuple[int, int]) -> Array:
    """A view of a matrix' rows, each one column farther to the right than the one above."""
    return np.lib.stride_tricks.as_strided(dense, shape, (sum(dense.strides), dense.strides[1]))


def factor(a: Array, s2: float, more: Array, further: Array | None = None, times: float = 1.0) -> Array:
    """Lower banded Cholesky factor of s² + A D Aᵀ + `times` `further`, the first samples stationary; D =
    `more` (n,); further: as `through` gives it.

    Without `further`, what is neither first nor reached by a D is independent of the rest, and left out.
    """
    from scipy.linalg import cholesky_banded

    p, n = len(a) - 1, len(more)
    width = min(n, max(p + 1, 0 if further is None else len(further)))
    band = np.zeros((width, n), order="F")  # as LAPACK and the fitters in C have it: none makes a copy
    if further is not None:
        np.multiply(further, times, out=band[: len(further)])
    rows = np.full(n, further is not None)
    band[0] += s2
    rows[:p] = True
    first = s2 * (_first(a) - np.eye(p))
    for k in range(p):
        band[k, : p - k] += np.diagonal(first, -k)
    outer = np.stack([np.pad(a[k:] * a[: p + 1 - k], (0, k)) for k in range(p + 1)])
    for i in map(int, np.flatnonzero(more)):
        end = min(i + p + 1, n)
        band[: p + 1, i:end] += more[i] * outer[:, : end - i]
        rows[i:end] = True
    band[0, ~rows] = np.sqrt(s2)
    some = slice(None) if rows.all() else rows
    found = cholesky_banded(
        np.asfortranarray(band[:, some]), lower=True, overwrite_ab=True, check_finite=False
    )
    if rows.all():
        return np.asarray(found)
    band[:, some] = found
    return band


def _first(a: Array) -> Array:
    """(p, p) covariance of what the filter leaves of the first p samples of its process, innovations 1."""
    from scipy.linalg import toeplitz

    p = len(a) - 1
    if not p:
        return np.zeros((0, 0))
    T = toeplitz(a[:p], np.zeros(p))
    return np.asarray(T @ toeplitz(_autocovariance(a)[:p]) @ T.T)
