"""Errors that samples make together, beside each its own: a covariance 1 + B Bᵀ of few modes, never n by n.

A smooth error over n frequencies has some tens of modes, so whitening costs n times that and not n².
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

KNOTS = 3
"""Knots in a correlation length; with so many the kernel is right to 1e-6."""
LEAST = 1e-7
"""Variance, over the largest mode's, below which a mode is left out."""


@dataclass(frozen=True, eq=False)
class Together:
    """modes: (n, k), orthonormal; size: (k,) variances along them, in those of the samples' own errors."""

    modes: Array
    size: Array

    @staticmethod
    def of(B: Array) -> Together:
        """For the covariance 1 + B Bᵀ, B (n, k)."""
        modes, singular, _ = np.linalg.svd(B, full_matrices=False)
        modes[~np.any(B, axis=1)] = 0.0  # what is masked stays exactly 0
        return Together(modes, singular**2)

    def apply(self, e: Array) -> Array:
        """(1 + B Bᵀ)^(−1/2) e along the last axis (n); the same shape back."""
        return np.asarray(e - ((e @ self.modes) * self.less) @ self.modes.T)

    @property
    def less(self) -> Array:
        """(k,) the part that is taken away along each mode."""
        return np.asarray(1 - 1 / np.sqrt(1 + self.size))

    def scaled(self, factor: float) -> Together:
        """The same with B so many times as large."""
        return Together(self.modes, factor**2 * self.size)

    def weighed(self, keep: Array) -> Together:
        """Where samples count with a weight lower by `keep` (n,): what is common counts less, too."""
        return Together.of(keep[:, None] * self.modes * np.sqrt(self.size))


def smooth_modes(lnf: Sequence[Array], length: float) -> list[Array]:
    """(n, k) factor B of exp(−(Δ ln f/length)²/2) in each sweep, from knots that all share."""
    there = np.unique(np.concatenate(lnf))
    count = KNOTS * (there[-1] - there[0]) / length + 2
    knots = np.linspace(there[0], there[-1], int(np.ceil(count))) if count < len(there) else there
    values, vectors = np.linalg.eigh(_kernel(knots, knots, length))
    keep = values > LEAST * values[-1]
    root = vectors[:, keep] / np.sqrt(values[keep])
    return [_kernel(x, knots, length) @ root for x in lnf]


def _kernel(a: Array, b: Array, length: float) -> Array:
    return np.asarray(np.exp(-0.5 * ((a[:, None] - b[None, :]) / length) ** 2))
