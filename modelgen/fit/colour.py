"""The colour of noise: autoregression (AR) of a residual, beside further noise that comes and goes.

Noise y = x + d on a sample, x an AR process of one variance, d independent with a variance D of each sample
(errors of the motion that act through the model; infinite where a sample is not believed). With A the AR
filter, A y has the banded covariance s² + A D Aᵀ, whose Cholesky factor L whitens exactly: L⁻¹ A y. The first
samples have the covariance of the stationary process. The rival is noise whose level as a whole is modulated:
x alone, over its level.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from modelgen.fit.whitener import Array, Whitener
from modelgen.recordings.savgol import kernels

UNBELIEVED = 1e8
"""Variance of a sample that weighs nothing."""
WIDE, WIDEST = 24, 200
"""Half-width of smoothing, in samples, up to which its noise is told apart, roughly and well: the cost goes
with its square."""
LEVELS = (1.0, 4.0)
"""Variances of the errors of motion, in what was stated or estimated for them, among which the likelihood
chooses."""
SLOW = (0.25, 0.5, 0.75)
"""Powers of 1/f that slow noise falls with in amplitude."""
MEMORY = 64
"""Samples that its filter looks back, at a third of a record or less."""
SHARED = (0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.995)
"""Correlations of neighbours among which the likelihood chooses where all recordings have the same."""
FEWEST = 10
"""Samples that tell one number of a colour."""
CLEAN = 8
"""Power of a row's smallest share by which it counts in an AR's estimate: what is half other noise,
hardly."""


def autoregression(white: Array, most: int, share: Array | None = None) -> Array:
    """Whitening filter (1, a1, …) of a residual (channels, n), its order by BIC (0 … most).

    Least squares over the channels; a row counts by the power CLEAN of the smallest `share` (n,) of its
    samples.
    """
    n = white.shape[1]
    most = int(min(most, n // FEWEST))
    if most < 1:
        return np.ones(1)
    x = white - white.mean(axis=1, keepdims=True)
    row = _rows(np.ones(n) if share is None else share, most)
    count = len(white) * float(np.sum(row))
    if count < 10 * most:
        return np.ones(1)
    root = np.tile(np.sqrt(row), len(white))
    target = root * x[:, most:].ravel()
    columns = np.stack([x[:, most - k : n - k].ravel() for k in range(1, most + 1)], axis=1) * root[:, None]
    total = float(target @ target) or 1.0
    q, r = np.linalg.qr(columns)
    c = q.T @ target
    rss = np.concatenate([[total], total - np.cumsum(c**2)])
    bic = count * np.log(np.maximum(rss, 1e-12 * total)) + np.arange(most + 1) * np.log(count)
    order = int(np.argmin(bic))
    if order == 0 or bic[0] - bic[order] < 10.0:
        return np.ones(1)
    a = np.linalg.solve(r[:order, :order], c[:order])
    return _stable(np.concatenate([[1.0], -a]), n)


def _rows(share: Array, most: int) -> Array:
    """(n − most,) weight of each row of a regression on `most` earlier samples."""
    least = np.lib.stride_tricks.sliding_window_view(share, most + 1).min(axis=1)
    return np.asarray(least**CLEAN)


def _longest(n: int) -> float:
    """The largest pole of noise in n samples: a memory longer than the record is an offset, of any size."""
    return min(0.9995, 1 - 0.5 / n)


def _stable(a: Array, n: int) -> Array:
    """The filter with the poles of its process drawn inside the unit circle, as far as n samples tell."""
    longest, most = float(np.max(np.abs(np.roots(a)), initial=0.0)), _longest(n)
    return a if longest < most else a * (most / longest) ** np.arange(len(a))


def recursive(a: Array, x: Array) -> Array:
    """y (channels, n) of Σ_k a_k y_(i−k) = x_i, at rest before: the inverse of `filtered`."""
    from scipy.linalg.lapack import dtbtrs

    solved, _ = dtbtrs(np.repeat(a[:, None], x.shape[1], axis=1), x.T, uplo="L")
    return np.ascontiguousarray(solved.T)


def filtered(a: Array, x: Array) -> Array:
    """a ∗ x along the last axis, samples before the first counted as 0."""
    out = a[0] * x
    for lag, c in enumerate(a[1:], 1):
        out[..., lag:] += c * x[..., :-lag]
    return np.asarray(out)


def fractional(power: float, memory: int) -> Array:
    """(memory + 1,) whitening filter (1 − B)^power of noise of amplitude 1/f^power, B the shift by a sample.

    J. R. M. Hosking, Biometrika 68 (1981) 165, eq. 2.2: c_k = c_{k−1} (k − 1 − power)/k.
    """
    k = np.arange(1.0, memory + 1)
    return np.concatenate([[1.0], np.cumprod((k - 1 - power) / k)])


def flattened(x: Array) -> Array:
    """A record x (n,) without the slope of its spectrum: the filter of SLOW, or none, that leaves least."""
    return min((x, *(filtered(fractional(power, MEMORY), x) for power in SLOW)), key=lambda y: float(y @ y))


def coloured(
    whiteners: Sequence[Whitener], white: Sequence[Array], most: int, slow: bool = False
) -> tuple[Whitener, ...]:
    """Whiteners with the colour of the residuals `white` (which they left), one filter a recording.

    Whichever of the two kinds of noise is the likelier; slow: or noise that falls with a power of the
    frequency; else: or one of the first order, the same in all recordings (too short to tell for themselves).
    All whiteners of a recording have the same determinant, so that sums of squares compare as likelihoods.
    """
    own = [_coloured(w, x, most, slow) for w, x in zip(whiteners, white, strict=True)]
    if slow or most < 1 or len(white) < 2 or min(x.shape[1] for x in white) < FEWEST:
        return tuple(w for w, _ in own)
    longest = _longest(min(x.shape[1] for x in white))
    shared = min(
        (_shared(whiteners, white, rho) for rho in SHARED if rho < longest), key=lambda found: found[1]
    )
    return shared[0] if shared[1] < sum(price for _, price in own) else tuple(w for w, _ in own)


def _shared(
    whiteners: Sequence[Whitener], white: Sequence[Array], rho: float
) -> tuple[tuple[Whitener, ...], float]:
    """Whiteners of x_t = rho x_{t−1} + independent noise in all recordings, and −2 ln of their likelihood
    with one number's price."""
    found, total, count = [], 0.0, 0
    for w, x in zip(whiteners, white, strict=True):
        used = np.ones(x.shape[1], dtype=bool) if w.share is None else w.share > 0
        plain = replace(w, ar=None, undo=None, band=None, slow=False)
        found.append(_banded(plain, x, np.array([1.0, -rho]), used.astype(float), used, None))
        n = int(used.sum()) * len(x)
        total += n * float(np.log(np.sum(found[-1].colour(x) ** 2)))
        count += n
    return tuple(found), total + float(np.log(count))


def _coloured(w: Whitener, white: Array, most: int, slow: bool) -> tuple[Whitener, float]:
    """The likeliest whitener of one recording, and −2 ln of its likelihood with the price of its numbers."""
    share = np.ones(white.shape[1]) if w.share is None else w.share
    used = share > 0
    plain = replace(w, ar=None, undo=None, band=None, slow=False)
    tried = [(plain, 0)]
    a = autoregression(white, most, used.astype(float))
    if len(a) > 1:
        tried.append((_banded(plain, white, a, used.astype(float), used, None), len(a) - 1))
        if slow and white.shape[1] >= 3 * MEMORY:
            tried.append((replace(_falling(plain, white, used), slow=True), 1))
    if w.smear is not None and np.mean(share[used] < 0.95) > 0.01:
        undo = np.where(used, share, 1.0)
        own = autoregression(white / undo, most, share)
        rows, early = smeared(1 / undo**2 - 1, w.smear), replace(plain, undo=undo)
        for a in [np.ones(1), own][: 2 if len(own) > 1 else 1]:
            more = through(a, rows)
            for level in LEVELS:
                tried.append((_banded(early, white / undo, a, share, used, level * more), len(a) - 1))
    n = int(used.sum()) * len(white)
    price = [n * np.log(np.sum(v.colour(white) ** 2)) + p * np.log(n) for v, p in tried]
    best = int(np.argmin(price))
    return tried[best][0], float(price[best])


def _falling(w: Whitener, x: Array, used: Array) -> Whitener:
    """`w` with the filter of SLOW that leaves least."""
    filters = [fractional(power, MEMORY) for power in SLOW]
    a = min(filters, key=lambda a: float(np.sum(filtered(a, x) ** 2)))
    return _banded(w, x, a, used.astype(float), used, None)


def _banded(w: Whitener, x: Array, a: Array, clean: Array, used: Array, more: Array | None) -> Whitener:
    """`w` with the filter a and the factor of what it leaves; `more`: of further noise, as `through` gives
    it."""
    row = _rows(clean, len(a) - 1)
    innovations = filtered(a, x)[:, len(a) - 1 :]
    s2 = float(np.mean(np.sum(row * innovations**2, axis=1)) / max(np.sum(row), 1e-9)) or 1.0
    L = factor(a, s2, np.where(used, 0.0, UNBELIEVED), more)
    level = -np.log(w.undo[used]) if w.undo is not None else np.zeros(1)
    L *= np.exp(np.mean(level) - np.mean(np.log(L[0, used])))
    return replace(w, ar=a, band=L)


def noise_like(w: Whitener, white: Array, rng: np.random.Generator) -> Array:
    """Fresh noise (channels, n) of the process that `w` takes for the residuals `white`, which it has weighed
    but not filtered; as large as these are where next to nothing adds to it."""
    n = white.shape[1]
    a = np.ones(1) if w.ar is None else w.ar
    share = np.ones(n) if w.share is None else w.share
    clean = _rows(share, len(a) - 1)
    innovations = filtered(a, white / np.where(share > 0, share, 1.0))[:, len(a) - 1 :]
    level = np.sqrt(np.sum(clean * innovations**2) / max(len(white) * np.sum(clean), 1e-9)) or 1.0
    fresh = level * rng.standard_normal((len(white), n + RUN_IN))
    return recursive(a, fresh)[:, RUN_IN:]


RUN_IN = 1000
"""Samples after which a coloured noise is stationary."""


def beside(w: Whitener, rows: Array) -> Whitener:
    """`w` with noise of covariance R Rᵀ (`rows` as `smeared` gives them) beside its own, which is 1."""
    return replace(
        w, ar=np.ones(1), band=factor(np.ones(1), 1.0, np.zeros(len(rows)), through(np.ones(1), rows))
    )


def smeared(variance: Array, width: Array) -> Array:
    """(n, 2 m + 1) rows of a matrix R, centred on its diagonal: R Rᵀ is the covariance of what noise leaves
    in a derivative by local polynomials.

    variance, width: (n,) of it, and half-widths in samples (those beyond WIDE count as that: little is left
    there).
    """
    none = np.zeros(len(variance))
    return smears(np.minimum(width, WIDE), np.stack([none, np.sqrt(variance), none]))


def smears(window: Array, by: Array) -> Array:
    """(n, 2 m + 1) rows, centred on the diagonal, that white noise of the displacement goes through to a sum
    of a sample's smoothed value and derivatives, `by` (3, n) of each in its standard deviation."""
    half, most = _halves(window)
    rows = np.zeros((len(half), 2 * most + 1))
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
    band = np.zeros((width, n))
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


def factor(a: Array, s2: float, more: Array, further: Array | None = None) -> Array:
    """Lower banded Cholesky factor of s² + A D Aᵀ + `further`, the first samples stationary; D = `more`
    (n,); further: as `through` gives it.

    Without `further`, what is neither first nor reached by a D is independent of the rest, and left out.
    """
    from scipy.linalg import cholesky_banded

    p, n = len(a) - 1, len(more)
    width = min(n, max(p + 1, 0 if further is None else len(further)))
    band, rows = np.zeros((width, n)), np.full(n, further is not None)
    band[0], rows[:p] = s2, True
    first = s2 * (_first(a) - np.eye(p))
    for k in range(p):
        band[k, : p - k] += np.diagonal(first, -k)
    if further is not None:
        band[: len(further)] += further
    outer = np.stack([np.pad(a[k:] * a[: p + 1 - k], (0, k)) for k in range(p + 1)])
    for i in map(int, np.flatnonzero(more)):
        end = min(i + p + 1, n)
        band[: p + 1, i:end] += more[i] * outer[:, : end - i]
        rows[i:end] = True
    band[0, ~rows] = np.sqrt(s2)
    some = slice(None) if rows.all() else rows
    band[:, some] = cholesky_banded(np.asfortranarray(band[:, some]), lower=True, overwrite_ab=True)
    return band


def _first(a: Array) -> Array:
    """(p, p) covariance of what the filter leaves of the first p samples of its process, innovations 1."""
    from scipy.linalg import toeplitz

    p = len(a) - 1
    if not p:
        return np.zeros((0, 0))
    T = toeplitz(a[:p], np.zeros(p))
    return np.asarray(T @ toeplitz(_autocovariance(a)[:p]) @ T.T)
