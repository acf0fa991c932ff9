"""What terms that describe a rest gain, and the noise that what they leave may be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modelgen.diagnose.hypotheses.evidence import Level, profiled, settled
from modelgen.diagnose.hypotheses.refit import Judge
from modelgen.diagnose.hypotheses.setting import COLOUR_TIME
from modelgen.diagnose.search.screen import Tangent
from modelgen.fit.colour import coloured
from modelgen.fit.pool import share
from modelgen.fit.whitener import Array, Whitener

CHECKED = 10.0
"""ΔBIC from which a gain is checked with colours of their own."""


def gain_of(
    tangent: Tangent, columns: Array, n: int, price: float = 0.0, own: Array | None = None
) -> tuple[float, float, Array]:
    """(ΔBIC, χ², residual then) of free amounts of `columns` (N, k) beside the fit, its level profiled;
    `price` for looking; own: (N,) the noise's share in the variances, None where it is all."""
    rest = tangent.off(columns)
    size = np.linalg.norm(rest, axis=0)
    keep = size > 1e-6 * np.linalg.norm(columns, axis=0)
    if not keep.any():
        return 0.0, 0.0, tangent.r
    unit = rest[:, keep] / size[keep]
    values, vectors = np.linalg.eigh(unit.T @ unit)
    good = values > 1e-10 * values[-1]
    part = (vectors.T @ (unit.T @ tangent.r))[good]
    explained = float(np.sum(part**2 / values[good]))
    left = tangent.r - unit @ (vectors[:, good] @ (part / values[good]))
    gain = profiled(settled(tangent.r), own) - profiled(settled(left), own)
    return gain - int(good.sum()) * float(np.log(n)) - price, explained, left


Noise = tuple[float, list[Whitener]]
"""−2 ln of the likelihood of residuals, and whiteners of the colours by which it is that."""


def noise_of(judge: Judge, residuals: Sequence[Array], order: int) -> Noise:
    """The likeliest noise of `residuals`, each with a colour of its own, up to `order`."""

    def likeliest(part: tuple[Whitener, Level, Array]) -> tuple[float, Whitener]:
        w, p, e = part
        own = coloured([replace(w, ar=None)], [e], order, slow=order == COLOUR_TIME)[0]
        square = own.colour(e) ** 2 * (e != 0)
        return profiled(square, p.own) + own.order * float(np.log(max(int(np.count_nonzero(e)), 2))), own

    found = share(likeliest, list(zip(judge.whiteners, judge.prior, residuals, strict=True)))
    return sum(price for price, _ in found), [w for _, w in found]


def parted(joined: Array, like: Sequence[Array]) -> list[Array]:
    """Residuals of each recording, with channels as in `like`, from those of all."""
    ends = np.cumsum([e.size for e in like])[:-1]
    return [x.reshape(e.shape) for x, e in zip(np.split(joined, ends), like, strict=True)]
