"""Linear memory in time: convolutions over the whole past, filters exact for piecewise linear signals.

Signals start from rest: what precedes the first sample is its value.
"""

from __future__ import annotations

from math import gamma

import numpy as np
import numpy.typing as npt
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.signal import lfilter

Array = npt.NDArray[np.float64]


def _convolve(kernel: Array, x: Array) -> Array:
    n = next_fast_len(len(kernel) + len(x), real=True)
    return np.asarray(irfft(rfft(kernel, n) * rfft(x, n), n)[: len(x)])


def fractional(z: Array, dt: float, alpha: float) -> Array:
    """D^α z (Caputo, 0 < α < 1) for z piecewise linear (L1 rule, Oldham and Spanier); error dt^(2-α)."""
    n = np.arange(len(z), dtype=float)
    weight = (n + 1) ** (1 - alpha) - n ** (1 - alpha)
    step = np.diff(z, prepend=z[0])
    step = np.roll(step, -1)  # the increment over the step that begins at each sample
    step[-1] = 0.0
    out = _convolve(weight, step) / (gamma(2 - alpha) * dt**alpha)
    return np.concatenate([[0.0], out[:-1]])


def relaxing(z: Array, dt: float, tau: float, beta: float) -> Array:
    """∫ exp(-((t-s)/τ)^β) ż(s) ds, the response of a branch that relaxes like a stretched exponential."""
    age = (np.arange(len(z)) + 0.5) * dt  # the increment's middle
    step = np.diff(z, append=z[-1])
    out = _convolve(np.exp(-((age / tau) ** beta)), step)
    return np.concatenate([[0.0], out[:-1]])


def low_pass(x: Array, dt: float, tau: float) -> Array:
    """First-order lag of time constant τ, exact for x linear between the samples."""
    p = np.exp(-dt / tau)
    late = tau / dt * (1 - p)
    return np.asarray(lfilter([1 - late, late - p], [1, -p], x, zi=[late * x[0]])[0])  # steady at x[0] before


def hysteretic(z: Array) -> Array:
    """Quadrature of z (j sgn ω, a rate-independent loss), by the transform of the record and its mirror."""
    both = np.concatenate([z, z[::-1]])
    return np.asarray(irfft(1j * np.sign(rfftfreq(len(both))) * rfft(both), len(both))[: len(z)])


def appendage(a: Array, dt: float, w0: float, q: float) -> Array:
    """Force per mass that a sprung mass (ω0, Q) exerts on a moving foot of acceleration a.

    Its relative motion y'' + ω0/Q y' + ω0² y = -a is filtered exactly for a linear between the samples;
    the force is -(ω0² y + ω0/Q y') = a + y''.
    """
    damp = w0 / q
    A = np.array([[0.0, 1.0], [-(w0**2), -damp]])
    lam, vec = np.linalg.eig(A)
    forcing = np.linalg.solve(vec, np.array([0.0, -1.0]).astype(complex))
    state = np.zeros((2, len(a)), complex)
    for i in range(2):  # each mode: s' = λ s + f a
        E = np.exp(lam[i] * dt)
        c1 = (E - 1 - lam[i] * dt) / (lam[i] ** 2 * dt)
        c0 = (E - 1) / lam[i] - c1
        state[i] = forcing[i] * lfilter([c1, c0], [1, -E], a.astype(complex))
    y, dy = (vec @ state).real
    return np.asarray(-(w0**2 * y + damp * dy))


def envelope(z: Array, dt: float, smooth: float) -> Array:
    """Amplitude of an oscillation: modulus of its analytic signal, smoothed forth and back."""
    amp = np.hypot(z, hysteretic(z))
    forth = low_pass(amp, dt, smooth)
    return np.asarray(low_pass(forth[::-1], dt, smooth)[::-1])
