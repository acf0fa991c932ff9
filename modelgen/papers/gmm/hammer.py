"""A simulated hammer test of the paper's free bar (sec. 3.1): its first longitudinal mode, in time signals.

304 stainless steel, 50 mm × 1500 mm, hit at one end, four accelerometers at the other. Modes of a free-free
bar, φ_n = cos(nπx/L) with modal mass M/2; the bar wave speed is such that the first one has the paper's
1600 Hz, and the damping ratio is the paper's 0.294 %.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from modelgen.recordings.frf import Frf

Array = np.ndarray[Any, np.dtype[Any]]


@dataclass(frozen=True)
class HammerTest:
    """What is hit, and how it is recorded; noise as a part of each signal's largest value."""

    f_1: float = 1600.0
    xi: float = 0.00294
    mass: float = 8000 * np.pi * 0.025**2 * 1.5
    modes: int = 7
    rate: float = 25600.0
    samples: int = 32768
    pulse: float = 1.5e-4
    force: float = 3000.0
    hits: int = 5
    sensors: int = 4
    noise: float = 2e-3


def accelerance(test: HammerTest, f: Array) -> Array:
    """Acceleration at the far end over force [m/s²/N] at f [Hz]."""
    w = 2 * np.pi * f
    whole = np.full(f.shape, 1 / test.mass, complex)
    for n in range(1, test.modes + 1):
        w_n = 2 * np.pi * n * test.f_1
        whole += (-1) ** n * (2 / test.mass) * -(w**2) / (w_n**2 - w**2 + 2j * test.xi * w_n * w)
    return whole


def measure(test: HammerTest, seed: int = 0) -> Frf:
    """The responses that an analyser would give: H_1 = S_fa/S_ff over the hits, from noisy signals."""
    rng = np.random.default_rng(seed)
    t = np.arange(test.samples) / test.rate
    f = np.fft.rfftfreq(test.samples, 1 / test.rate)
    H = accelerance(test, f)
    gains = 1 + 0.02 * rng.standard_normal(test.sensors)  # sensors differ by a few per cent
    cross, auto = np.zeros((test.sensors, f.size), complex), np.zeros(f.size)
    for _ in range(test.hits):
        length = test.pulse * (1 + 0.1 * rng.random())
        force = test.force * np.where(t < length, np.sin(np.pi * t / length), 0.0)
        response = np.fft.irfft(H * np.fft.rfft(force), test.samples)
        force = _noisy(force, test.noise, rng)
        F = np.fft.rfft(force)
        auto += np.abs(F) ** 2
        for k, gain in enumerate(gains):
            cross[k] += np.conj(F) * np.fft.rfft(_noisy(gain * response, test.noise, rng))
    names = tuple(f"H_{k}" for k in range(1, test.sensors + 1))
    return Frf(f[1:], (cross / auto)[:, 1:], names, ("m/s^2/N",) * test.sensors)


def _noisy(signal: Array, noise: float, rng: np.random.Generator) -> Array:
    return signal + noise * np.abs(signal).max() * rng.standard_normal(signal.size)
