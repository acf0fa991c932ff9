"""Noise of impedances that is not all relative: floors of an instrument's voltage and current, the rounding
of what was recorded, fewer averages where a period lasts longer, a noisy end of the band.

How neighbours scatter says how large the noise is wherever |Z| is large or small; no model is needed for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import comb

import numpy as np

from modelgen.fit.scatter import rounding
from modelgen.fit.series import Array, Series, sizes_of

ORDER = 4
"""Differences that remove what is smooth; they have five samples each, and neighbours share four."""
ALIKE = sum((comb(2 * ORDER, k) / comb(2 * ORDER, ORDER)) ** 2 for k in range(2 * ORDER + 1))
"""Differences that share samples count as so many times fewer."""
LONE = 15.0
"""Squares count at most this many times what is expected: outliers say nothing about the rest."""
GROWS = (0, 1, 2)
"""Powers of |Z| with which parts of the noise grow: a voltmeter's floor or rounding, what is relative, and an
ammeter's floor δI, which is δZ = Z δI/I with I = V/Z."""
SHARES = tuple(np.geomspace(1e-3, 1e3, 25))
"""Variances of another part of the noise, over those before at its median, that are tried."""
MORE = 1.5
"""Times the least variance that counts as more."""
ALTERNATE = -0.5
"""Correlation of neighbouring differences above which a residual is no independent noise."""
SURE = 20.0
"""By how much −2 ln of the likelihood must fall."""
FEWEST = 40
"""Samples that tell parts of a noise."""
POWERS = (-1.0, -0.75, -0.5, -0.25, 0.25, 0.5, 0.75, 1.0)
"""Noise over noise as known, as powers of the frequency: averages over one time fall with half a power."""
EVER = 1e-4
"""Ratio of variances on both sides of a step, less than which is no noise: treads of a staircase."""
COARSE = 0.5
"""Rounding, over the noise, from which it matters."""
STEPS = tuple(np.arange(0.05, 0.96, 0.05))
"""Shares of the samples below a frequency at which the noise may step."""


@dataclass(frozen=True, eq=False)
class Scatter:
    """How the residuals e (channels, n) of a fit scatter between neighbours, against a noise of `variance`
    (n,); `used`, (n − ORDER,): differences that hold no sample which is left out.

    Residuals are taken as they are: weights hold noise of their own, by which a large misfit would scatter.
    """

    e: Array
    variance: Array
    used: Array

    @classmethod
    def of(cls, s: Series, e: Array) -> Scatter:
        weight = np.abs(np.atleast_2d(s.whitener.weight)[0])
        there = (weight > 0) & np.all(e != 0, axis=0)  # exact numbers have no noise
        used = np.all(np.lib.stride_tricks.sliding_window_view(there, ORDER + 1), axis=1)
        return cls(e, 1 / np.where(there, weight, 1.0) ** 2, used)

    @cached_property
    def square(self) -> Array:
        """Squares of differences, those that are used."""
        return np.asarray(np.diff(self.e, ORDER)[:, self.used] ** 2 / comb(2 * ORDER, ORDER))

    def expected(self, shape: Array) -> Array:
        """What they are where the variance is `shape` (n,) times the known one."""
        weights = np.array([comb(ORDER, k) ** 2 for k in range(ORDER + 1)]) / comb(2 * ORDER, ORDER)
        return np.asarray(np.convolve(self.variance * shape, weights, "valid")[self.used])

    def deviance(self, shape: Array) -> tuple[float, float]:
        """−2 ln of the likelihood of a variance that goes as `shape` (n,), and its level."""
        return _deviance(self.square, self.expected(shape))

    def alternates(self, shape: Array) -> bool:
        """Whether residuals scatter as independent noise where the variance `shape` (n,), over the known one,
        is larger than elsewhere: differences of noise alternate, by −0.8 from one to the next, and those of a
        resonance that was missed do not."""
        more = np.asarray(shape > MORE * shape.min())[ORDER // 2 : -(ORDER // 2)][self.used]
        both = more[1:] & more[:-1]
        d = np.diff(self.e, ORDER)[:, self.used] / np.sqrt(self.expected(shape))
        here, there = (np.clip(x[:, both], -LONE, LONE) for x in (d[:, 1:], d[:, :-1]))
        return bool(np.sum(here * there) <= ALTERNATE * np.sqrt(np.sum(here**2) * np.sum(there**2)))


def parted(series: Sequence[Series], f: Sequence[Array], raw: Sequence[Array]) -> tuple[Series, ...]:
    """Complex series at frequencies f with an absolute noise, a relative one, and that of an ammeter, as far
    as `raw`, residuals of a first fit, scatter so.

    What is stated stands: noise is no less than that.
    """
    return tuple(map(_parted, series, f, raw))


def _parted(s: Series, f: Array, e: Array) -> Series:
    if s.measure != "complex" or s.n < FEWEST or np.count_nonzero(s.spread) > 1:
        return s
    known = int(np.argmax(s.spread))
    shapes = np.array([s.size ** (2.0 * (p - known)) for p in GROWS])
    typical = np.median(shapes, axis=1)
    shapes /= typical[:, None]
    scatter = Scatter.of(s, e)
    found = _parts(scatter, shapes, known)
    if found is not None:
        found = _along_rather(scatter, f, shapes, known, found)
    if found is None or not scatter.alternates(found @ shapes):
        return s
    found[known] = max(found[known], 1.0 if s.stated else 0.0)
    absolute, relative, inverse = map(float, s.spread[known] * np.sqrt(found / typical))
    return s.spread_by((absolute, relative, inverse))


def no_finer_than_rounded(series: Sequence[Series]) -> tuple[Series, ...]:
    """Complex series whose absolute noise is no less than the rounding of their parts, where that matters: a
    staircase hardly scatters."""
    return tuple(map(_no_finer, series))


def _no_finer(s: Series) -> Series:
    if s.measure != "complex":
        return s
    step = max(map(rounding, s.data))
    absolute, relative, inverse = s.spread
    if step <= max(absolute, COARSE * float(np.median(sizes_of(s.spread, s.size)))):
        return s
    return s.spread_by((step, relative, inverse))


def slanted(series: Sequence[Series], f: Sequence[Array], raw: Sequence[Array]) -> tuple[Series, ...]:
    """Sweeps whose noise goes with a power of the frequency, or steps at one, where the residuals `raw`
    scatter so. What is stated stands: noise is no less than that."""
    return tuple(map(_slanted, series, f, raw))


def _slanted(s: Series, f: Array, e: Array) -> Series:
    if s.measure not in ("complex", "modulus") or s.n < FEWEST:
        return s
    scatter = Scatter.of(s, e)
    if scatter.square.size < FEWEST:
        return s
    shapes = [np.ones(s.n), *_along(f, scatter, np.ones(s.n))]
    tries = [scatter.deviance(x) for x in shapes]
    best = int(np.argmin([d for d, _ in tries]))
    if (tries[0][0] - tries[best][0]) / ALIKE < SURE or not scatter.alternates(shapes[best]):
        return s
    factor = np.sqrt(tries[best][1] * shapes[best])
    return replace(s, whitener=s.whitener.scaled(np.maximum(factor, 1.0) if s.stated else factor))


def _along(f: Array, scatter: Scatter, shape: Array) -> list[Array]:
    """Variances (n,) that go with a power of the frequency; or that step at one, as the residuals scatter
    there over what `shape` (n,) says: an instrument's other range, vibrations of the building below, an
    amplifier's noise above."""
    over = f / np.sqrt(f.min() * f.max())
    found = [over ** (2 * p) for p in POWERS]
    square, at = scatter.square / scatter.expected(shape), np.flatnonzero(scatter.used) + ORDER // 2
    for share in STEPS:
        k = int(share * square.shape[1])
        low, high = (float(np.median(x)) for x in (square[:, :k], square[:, k:]))
        if min(low, high) > EVER * max(low, high):
            found.append(np.where(np.arange(len(f)) < at[k], low / high, 1.0))
    return found


def _parts(scatter: Scatter, shapes: Array, known: int) -> Array | None:
    """(parts,) variances over the known one that go like `shapes` (parts, n); None where the
    `known` part alone says as much. One after the other is taken in, or takes the place of all."""
    square, expected = scatter.square, np.array([scatter.expected(x) for x in shapes])
    if square.size < FEWEST:
        return None
    units = np.eye(len(shapes))
    parts = alone = units[known]
    least, level = _deviance(square, parts @ expected)
    while True:
        mixtures = [parts + share * y for y in units for share in SHARES]
        tries = [(*_deviance(square, p @ expected), p) for p in (*mixtures, *units)]
        best = min(tries, key=lambda x: x[0])
        if (least - best[0]) / ALIKE < SURE:
            return None if parts is alone else level * parts
        least, level, parts = best


def _along_rather(scatter: Scatter, f: Array, shapes: Array, known: int, found: Array) -> Array | None:
    """The `found` parts; fewer where a noise that goes with the frequency does better beside these: a
    resonance is at some frequencies only, too. None for the `known` part alone."""
    best = scatter.deviance(found @ shapes)[0]
    alone = np.eye(len(shapes))[known]
    two = _parts(scatter, shapes[:2], known) if found[2] > 0 else None
    for less in (alone, *([] if two is None else [np.append(two, 0.0)])):
        along = _along(f, scatter, less @ shapes)
        if min(scatter.deviance(less @ shapes * x)[0] for x in along) < best:
            return None if less is alone else less
    return found


def _deviance(square: Array, shape: Array) -> tuple[float, float]:
    """−2 ln of the likelihood of squares (channels, n) of normal numbers of variance level·`shape`, and that
    level."""
    over = square / shape
    level = float(np.median(over)) / 0.455
    for _ in range(20):
        level = float(np.mean(np.minimum(over, LONE * level))) or 1e-300
    return over.size * float(np.log(level)) + len(square) * float(np.sum(np.log(shape))), level
