"""Noise of the recordings: how large, how it is stated, how it whitens, and how it is added.

`Z_relative` is the standard deviation of each of Re Z and Im Z over |Z|; a calibration error multiplies Z by
1 + ε, with Re ε and Im ε Gaussian processes over ln f of the given rms and correlation length, the same in
all sweeps ("shared" = 1, one instrument) or a new one in each.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.linalg import cholesky, solve_triangular
from scipy.signal import lfilter

from .solve import Responses, Whitener

Array = npt.NDArray[np.float64]
Levels = Mapping[str, float]


def _log_uniform(rng: np.random.Generator, lo: float, hi: float) -> float:
    return float(np.exp(rng.uniform(np.log(lo), np.log(hi))))


def draw_levels(rng: np.random.Generator, domain: str, noise: str) -> dict[str, float]:
    """Figures of one kind of noise. "stated" is the factor of the stated level, 0 where none is stated."""
    levels: dict[str, float] = {}
    if domain == "gmm":
        levels["Z_relative"] = 2e-4
    elif domain == "impedance":
        levels["Z_relative"] = _log_uniform(rng, 2e-4, 3e-3)
    elif domain == "force":
        levels["F_m"] = 1.85e-3 if rng.random() < 0.5 else _log_uniform(rng, 1e-3, 1e-2)
        levels["z"] = {"displacement": _log_uniform(rng, 4e-4, 5e-3), "clean": 0.0}.get(noise, 2.88e-4)
    else:
        levels["k_s"] = _log_uniform(rng, 5e-4, 5e-3)
        levels["loss_angle"] = _log_uniform(rng, 0.02, 0.2)
    levels["stated"] = float(rng.random() < 0.5 or noise == "calibration")
    if noise == "misstated":
        levels["stated"] = float(rng.choice([0.5, 2.0]))
    elif noise == "outliers":
        levels["share"] = 0.01
    elif noise == "quantised":
        levels["step"] = float(rng.uniform(1, 3))  # in standard deviations
    elif noise == "calibration" or (noise == "coloured" and domain in ("impedance", "gmm")):
        levels["calibration"] = levels["Z_relative"] * _log_uniform(rng, 0.5, 5)
        levels["length"] = float(rng.uniform(0.5, 1.2)) * (0.3 if domain == "gmm" else 1.0)
        levels["shared"] = float(rng.random() < 0.5)
    elif noise == "coloured":
        levels["rho"] = float(rng.choice([0.5, 0.8, 0.9, 0.95, 0.98]))
    return levels


def stated(domain: str, noise: str, levels: Levels) -> dict[str, Any]:
    """The [noise] table of the case."""
    factor: float = levels["stated"]
    out: dict[str, Any] = {}
    if factor:
        names = {"force": ("F_m", "z"), "stiffness": ("k_s", "loss_angle")}.get(domain, ("Z_relative",))
        grown = np.sqrt(1 + levels.get("step", 0.0) ** 2 / 12)
        out = {n: float(f"{levels[n] * factor * grown:.4g}") for n in names if levels[n]}
    if noise == "calibration":
        out["Z_calibration"] = [float(f"{levels['calibration']:.4g}"), float(f"{levels['length']:.4g}")]
    return out


def _kernel(lnf: Array, levels: Levels) -> Array:
    d = (lnf[:, None] - lnf[None, :]) / levels["length"]
    return np.asarray(levels["calibration"] ** 2 * np.exp(-0.5 * d**2))


def sweep_whitener(frequencies: Sequence[Array], levels: Levels) -> Whitener:
    """Whiten the relative misfit (Z - Z_base)/Z of the fit sweeps under white noise and calibration error."""
    sigma = levels["Z_relative"] * np.sqrt(1 + levels.get("step", 0.0) ** 2 / 12)
    n = [len(f) for f in frequencies]
    factor: Array | None = None
    if levels.get("calibration"):
        lnf = np.log(np.concatenate(frequencies))
        same = np.repeat(np.arange(len(n)), n)
        one = levels["shared"] or same[:, None] == same[None, :]
        factor = cholesky(_kernel(lnf, levels) * one + sigma**2 * np.eye(len(lnf)), lower=True)

    def whiten(y: Responses, base: Responses) -> Array:
        e = np.concatenate([(a - b) / a for a, b in zip(y[: len(n)], base[: len(n)], strict=True)])
        e = e / sigma if factor is None else solve_triangular(factor, e, lower=True)
        return np.concatenate([e.real, e.imag])

    return whiten


def white_sweep(f: Array, levels: Levels, e: Array, data: Array) -> Array:
    """A residual e of one recorded sweep, both (2, n): Re and Im [ohm], over the sweep's noise and without
    the correlation that a smooth error of the instrument has."""
    Z = data[0] + 1j * data[1]
    return sweep_whitener([f], levels)([Z], [Z - (e[0] + 1j * e[1])]).reshape(2, -1)


def calibration(
    rng: np.random.Generator, frequencies: Sequence[Array], drawn: int, levels: Levels
) -> list[npt.NDArray[Any]]:
    """A smooth complex error for each sweep, interpolated from one dense draw where all share it.

    Beyond the band of the first `drawn` sweeps it stays as it is at the band's ends.
    """
    if not levels.get("calibration"):
        return [np.zeros(len(f)) for f in frequencies]
    first = frequencies[:drawn]
    lo, hi = np.log(min(f.min() for f in first)), np.log(max(f.max() for f in first))
    grid = np.linspace(lo, hi, 400)
    root = np.linalg.cholesky(_kernel(grid, levels) + (1e-5 * levels["calibration"]) ** 2 * np.eye(len(grid)))
    out: list[npt.NDArray[Any]] = []
    for f in frequencies:
        if not (levels["shared"] and out):
            error = root @ (rng.standard_normal(len(grid)) + 1j * rng.standard_normal(len(grid)))
        out.append(np.interp(np.log(f), grid, error.real) + 1j * np.interp(np.log(f), grid, error.imag))
    return out


def _gross(rng: np.random.Generator, n: int, share: float) -> Array:
    """Gross errors, 8 to 60 standard deviations, at a share of the samples, zero elsewhere."""
    hit = rng.random(n) < share
    return np.asarray(hit * rng.choice([-1.0, 1.0], n) * np.exp(rng.uniform(np.log(8), np.log(60), n)))


def disturb_impedance(
    rng: np.random.Generator, smooth: npt.NDArray[Any], z: npt.NDArray[Any], levels: Levels
) -> npt.NDArray[Any]:
    """A recorded impedance [ohm], with a `smooth` relative error and noise."""
    n, sigma = len(z), levels["Z_relative"]
    e = rng.standard_normal(n) + 1j * rng.standard_normal(n)
    if levels.get("share"):
        e = e + _gross(rng, n, levels["share"]) * np.exp(1j * rng.uniform(0, 2 * np.pi, n))
    noisy = z * (1 + smooth) + sigma * np.abs(z) * e
    if levels.get("step"):  # an instrument with ranges of a factor of two
        step = levels["step"] * sigma * 2 ** np.floor(np.log2(np.abs(z)) + 0.5)
        noisy = step * (np.round(noisy.real / step) + 1j * np.round(noisy.imag / step))
    return np.asarray(noisy)


def disturb_real(rng: np.random.Generator, y: Array, sigma: float, levels: Levels) -> Array:
    """One recorded real channel: white or AR(1) noise of std sigma, gross errors, ADC steps."""
    rho = levels.get("rho", 0.0)
    e = lfilter([np.sqrt(1 - rho**2)], [1, -rho], rng.standard_normal(len(y) + 400))[400:]
    e = e + _gross(rng, len(y), levels.get("share", 0.0))
    noisy = y + sigma * e
    if levels.get("step"):
        step = levels["step"] * sigma
        noisy = step * np.round(noisy / step)
    return np.asarray(noisy)
