"""Linear elements as functions of angular frequency, each by other numerics than its textbook formula.

ω [rad/s] has shape (n,), results are complex with the same shape. e^{+jωt}: a passive element has Re Z >= 0.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt
from scipy.special import ive, j1, struve

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]


def springpot(w: Array, alpha: float, w0: float) -> Complex:
    """(jω/ω0)^α, 0 < α < 1, as the sum of its relaxations: sin(πα)/π ∫ jω/(jω+s) s^{α-1} ds, s = e^u.

    The trapezoidal rule in u converges like exp(-π²/step): 3e-10 here.
    """
    return _relaxations(np.ascontiguousarray(w, dtype=float).tobytes(), float(alpha), float(w0))


@lru_cache(maxsize=32)  # a base that is fitted beside it asks for the same again and again
def _relaxations(omega: bytes, alpha: float, w0: float) -> Complex:
    w = np.frombuffer(omega)
    step, reach = 0.45, 25.0
    u = np.arange(-reach / alpha, reach / (1 - alpha), step)
    above, below = np.maximum(u, 0), np.minimum(u, 0)  # either part alone stays finite
    weight = np.sin(np.pi * alpha) / np.pi * step * np.exp(alpha * u - above)
    x = 1j * w / w0
    found = np.asarray([(weight * (xi / (xi * np.exp(-above) + np.exp(below)))).sum() for xi in x])
    found.flags.writeable = False
    return found


def cole_cole(w: Array, tau: float, a: float) -> Complex:
    """1/(1+(jωτ)^a), 0 < a < 1, as Debye relaxations spread over ln τ (Cole and Cole 1941, eq. 19)."""
    u = np.arange(-30 / a, 30 / a, 0.4)
    weight = 0.4 / (2 * np.pi) * np.sin(a * np.pi) / (np.cosh(a * u) + np.cos(a * np.pi))
    return np.asarray([(weight / (1 + 1j * wi * tau * np.exp(u))).sum() for wi in w])


def round_wire(x2: Complex) -> Complex:
    """Internal impedance of a round wire over its dc resistance, x I0(x)/(2 I1(x)), x² = jωμσa²."""
    x = np.sqrt(np.where(x2 == 0, 1e-12j, x2))
    return np.asarray(x * ive(0, x) / (2 * ive(1, x)))


def proximity(x2: Complex, layers: float) -> Complex:
    """Dowell's winding of foils over its dc resistance: x coth x + 2(m²-1)/3 x tanh(x/2)."""
    x = np.sqrt(np.where(x2 == 0, 1e-12j, x2))
    return np.asarray(x / np.tanh(x) + 2 * (layers**2 - 1) / 3 * x * np.tanh(x / 2))


def solid_core(x2: Complex) -> Complex:
    """Flux in a solid cylinder over its static value, 2 I1(x)/(x I0(x)), x² = jω/ω_c."""
    x = np.sqrt(np.where(x2 == 0, 1e-12j, x2))
    return np.asarray(2 * ive(1, x) / (x * ive(0, x)))


def shorted_turn(w: Array, L: float, k2: float, rate: float) -> Complex:
    """Impedance of a coil, L [H], with a turn shorted at coupling k², from its two mesh equations.

    `rate` = R/L of the turn [1/s]. k² = 1 is an inductance shunted by rate·L.
    """
    mesh = np.zeros((len(w), 2, 2), complex)
    mesh[:, 0, 0] = 1j * w * L
    mesh[:, 0, 1] = mesh[:, 1, 0] = 1j * w * L * np.sqrt(k2)
    mesh[:, 1, 1] = (rate + 1j * w) * L
    drive = np.zeros((len(w), 2, 1), complex)
    drive[:, 0, 0] = 1
    return np.asarray(1 / np.linalg.solve(mesh, drive)[:, 0, 0])


def piston(w: Array, a: float, c: float) -> Complex:
    """Radiation impedance of a baffled piston of radius a over ρcS: 1 - J1(2ka)/ka + j H1(2ka)/ka."""
    ka = w * a / c
    return np.asarray(1 - j1(2 * ka) / ka + 1j * struve(1, 2 * ka) / ka)


def sphere(w: Array, a: float, c: float) -> Complex:
    """Radiation impedance of a pulsating sphere of radius a over ρcS: jka/(1+jka)."""
    ka = w * a / c
    return np.asarray(1j * ka / (1 + 1j * ka))


def chain(w: Array, stiffness: complex, mass: complex, doublings: int = 8) -> Complex:
    """Transfer matrix (n, 2, 2) of a rod as 2^doublings lumped cells, from (v, F) at one end to the other.

    `stiffness` A/(lS) [N/m] may be complex (a lossy rod), `mass` [kg] is the whole rod's. Each cell is half a
    spring, a mass and half a spring; squaring the matrix doubles the length. Error about
    (kl)²/24/4^doublings.
    """
    n = 2**doublings
    half = 0.5 * 1j * w / (stiffness * n)  # mobility of half a cell's spring
    z = 1j * w * mass / n
    cell = np.empty((len(w), 2, 2), complex)
    cell[:, 0, 0] = cell[:, 1, 1] = 1 + half * z
    cell[:, 0, 1] = half * (2 + half * z)
    cell[:, 1, 0] = z
    for _ in range(doublings):
        cell = cell @ cell
    return cell


def rod_free(w: Array, stiffness: complex, mass: complex) -> Complex:
    """Impedance F/v at one end of a rod whose other end is free; jω mass for a rigid one."""
    m = chain(w, stiffness, mass)
    return np.asarray(m[:, 1, 0] / m[:, 0, 0])


def rod_clamped(w: Array, stiffness: complex, mass: complex) -> Complex:
    """Impedance F/v at one end of a rod whose other end is held; stiffness/(jω) for a massless one."""
    m = chain(w, stiffness, mass)
    return np.asarray(m[:, 1, 1] / m[:, 0, 1])


def resonator(w: Array, mass: float, w0: float, q: float) -> Complex:
    """Impedance at the foot of a mass on a spring and damper, by eliminating its own equation of motion."""
    k, r = mass * w0**2, mass * w0 / q
    link = r + k / (1j * w)
    return np.asarray(link - link**2 / (1j * w * mass + link))
