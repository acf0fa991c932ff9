"""What makes the residuals of one recording independent, as far as its noise is known."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from modelgen.fit.together import Together

Array = np.ndarray[Any, np.dtype[Any]]


@dataclass(frozen=True, eq=False)
class Smear:
    """Errors of a smoothed motion in an output.

    window: (n,) half-widths of the smoothing, in samples. by: (3, n) standard deviations, signed, of what
    errors of the motion's value and first two derivatives make of the output.
    """

    window: Array
    by: Array


@dataclass(frozen=True, eq=False)
class Whitener:
    """Turns residuals into independent ones of unit variance, as far as the noise is known.

    weight: (channels, n) real, or (n,) complex, which multiplies the complex residual (so that a noise
    that is relative to |Z| is turned into the frame of Z). root: errors that the samples have together.
    share: (n,), by which `masked` has lowered the weight. ar: coefficients (1, a1, …) of a whitening
    filter along the samples; undo: (n,) share that is divided out before it (noise that adds to a
    coloured one, instead of modulating it); band: (order + 1, n), lower banded Cholesky factor of the
    covariance of what the filter leaves. smear: the errors of a motion that `share` allows for. slow:
    whether the filter is that of a power of the frequency: one number, however long.
    """

    weight: Array
    root: Together | None = None
    ar: Array | None = None
    share: Array | None = None
    smear: Smear | None = None
    undo: Array | None = None
    band: Array | None = None
    slow: bool = False

    @cached_property
    def reach(self) -> Array:
        """(n,) how far below the diagonal each column of `band` goes: where windows are narrow, not far."""
        assert self.band is not None
        upward = self.band[::-1] != 0
        return np.asarray(len(self.band) - 1 - np.argmax(upward, axis=0), dtype=np.uintp)

    @property
    def order(self) -> int:
        """Numbers that describe the colour."""
        return 0 if self.ar is None else 1 if self.slow else len(self.ar) - 1

    def apply(self, e: Array) -> Array:
        """Whiten residuals or their derivatives: (channels, n) or (channels, columns, n), same shape back."""
        w = self.weight
        if np.iscomplexobj(w):
            turned = (e[0] + 1j * e[1]) * w
            white = np.stack([turned.real, turned.imag])
        else:
            white = e * (w if e.ndim == 2 else w[:, None, :])
        if self.root is not None:
            white = self.root.apply(white)
        return white if self.ar is None else self.colour(white)

    def colour(self, white: Array) -> Array:
        """Whiten along the samples (the last axis) what has its weight already."""
        if self.ar is None:
            return white
        white = white if self.undo is None else white / self.undo
        filtered = self.ar[0] * white
        for lag, a in enumerate(self.ar[1:], 1):
            filtered[..., lag:] += a * white[..., :-lag]
        if self.band is None:
            return np.asarray(filtered)
        from scipy.linalg.lapack import dtbtrs

        n = filtered.shape[-1]
        solved, _ = dtbtrs(self.band, filtered.reshape(-1, n).T, uplo="L")
        found = np.ascontiguousarray(solved.T).reshape(filtered.shape)
        return found if self.share is None else np.where(self.share > 0, found, 0.0)

    def scaled(self, factor: float | Array) -> Whitener:
        """For noise that is `factor` times as large."""
        return replace(self, weight=self.weight / factor)

    def masked(self, keep: Array) -> Whitener:
        """With samples down-weighted by `keep` (n,), 0 … 1: they count as measured with a noise 1/keep as
        large."""
        share = keep if self.share is None else keep * self.share
        root = None if self.root is None else self.root.weighed(keep)
        return replace(self, weight=self.weight * keep, share=share, root=root)
