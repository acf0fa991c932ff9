"""Noise that falls with a power of the frequency, down to the slowest wave of a record or to a knee.

The filter of a colour looks back over few samples, so that waves as slow as the record come out of it many
times too large, and a zero point that wanders, or a long memory, seems to explain them. Here the whole
spectrum is that of 1/f^2p noise, or of noise of the first order (a zero point that wanders and is drawn back,
G. E. Uhlenbeck, L. S. Ornstein, Phys. Rev. 36 (1930) 823), beside independent noise, and its likelihood that
of the cosine transform, whose coefficients are independent and don't see where a record ends (P. Whittle,
J. R. Stat. Soc. B 15 (1953) 125).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from scipy.fft import dct

from modelgen.fit.series import Array
from modelgen.fit.whitener import Whitener

POWERS = (0.15, 0.25, 0.35, 0.45, 0.55, 0.65, 0.8, 1.0)
"""p of noise whose amplitude goes as 1/f^p."""
MEMORIES = (0.2, 0.08, 0.03, 0.012, 0.005)
"""Correlation times of noise of the first order, over the length of the record."""
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
    power, _ = _spectrum(x)
    inverse, logs = _shapes(len(x))
    levels = np.maximum(inverse @ power / len(power), 1e-300)
    return float(np.min(len(power) * np.log(levels) + logs)) + 2 * float(np.log(len(x)))


@lru_cache(maxsize=4)
def _shapes(n: int) -> tuple[Array, Array]:
    """(m, n − 1) inverse spectra of slow noise in n samples, and the sums of their logarithms (m,)."""
    waves = 2 * np.sin(_frequencies(n) / 2)
    falling = [waves ** (-2 * p) for p in POWERS]
    kept = [np.exp(-1 / (m * n)) for m in MEMORIES]
    falling += [1 / ((1 - rho) ** 2 + rho * waves**2) for rho in kept]
    shapes = np.array([b + (1 - b) * s / np.mean(s) for s in falling for b in BESIDE])
    return 1 / shapes, np.log(shapes).sum(axis=1)


def _coloured(w: Whitener, x: Array) -> float:
    """The same of the colour that `w` takes the noise for."""
    if w.slow:
        return np.inf
    power, omega = _spectrum(x)
    filtered = np.ones(len(omega)) if w.ar is None else np.exp(-1j * np.outer(omega, range(len(w.ar)))) @ w.ar
    shape = 1 / np.abs(filtered) ** 2
    level = max(float(np.mean(power / shape)), 1e-300)
    whole = len(power) * float(np.log(level)) + float(np.sum(np.log(shape)))
    return whole + w.order * float(np.log(len(x)))


def _spectrum(x: Array) -> tuple[Array, Array]:
    """Squares of the cosine transform but for the mean, and their frequencies [rad a sample]."""
    return dct(x, norm="ortho")[1:] ** 2, _frequencies(len(x))


def _frequencies(n: int) -> Array:
    return np.pi * np.arange(1, n) / n
