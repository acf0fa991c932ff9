"""The colour of noise: autoregression (AR) of a residual, beside further noise that comes and goes.

Noise y = x + d on a sample, x an AR process of one variance, d independent with a variance D of each sample
(errors of the motion that act through the model; infinite where a sample is not believed). With A the AR
filter, A y has the banded covariance s² + A D Aᵀ, whose Cholesky factor L whitens exactly: L⁻¹ A y. The first
samples have the covariance of the stationary process. The rival is noise whose level as a whole is modulated:
x alone, over its level.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from modelgen.fit.banded import factor, smears, through
from modelgen.fit.whitener import Array, Smear, Whitener

UNBELIEVED = 1e8
"""Variance of a sample that weighs nothing."""
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
    found = [_shared(whiteners, white, rho) for rho in _near(white)]
    shared = min(found, key=lambda found: found[1])
    return shared[0] if shared[1] < sum(price for _, price in own) else tuple(w for w, _ in own)


def _near(white: Sequence[Array]) -> list[float]:
    """The two of SHARED about the correlation of neighbours in all residuals, where the likelihood is
    greatest."""
    longest = _longest(min(x.shape[1] for x in white))
    parts = [(x.size, float(np.sum(x[:, 1:] * x[:, :-1])), float(np.sum(x**2)) or 1.0) for x in white]
    here = sum(n * a / b for n, a, b in parts) / sum(n for n, _, _ in parts)
    return sorted((rho for rho in SHARED if rho < longest), key=lambda rho: abs(rho - here))[:2]


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
    n = int(used.sum()) * len(white)

    def priced(v: Whitener, numbers: int) -> tuple[float, Whitener]:
        return float(n * np.log(np.sum(v.colour(white) ** 2)) + numbers * np.log(n)), v

    plain = replace(w, ar=None, undo=None, band=None, slow=False)
    tried = [priced(plain, 0)]
    a = autoregression(white, most, used.astype(float))
    if len(a) > 1:
        tried.append(priced(_banded(plain, white, a, used.astype(float), used, None), len(a) - 1))
        if slow and white.shape[1] >= 3 * MEMORY:
            tried.append(priced(replace(_falling(plain, white, used), slow=True), 1))
    if w.smear is not None and np.mean(share[used] < 0.95) > 0.01:
        undo = np.where(used, share, 1.0)
        early, early_white = replace(plain, undo=undo), white / undo
        own = autoregression(early_white, most, share)
        weight = (np.mean(np.abs(w.weight), axis=0) / undo).tobytes()
        beside = []
        for a in [np.ones(1), own][: 2 if len(own) > 1 else 1]:
            more = through(a, _rows_of(w.smear, weight)) if len(a) > 1 else _unfiltered(w.smear, weight)
            first = _banded(early, early_white, a, share, used, more, LEVELS[0])
            beside.append((*priced(first, len(a) - 1), a, more))
        price, first, a, more = min(beside, key=lambda x: x[0])
        tried.append((price, first))
        for times in LEVELS[1:]:  # by the likelier filter alone: a factor of a wide band is dear
            other = _banded(early, early_white, a, share, used, more, times)
            tried.append(priced(other, len(a) - 1))
    price, found = min(tried, key=lambda x: x[0])
    return found, price


@lru_cache(maxsize=4)
def _rows_of(smear: Smear, weight: bytes) -> Array:
    """Rows of what smoothed errors make of an output of this `weight` (n,): a search asks for the same many
    times."""
    return smears(smear, np.frombuffer(weight))


@lru_cache(maxsize=4)
def _unfiltered(smear: Smear, weight: bytes) -> Array:
    """Their covariance."""
    return through(np.ones(1), _rows_of(smear, weight))


def _falling(w: Whitener, x: Array, used: Array) -> Whitener:
    """`w` with the filter of SLOW that leaves least."""
    filters = [fractional(power, MEMORY) for power in SLOW]
    a = min(filters, key=lambda a: float(np.sum(filtered(a, x) ** 2)))
    return _banded(w, x, a, used.astype(float), used, None)


def _banded(
    w: Whitener, x: Array, a: Array, clean: Array, used: Array, more: Array | None, times: float = 1.0
) -> Whitener:
    """`w` with the filter a and the factor of what it leaves; `more`: of further noise, as `through` gives
    it, so many `times`. None of a filter whose process is not stationary: that of a residual which repeats
    itself to the last digit."""
    row = _rows(clean, len(a) - 1)
    innovations = filtered(a, x)[:, len(a) - 1 :]
    s2 = float(np.mean(np.sum(row * innovations**2, axis=1)) / max(np.sum(row), 1e-9)) or 1.0
    try:
        L = factor(a, s2, np.where(used, 0.0, UNBELIEVED), more, times)
    except np.linalg.LinAlgError:
        return _banded(w, x, np.ones(1), clean, used, more, times) if len(a) > 1 else w
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
