"""Noise that falls with a power of the frequency down to the slowest wave of a record.

The filter of a colour looks back over few samples, so that waves as slow as the record come out of it many
times too large, and a zero point that wanders, or a long memory, seems to explain them. Here the whole
spectrum is that of 1/f^2p noise beside independent noise, and its likelihood that of the cosine transform,
whose coefficients are independent and don't see where a record ends (P. Whittle, J. R. Stat. Soc. B 15 (1953)
125).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.fft import dct

from modelgen.fit.series import Array
from modelgen.fit.whitener import Whitener

POWERS = (0.15, 0.25, 0.35, 0.45, 0.55, 0.65, 0.8, 1.0)
"""p of noise whose amplitude goes as 1/f^p."""
BESIDE = (0.0, 0.003, 0.01, 0.03, 0.1, 0.3, 0.6)
"""Shares of independent noise in the variance."""


def gain_in_slow_noise(
    before: Sequence[Whitener], old: Sequence[Array], after: Sequence[Whitener], new: Sequence[Array]
) -> float:
    """What the residuals `new` gain on `old`, (channels, n) of each recording, in −2 ln of the likelihood,
    each with the likelier of slow noise and the colour of its whitener."""
    was, then = (
        sum(min(_slow(x), _coloured(w, x)) for w, e in zip(noise, white, strict=True) for x in e)
        for noise, white in ((before, old), (after, new))
    )
    return float(was - then)


def _slow(x: Array) -> float:
    """−2 ln of the likelihood of a residual (n,) as the likeliest slow noise, with its numbers' price."""
    power, omega = _spectrum(x)
    tried = []
    for p in POWERS:
        falling = (2 * np.sin(omega / 2)) ** (-2 * p)
        falling /= np.mean(falling)
        tried += [_price(power, b + (1 - b) * falling) for b in BESIDE]
    return min(tried) + 2 * float(np.log(len(x)))


def _coloured(w: Whitener, x: Array) -> float:
    """The same of the colour that `w` takes the noise for."""
    if w.slow:
        return np.inf
    power, omega = _spectrum(x)
    filtered = np.ones(len(omega)) if w.ar is None else np.exp(-1j * np.outer(omega, range(len(w.ar)))) @ w.ar
    return _price(power, 1 / np.abs(filtered) ** 2) + w.order * float(np.log(len(x)))


def _spectrum(x: Array) -> tuple[Array, Array]:
    """Squares of the cosine transform but for the mean, and their frequencies [rad a sample]."""
    n = len(x)
    return dct(x, norm="ortho")[1:] ** 2, np.pi * np.arange(1, n) / n


def _price(power: Array, shape: Array) -> float:
    level = max(float(np.mean(power / shape)), 1e-300)
    return len(power) * float(np.log(level)) + float(np.sum(np.log(shape)))
