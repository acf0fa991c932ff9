"""Natural frequencies and damping ratios from measured frequency responses.

Poles come from a rational model with one denominator for all responses, fitted by linear least squares in the
discrete-time variable (least-squares complex frequency-domain, Guillaume et al. 2003: PolyMAX for one
reference); those which stay as the order grows are physical. They are then refined by least squares on the
modal model

    H_o(ω) = Σ_r [A_or/(jω − λ_r) + Ā_or/(jω − λ̄_r)] + B_o + C_o ω,   λ_r = 2πf_r (−ξ_r + j√(1 − ξ_r²)),

in which all but the poles is linear and projected out (Golub & Pereyra 1973).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from modelgen.errors import InputError
from modelgen.fit.gauss_newton import GaussNewton
from modelgen.fit.problem import Matrix, Problem, Vector
from modelgen.recordings.frf import Frf

Array = np.ndarray[Any, np.dtype[Any]]

ORDERS = range(2, 33, 2)  # of the denominator
SAME_F, SAME_XI = 0.005, 0.1  # relative change from one order to the next of a pole that stays
STAYS = 5  # so many orders one after the other
DAMPED = 0.2  # damping ratios above this are no resonances


@dataclass(frozen=True)
class Mode:
    """A resonance: natural frequency f [Hz] and damping ratio ξ with standard deviations, and its share.

    share: rms of its part of the responses over the rms of the responses.
    """

    f: float
    f_std: float
    xi: float
    xi_std: float
    share: float

    def damping(self, mass: float, mass_std: float = 0.0) -> tuple[float, float]:
        """Viscous damping 2ξMω [N·s/m] of a mass M [kg] at this resonance, ω = 2πf, and its deviation.

        ω in rad/s: the GMM paper's R_d = 2ξM_dω_1 = 6.79 N·s/m has 1600 Hz in its place.
        """
        R = 2 * self.xi * mass * 2 * np.pi * self.f
        parts = (self.xi_std / self.xi, self.f_std / self.f, mass_std / mass)
        return float(R), float(R * np.sqrt(sum(p**2 for p in parts)))


@dataclass(frozen=True, eq=False)
class ModalFit:
    """Modes, lowest frequency first, and the fitted responses (responses, n) with their relative rms misfit.

    stable: (order, f, ξ) of every pole at every order, for a stabilisation diagram.
    """

    modes: tuple[Mode, ...]
    frf: Frf
    fitted: Array
    misfit: float
    poles: tuple[tuple[int, float, float], ...]


def fit_modes(frf: Frf, modes: int | None = None) -> ModalFit:
    """Fit the resonances in `frf`: those that stay as the order grows, or the `modes` strongest.

    Standard deviations come from the residual, frequency by frequency, so that noise may vary along the band
    and be common to all responses (a sandwich covariance with one cluster for each frequency).
    Raises InputError when there are too few samples, or no resonance.
    """
    f, H = frf.f, frf.H
    if modes is not None and modes < 1:
        raise InputError(f"{modes} modes are wanted, at least 1 is possible")
    if f.size < 8:
        raise InputError(f"{f.size} frequencies cannot determine a resonance, at least 8 are wanted")
    orders = [n for n in ORDERS if n <= f.size // 3]
    scale = np.sqrt(np.mean(np.abs(H) ** 2, axis=1, keepdims=True))
    by_order = {n: _poles(f, H / scale, n) for n in orders}
    found = _stable(by_order, f)
    if not found.size:
        raise InputError("no resonance: no pole stays the same as the order of the model grows")
    found = _strongest(f, H / scale, found, modes)
    theta, residual = _refined(f, H / scale, found)
    std = _std(f, H / scale, theta)
    order = np.argsort(theta[::2])
    shares = _shares(f, H / scale, theta)
    made = tuple(
        Mode(
            float(theta[2 * k]),
            float(std[2 * k]),
            float(theta[2 * k + 1]),
            float(std[2 * k + 1]),
            float(shares[k]),
        )
        for k in order
    )
    fitted = H - scale * residual
    poles = tuple((n, float(p[0]), float(p[1])) for n, ps in by_order.items() for p in ps)
    misfit = float(np.sqrt(np.mean(np.abs(residual) ** 2)))
    return ModalFit(made, frf, fitted, misfit, poles)


def _poles(f: Array, H: Array, order: int) -> Matrix:
    """(f, ξ) of the damped poles inside the band, (k, 2), of a rational model of one order."""
    low, span = f[0], f[-1] - f[0]
    dt = 1 / (2 * span * (1 + 1 / f.size))
    z = np.exp(2j * np.pi * np.outer(f - low, np.arange(order + 1)) * dt)
    M = np.zeros((order + 1, order + 1), complex)
    inverse = np.linalg.pinv(z)
    for h in H:
        Y = -h[:, None] * z
        rest = Y - z @ (inverse @ Y)
        M += rest.conj().T @ rest
    # the coefficient of z^0 is held at 1: mathematical poles then come out unstable, or heavily damped
    a = np.append(1.0, np.linalg.lstsq(M[1:, 1:], -M[1:, 0], rcond=1e-13)[0])
    lam = np.log(np.roots(a[::-1])) / dt + 2j * np.pi * low
    f_n, xi = np.abs(lam) / (2 * np.pi), -lam.real / np.abs(lam)
    physical = (xi > 0) & (xi < DAMPED) & (f_n > f[0]) & (f_n < f[-1]) & (lam.imag > 0)
    return np.stack([f_n[physical], xi[physical]], axis=1)


def _stable(by_order: dict[int, Matrix], f: Array) -> Matrix:
    """Poles (k, 2) that stay over STAYS orders, or all but one of fewer, as the last of these has them."""
    orders = list(by_order)
    wanted = min(STAYS, max(len(orders) - 1, 1))
    chains: list[tuple[int, Vector]] = []  # how long each pole of the order before has stayed
    found: list[Vector] = []
    for n in orders:
        grown = []
        for pole in by_order[n]:
            before = [length for length, p in chains if _same(p, pole)]
            grown.append((max(before, default=0) + 1, pole))
            if grown[-1][0] >= wanted:
                found = [q for q in found if abs(q[0] - pole[0]) > 2 * SAME_F * pole[0]] + [pole]
        chains = grown
    return np.array(found).reshape(-1, 2)


def _same(a: Vector, b: Vector) -> bool:
    return bool(abs(a[0] - b[0]) <= SAME_F * b[0] and abs(a[1] - b[1]) <= SAME_XI * b[1])


def _strongest(f: Array, H: Array, poles: Matrix, modes: int | None) -> Matrix:
    if modes is None:
        return poles
    if len(poles) < modes:
        raise InputError(f"{modes} modes are wanted, {len(poles)} resonances were found")
    shares = _shares(f, H, poles.ravel())
    return poles[np.argsort(shares)[::-1][:modes]]


def _basis(f: Array, theta: Vector) -> Array:
    """Columns (2n, 2k + 4), real and imaginary parts stacked: each mode's residue, constant and slope."""
    w = 2 * np.pi * f
    columns: list[Array] = []
    for f_n, xi in theta.reshape(-1, 2):
        lam = 2 * np.pi * f_n * (-xi + 1j * np.sqrt(1 - xi**2))
        a, b = lam.imag / (1j * w - lam), lam.imag / (1j * w - np.conj(lam))
        columns += [a + b, 1j * (a - b)]
    slope = (f - f.mean()) / (f[-1] - f[0])
    columns += [np.ones_like(a), 1j * np.ones_like(a), slope + 0j, 1j * slope]
    return np.concatenate([np.real(columns), np.imag(columns)], axis=1).T


def _stacked(H: Array) -> Array:
    return np.concatenate([H.real, H.imag], axis=1).T  # (2n, responses)


def _projected(f: Array, H: Array, theta: Vector) -> Array:
    """What the best linear part leaves of the responses, (2n, responses)."""
    y, Phi = _stacked(H), _basis(f, theta)
    Q, _ = np.linalg.qr(Phi)
    return np.asarray(y - Q @ (Q.T @ y))


def _shares(f: Array, H: Array, theta: Vector) -> Vector:
    y, Phi = _stacked(H), _basis(f, theta)
    c = np.linalg.lstsq(Phi, y, rcond=None)[0]
    parts = [Phi[:, 2 * k : 2 * k + 2] @ c[2 * k : 2 * k + 2] for k in range(theta.size // 2)]
    return np.array([np.sqrt(np.mean(p**2) / np.mean(y**2)) for p in parts])


def _problem(f: Array, H: Array, start: Vector) -> Problem:
    k = start.size // 2
    names = tuple(n for i in range(1, k + 1) for n in (f"f_{i}", f"xi_{i}"))
    wide = f[-1] - f[0]
    return Problem(
        names, ("Hz", "1") * k, np.array([f[0] - wide, 1e-7] * k), np.array([f[-1] + wide, 0.9] * k), start,
        residual=lambda theta: _projected(f, H, theta).ravel(), n_data=2 * H.size,
    )  # fmt: skip


def _refined(f: Array, H: Array, poles: Matrix) -> tuple[Vector, Array]:
    """θ = (f, ξ) of each mode by least squares, and the complex residual (responses, n)."""
    problem = _problem(f, H, poles.ravel())
    theta = GaussNewton().run(problem).theta
    r = _projected(f, H, theta).T
    return theta, r[:, : f.size] + 1j * r[:, f.size :]


def _std(f: Array, H: Array, theta: Vector) -> Vector:
    """Standard deviations (p,): A⁻¹ (Σ_f s_f s_fᵀ) A⁻¹ with A = JᵀJ and s_f the score of one frequency.

    Residuals are divided by 1 − leverage (HC3, MacKinnon & White 1985): a sharp resonance has few samples.
    """
    r, J = _problem(f, H, theta).jacobian(theta)
    linear = np.linalg.qr(_basis(f, theta))[0]
    leverage = np.sum(linear**2, axis=1)[:, None] + np.sum(np.linalg.qr(J)[0] ** 2, axis=1).reshape(
        -1, len(H)
    )
    r = r / np.maximum(1 - leverage, 0.1).ravel()
    score = (J * r[:, None]).reshape(2, f.size, -1, theta.size).sum(axis=(0, 2))
    A = np.linalg.inv(J.T @ J)
    return np.asarray(np.sqrt(np.diag(A @ (score.T @ score) @ A)))
