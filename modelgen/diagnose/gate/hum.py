"""Hum in a sweep: many weak harmonics of the mains, none of them an outlier."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.gate.oddities import MAINS
from modelgen.diagnose.noise.noise import off_neighbours
from modelgen.fit.series import Array

STEPS = (1, 2)
"""From one harmonic in which the mains may be heard to the next: all, or the odd ones."""
WIDTHS = (0.5, 1.0, 2.0, 4.0, 8.0)
"""Half bandwidths of analysers [Hz]."""
BESIDE = (0.3, 0.5, 0.7)
"""Where, from one harmonic to the next, sweeps are listened to for comparison."""
CHANCE = 3e-4
"""Probability by chance alone, of the loudest of all that is looked at, that makes a hum (an upper bound)."""
CROWDED = 0.35
"""Share of a sweep that its lines may take."""
CAP = 6.0
"""Times the power of noise that one sample counts at most: an outlier is no hum."""
AROUND = 15
"""Samples on either side by which the power of noise is measured."""
FEWEST = 30
"""Samples between the lines that tell how loud a sweep is there."""
SKIRT = 2.0
"""Half bandwidths beyond which a filter lets nothing through that matters."""


@dataclass(frozen=True)
class _Comb:
    """Lines at base·(1 + step·k) Hz, `width` to either side of each."""

    base: float
    step: int
    width: float

    def orders(self, f: Array, away: float = 0.0) -> Array:
        """(n,) which line each frequency is within, 1, 1 + step, …; 0 for none. All are `away` steps off."""
        period = self.base * self.step
        n = np.round((f - self.base) / period - away).astype(int)
        near = np.abs(f - self.base - (n + away) * period) < self.width
        return np.where(near & (n >= 0), 1 + self.step * n, 0)


def hum(f: Sequence[Array], white: Sequence[Array], port: str) -> tuple[Leftover | None, list[Array]]:
    """Sweeps that are louder near multiples of 50 or 60 Hz than between; and the samples there.

    f: (n,) frequencies of each sweep; white: (channels, n) whitened residuals. Power of noise is exponential,
    and a sum of k of these a gamma of order k; how much sums on lines beside the harmonics vary tells how
    many samples count as one where they are not independent. The loudest harmonic is not counted: one line
    alone may be anything.
    """
    powers = [_power(e) for e in white]
    tried = [_Comb(base, step, width) for base in MAINS for step in STEPS for width in WIDTHS]
    least, best = 1.0, tried[0]
    for comb in tried:
        p = _chance(comb, f, powers)
        least, best = min((least, best), (p, comb), key=lambda x: x[0])
    if least * len(tried) > CHANCE:
        return None, [np.zeros(len(x), dtype=bool) for x in f]
    wide = _Comb(best.base, best.step, SKIRT * best.width)
    marks = [wide.orders(x) > 0 for x in f]
    power = float(sum(np.sum(e[:, m] ** 2) for e, m in zip(white, marks, strict=True)))
    which = "odd multiples" if best.step == 2 else "multiples"
    says = f"louder near the {which} of {best.base:.0f} Hz than between: hum of the mains, picked up"
    return Leftover(power, power, port, says), marks


def _chance(comb: _Comb, f: Sequence[Array], powers: Sequence[Array]) -> float:
    """How likely it is that noise alone is as loud on the lines of a comb."""
    from scipy.special import gammaincc

    power, orders = np.concatenate(powers), np.concatenate([comb.orders(x) for x in f])
    if np.mean(orders > 0) > CROWDED or not np.any(orders):
        return 1.0
    off = power[orders == 0]
    if off.size < FEWEST or not off.any():
        return 1.0
    level = float(off.mean())
    sizes, counts = [], []
    for away in BESIDE:
        for x, p in zip(f, powers, strict=True):
            at = np.where(comb.orders(x) > 0, 0, comb.orders(x, away))
            sizes.append(np.bincount(at, p)[1:] / level)
            counts.append(np.bincount(at)[1:])
    size, count = np.concatenate(sizes), np.concatenate(counts)
    spread = max(1.0, float(np.sum((size - count) ** 2) / max(count.sum(), 1)))
    size, count = np.bincount(orders, power)[1:] / level, np.bincount(orders)[1:]
    loudest = int(np.argmax(size - count))
    rest, total = count.sum() - count[loudest], size.sum() - size[loudest]
    return float(gammaincc(rest / spread, total / spread)) if rest else 1.0


def _power(white: Array) -> Array:
    """(n,) power of samples off the median of those about them, over that of noise thereabouts."""
    power = np.sum([off_neighbours(e) ** 2 for e in white], axis=0)
    around = np.lib.stride_tricks.sliding_window_view(np.pad(power, AROUND, mode="reflect"), 2 * AROUND + 1)
    return np.asarray(np.minimum(power * np.log(2) / np.maximum(np.median(around, axis=1), 1e-300), CAP))
