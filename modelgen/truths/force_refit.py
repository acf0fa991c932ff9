"""The modified Dahl model nearest to a force: linear in all but ρ, which is searched for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize_scalar
from scipy.signal import lfilter

from . import friction
from .drive import Array, Motion
from .solve import Refit, Responses

LINEAR = ("k_D", "c_D", "h_D", "F_0")
NO_FORCE = 1e-9
"""Share of the largest variance of a record's force below which it is rounding."""


class Columns:
    """The regressors of F = k z + c ż + h r(ρ) + F_0 over the fit records, whitened.

    A record that begins in mid-motion has an unknown r_0: r is affine in it, so h r_0 is linear too.
    """

    def __init__(
        self,
        base: Mapping[str, float],
        motions: Sequence[Motion],
        levels: Mapping[str, float],
        own_offset: bool,
    ) -> None:
        self.base, self.motions, self.levels, self.own_offset = base, motions, levels, own_offset
        self.rho_ar = levels.get("rho", 0.0)
        self.paths = [self._thin(m) for m in motions]
        self.fixed = self._fixed()

    @staticmethod
    def _thin(m: Motion) -> tuple[Array, npt.NDArray[np.intp]]:
        """The path at the recorded samples and at the reversals between them, and where the samples are."""
        sampled = m.keep[m.start :: m.over]
        turns = np.setdiff1d(np.arange(len(m.path)), m.keep)
        index = np.union1d(sampled, turns[turns > sampled[0]])
        return m.path[index], np.searchsorted(index, sampled)

    def _spectrum(self, rate: float, n: int) -> Array:
        """Standard deviation [N] over frequency of a record's errors, without the force noise's colour.

        An error of the displacement acts through spring, slip and dashpot, |k + j ω c|: at high frequencies
        the dashpot's share is by far the largest.
        """
        omega, levels = 2 * np.pi * rate * np.fft.rfftfreq(n), self.levels
        k = self.base["k_D"] + 0.5 * self.base["h_D"] * self.base["rho"]
        through = np.abs((k + 1j * omega * self.base["c_D"]) * levels["z"]) ** 2
        force = levels["F_m"] ** 2 * (1 + levels.get("step", 0.0) ** 2 / 12)
        uncoloured = np.abs(1 - self.rho_ar * np.exp(-1j * omega / rate)) ** 2
        return np.sqrt(force * (1 - self.rho_ar**2) + through * uncoloured)

    def white(self, rate: float, x: Array) -> Array:
        """Residual forces [N] of a record, over the noise and without its colour."""
        x = np.asarray(lfilter([1.0, -self.rho_ar], [1.0], x))
        return np.asarray(np.fft.irfft(np.fft.rfft(x) / self._spectrum(rate, len(x)), len(x)))

    def _white(self, parts: Sequence[Array]) -> Array:
        return np.concatenate([self.white(m.rate, x) for m, x in zip(self.motions, parts, strict=True)])

    def _only(self, i: int, x: Array) -> Array:
        return self._white([x if j == i else np.zeros(len(k)) for j, (_, k) in enumerate(self.paths)])

    def _fixed(self) -> list[Array]:
        """Columns of k_D, c_D and the offsets: one shared, or one a record."""
        zv = [[m.recorded(x) for x in m.zva[:2]] for m in self.motions]
        columns = [self._white([x[0] for x in zv]), self._white([x[1] for x in zv])]
        ones = [np.ones(len(x[0])) for x in zv]
        columns += [self._only(i, x) for i, x in enumerate(ones)] if self.own_offset else [self._white(ones)]
        return columns

    def _friction(self, rho: float) -> list[Array]:
        """Columns of h_D and of each unknown h_D r_0."""
        parts = [friction.dahl(x, rho)[k] for x, k in self.paths]
        columns = [self._white(parts)]
        for i, (m, (x, k)) in enumerate(zip(self.motions, self.paths, strict=True)):
            if m.pre:
                columns.append(self._only(i, np.exp(-rho * friction.travelled(x))[k]))
        return columns

    def refit(self, y: Responses) -> Refit:
        n = len(self.motions)
        target = self._white(y[:n])

        def solve(log_rho: float) -> tuple[Array, Array, Array]:
            X = np.column_stack([*self._friction(float(np.exp(log_rho))), *self.fixed])
            norm = np.linalg.norm(X, axis=0)
            X /= np.where(norm, norm, 1)
            q, *_ = np.linalg.lstsq(X.T @ X, X.T @ target, rcond=1e-15)
            q += np.linalg.lstsq(X.T @ X, X.T @ (target - X @ q), rcond=1e-15)[0]
            miss = target - X @ q
            return miss, q / np.where(norm, norm, 1), X * norm

        def d2(log_rho: float) -> float:
            return float(np.sum(solve(log_rho)[0] ** 2))

        at = np.log(self.base["rho"])
        best = minimize_scalar(
            d2,
            bounds=(at - 2, at + 2),
            method="bounded",
            options={"xatol": 1e-7, "maxiter": 60},
        )
        log_rho = min((at, float(best.x)), key=d2)
        left, q, X = solve(log_rho)
        lost = self._force(left)
        pairs = [(np.var(e), np.var(f)) for e, f in zip(lost, y, strict=False)]
        # a record in which a clearance takes up all of the motion has no force to lose
        least = NO_FORCE * max(f for _, f in pairs)
        r2 = 1 - float(np.mean([e / f for e, f in pairs if f > least]))
        return Refit(left, r2, self._bent(q, log_rho), self._std(q, X, log_rho))

    def _force(self, white: Array) -> list[Array]:
        """The records' forces [N] of whitened ones."""
        ends = np.cumsum([len(k) for _, k in self.paths])[:-1]
        spectra = (self._spectrum(m.rate, len(k)) for m, (_, k) in zip(self.motions, self.paths, strict=True))
        parts = zip(np.split(white, ends), spectra, strict=True)
        coloured = [np.fft.irfft(np.fft.rfft(x) * s, len(x)) for x, s in parts]
        return [np.asarray(lfilter([1.0], [1.0, -self.rho_ar], x)) for x in coloured]

    def _places(self) -> dict[str, int]:
        """Where the parameters are among the columns."""
        first = 1 + sum(bool(m.pre) for m in self.motions)
        return {"h_D": 0, "k_D": first, "c_D": first + 1} | ({} if self.own_offset else {"F_0": first + 2})

    def _bent(self, q: Array, log_rho: float) -> dict[str, float]:
        bent = {n: float(np.log(max(q[i] / self.base[n], 1e-3))) for n, i in self._places().items()}
        return bent | {"rho": float(log_rho - np.log(self.base["rho"]))}

    def _std(self, q: Array, X: Array, log_rho: float) -> dict[str, float]:
        """Standard deviations of the logarithms, all other parameters free."""
        up, down = (self._friction(float(np.exp(log_rho + s))) for s in (1e-4, -1e-4))
        slope = sum(qi * (a - b) / 2e-4 for qi, a, b in zip(q, up, down, strict=False))
        J = np.column_stack([X, slope])
        norm = np.linalg.norm(J, axis=0)
        norm = np.where(norm, norm, 1)
        std = np.sqrt(np.clip(np.diag(np.linalg.pinv((J / norm).T @ (J / norm))), 0, None)) / norm
        found = {n: float(std[i] / max(abs(q[i]), 1e-12)) for n, i in self._places().items()}
        return found | {"rho": float(std[-1])}
