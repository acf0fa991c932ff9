"""Local polynomials on a uniform grid (Savitzky and Golay, Anal. Chem. 36 (1964) 1627), ends included."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

Array = NDArray[np.float64]

DIRECT = 32  # kernels up to this length are applied directly, longer ones by FFT


@dataclass(frozen=True)
class LocalFit:
    """Local polynomial fits at n samples, per sample step.

    value: z, z', z'', shape (3, n). gain: their std per unit std of white noise, shape (3, n).
    excess: coefficients of the next two orthonormal polynomials, shape (2, n): white noise of unit gain where
    the fit is good, more where it isn't. reach: the largest excess per unit of bounded noise. beyond: what
    these two would add to `value`, and doubt: its std per unit std of white noise, both (3, n).
    """

    value: Array
    gain: Array
    excess: Array
    reach: float
    beyond: Array
    doubt: Array


@cache
def _basis(length: int, degree: int) -> tuple[Array, Array, Array, Array]:
    """(q, b, more, b_more) on a window: orthonormal polynomials, shape (length, p); their derivatives of
    order 0 to 2 per sample step, shape (3, length, p); the next two polynomials, shape (length, 2 or less),
    and theirs."""
    x = np.linspace(-1.0, 1.0, length)
    q, r = np.linalg.qr(legendre.legvander(x, min(degree + 2, length - 1)))
    p, every = degree + 1, r.shape[0]
    inverse = np.linalg.inv(r)
    step = 2.0 / (length - 1)
    b = np.zeros((3, length, every))
    for k in range(min(3, every)):
        b[k] = legendre.legval(x, legendre.legder(np.eye(every), k)).T @ inverse * step**k
    return q[:, :p], b[:, :, :p], q[:, p:], b[:, :, p:]


@cache
def kernels(length: int, degree: int) -> Array:
    """(3, length) weights of a window's samples in the value, slope and curvature at its middle, per sample
    step."""
    q, b, _, _ = _basis(length, degree)
    return np.asarray(b[:, length // 2] @ q.T)


def local_fit(z: Array, length: int, degree: int) -> LocalFit:
    """Fit a polynomial to the `length` samples around each sample; near the ends, to the first or last ones.

    z: shape (n,), n >= length > degree.
    """
    n, half = z.size, length // 2
    q, b, more, b_more = _basis(length, degree)
    value, gain, excess = np.empty((3, n)), np.empty((3, n)), np.zeros((more.shape[1], n))
    beyond, doubt = np.empty((3, n)), np.empty((3, n))
    norm, norm_more = np.linalg.norm(b, axis=2), np.linalg.norm(b_more, axis=2)
    head = slice(0, half), z[:length], slice(0, half)
    tail = slice(n - half, n), z[n - length :], slice(length - half, length)
    for part, window, samples in (head, tail):
        value[:, part] = b[:, samples] @ (q.T @ window)
        gain[:, part], doubt[:, part] = norm[:, samples], norm_more[:, samples]
        excess[:, part] = (more.T @ window)[:, None]
        beyond[:, part] = b_more[:, samples] @ (more.T @ window)
    if length % 2:
        inner = slice(half, n - half)
        found = _correlate(z, np.concatenate([kernels(length, degree), more.T]))
        value[:, inner], excess[:, inner] = found[:3], found[3:]
        gain[:, inner], doubt[:, inner] = norm[:, half, None], norm_more[:, half, None]
        beyond[:, inner] = b_more[:, half] @ excess[:, inner]
    reach = float(np.abs(more).sum(axis=0).max(initial=0.0))
    return LocalFit(value, gain, excess, reach, beyond, doubt)


def _correlate(z: Array, kernels: Array) -> Array:
    """Each kernel, shape (k, m), along z, where it fits whole: shape (k, n - m + 1)."""
    m, count = kernels.shape[1], z.size - kernels.shape[1] + 1
    if m <= DIRECT:
        return np.array([np.correlate(z, kernel, "valid") for kernel in kernels])
    size = 1 << int(np.ceil(np.log2(4 * m)))
    hop = size - m + 1
    blocks = -(-count // hop)
    padded = np.zeros((blocks - 1) * hop + size)
    padded[: z.size] = z
    spectrum = np.fft.rfft(np.lib.stride_tricks.sliding_window_view(padded, size)[::hop], axis=1)
    turned = np.conj(np.fft.rfft(kernels, size, axis=1))
    return np.array([np.fft.irfft(spectrum * h, size, axis=1)[:, :hop].ravel()[:count] for h in turned])
