"""Noise of impedances that is not all relative: an instrument's floor, the rounding of what was recorded,
fewer averages where a period lasts longer.

How neighbours scatter says how large the noise is wherever |Z| is large or small; no model is needed for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import comb

import numpy as np

from modelgen.fit.series import Array, Series

ORDER = 4
"""Differences that remove what is smooth; they have five samples each, and neighbours share four."""
ALIKE = sum((comb(2 * ORDER, k) / comb(2 * ORDER, ORDER)) ** 2 for k in range(2 * ORDER + 1))
"""Differences that share samples count as so many times fewer."""
LONE = 15.0
"""Squares count at most this many times what is expected: outliers say nothing about the rest."""
SHARES = (0.0, *np.geomspace(1e-3, 1e3, 25))
"""Variances of the other part of the noise, over the stated part's at its median, that are tried."""
SURE = 20.0
"""By how much −2 ln of the likelihood must fall."""
FEWEST = 40
"""Samples that tell two parts of a noise."""
POWERS = (-1.0, -0.75, -0.5, -0.25, 0.25, 0.5, 0.75, 1.0)
"""Noise over noise as known, as powers of the frequency: averages over one time fall with half a power."""


def two_parts(series: Sequence[Series], white: Sequence[Array]) -> tuple[Series, ...]:
    """Complex series with both an absolute and a relative noise where `white`, residuals of a first fit over
    the noise as stated, scatter so.

    What is stated stands: noise is no less than that.
    """
    return tuple(_two_parts(s, e) for s, e in zip(series, white, strict=True))


def _two_parts(s: Series, white: Array) -> Series:
    if s.measure != "complex" or s.n < FEWEST or all(s.spread):
        return s
    relative = s.spread[0] == 0  # as far as known
    other = s.size ** (-2.0 if relative else 2.0)
    typical = float(np.median(other))
    found = _parts(white, other / typical)
    if found is None:
        return s
    own, more = found
    least = 1.0 if s.stated else 0.0
    known = s.spread[relative]
    own, more = known * np.sqrt(max(own, least)), known * np.sqrt(more / typical)
    return s.spread_by((more, own) if relative else (own, more))


def slanted(series: Sequence[Series], f: Sequence[Array], white: Sequence[Array]) -> tuple[Series, ...]:
    """Sweeps whose noise goes with a power of the frequency where `white`, residuals over the noise as known,
    scatter so. What is stated stands: noise is no less than that."""
    return tuple(map(_slanted, series, f, white))


def _slanted(s: Series, f: Array, white: Array) -> Series:
    if s.measure not in ("complex", "modulus") or s.n < FEWEST:
        return s
    over = f / np.sqrt(f.min() * f.max())
    seen = [_differences(white, over ** (2 * p)) for p in (0.0, *POWERS)]
    if seen[0][0].size < FEWEST:
        return s
    tries = [_deviance(square, shape) for square, shape in seen]
    best = int(np.argmin([d for d, _ in tries]))
    if (tries[0][0] - tries[best][0]) / ALIKE < SURE:
        return s
    factor = np.sqrt(tries[best][1]) * over ** (0.0, *POWERS)[best]
    return replace(s, whitener=s.whitener.scaled(np.maximum(factor, 1.0) if s.stated else factor))


def _differences(white: Array, other: Array) -> tuple[Array, Array]:
    """Squares of differences of residuals (channels, n), and what they are where the variance is `other`."""
    weights = np.array([comb(ORDER, k) ** 2 for k in range(ORDER + 1)]) / comb(2 * ORDER, ORDER)
    square = np.diff(white, ORDER) ** 2 / comb(2 * ORDER, ORDER)
    used = np.all(np.lib.stride_tricks.sliding_window_view(white, ORDER + 1, axis=1) != 0, axis=(0, 2))
    return square[:, used], np.convolve(other, weights, "valid")[used]


def _parts(white: Array, other: Array) -> tuple[float, float] | None:
    """Variances (known part, other part) of whitened residuals (2, n) where the first is 1 and the second
    goes like `other` (n,); None where the first alone says as much."""
    square, seen = _differences(white, other)
    if seen.size < FEWEST:
        return None
    tries = [_deviance(square, 1 + share * seen) for share in SHARES] + [_deviance(square, seen)]
    best = int(np.argmin([d for d, _ in tries]))
    if (tries[0][0] - tries[best][0]) / ALIKE < SURE:
        return None
    level = tries[best][1]
    return (0.0, level) if best == len(SHARES) else (level, level * SHARES[best])


def _deviance(square: Array, shape: Array) -> tuple[float, float]:
    """−2 ln of the likelihood of squares (2, n) of normal numbers of variance level·`shape`, and that
    level."""
    over = square / shape
    level = float(np.median(over)) / 0.455
    for _ in range(20):
        level = float(np.mean(np.minimum(over, LONE * level))) or 1e-300
    return over.size * float(np.log(level)) + 2 * float(np.sum(np.log(shape))), level
