"""Force-displacement loops of a sample that is moved to and fro: stiffness, damping, hysteresis.

The MRE paper's figures of a recording (eq. 2–6), cycle by cycle and with standard deviations. Each cycle of z
and F is fitted by a Fourier series in its own phase, which averages noise over the whole cycle where the
paper takes extremes of a moving average; the period may change slowly from cycle to cycle, as in a sweep.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from modelgen.errors import InputError

Array = np.ndarray[Any, np.dtype[np.float64]]
HARMONICS = 63  # of a cycle with samples enough: a loop has corners where the displacement turns
BINS = 1024  # phases to which the samples of a long cycle are averaged
FEWEST = 12  # samples of a cycle
GRID = 2048  # phases of a fitted cycle
LONGEST = np.pi / 4  # phase without a sample
NEAR = 0.3  # part of the amplitude within which a crossing of the middle is fitted
UNIT = {
    "f": "Hz", "A_z": "mm", "A_F": "N", "F_0": "N", "k_s": "N/mm", "c_s": "N*s/mm", "h_s": "N",
    "W": "N*mm", "c_loss": "N*s/mm", "loss_angle": "deg",
}  # fmt: skip
TEXT = {
    "f": "frequency",
    "A_z": "displacement amplitude",
    "A_F": "force amplitude",
    "F_0": "mean force",
    "k_s": "equivalent stiffness A_F/A_z (4)",
    "c_s": "A_F over the velocity's amplitude (5): k_s/(2πf), no damping in it",
    "h_s": "half the loop's width in the middle (6)",
    "W": "energy lost in a cycle, ∮F dz",
    "c_loss": "dashpot of the same loss, W/(2π²f A_z²)",
    "loss_angle": "loss angle of the fundamental",
}


@dataclass(frozen=True, eq=False)
class Loops:
    """Each figure, by its name in UNIT, in every cycle (cycles,) and its standard deviation (cycles,).

    z, F: the fitted cycles (cycles, GRID), from one upward crossing of the middle to the next; t: when each
    began [s]. Standard deviations are those of noise about the fitted cycle, correlated as it is found to be.
    """

    t: Array
    z: Array
    F: Array
    values: Mapping[str, Array]
    std: Mapping[str, Array]

    def mean(self, cycles: slice | np.ndarray = slice(None)) -> dict[str, tuple[float, float]]:
        """Mean of each figure over `cycles`, with the greater of two standard deviations: by the noise, and
        by the scatter of the cycles."""
        found = {}
        for name, all_values in self.values.items():
            values, std = all_values[cycles], self.std[name][cycles]
            m = values.size
            scatter = float(np.std(values, ddof=1)) if m > 1 else 0.0
            noise = float(np.sqrt(np.mean(std**2)))
            found[name] = (float(values.mean()), max(scatter, noise) / m**0.5)
        return found

    def swept(self, change: float = 0.05) -> bool:
        """Whether the frequency changes by more than `change` of itself from cycle to cycle."""
        return bool(np.ptp(self.values["f"]) > change * self.values["f"].mean())

    def groups(self, most: int = 12) -> list[np.ndarray]:
        """Indices of cycles of much the same frequency: up to `most` groups, equally wide in ln f."""
        x = np.log(self.values["f"])
        edges = np.linspace(x.min(), x.max(), most + 1)[1:-1]
        which = np.digitize(x, edges)
        return [np.flatnonzero(which == k) for k in np.unique(which)]


def measure_loops(t: Array, z: Array, F: Array, skip: int = 0) -> Loops:
    """Figures of every whole cycle after the first `skip`, from t [s], z [mm], F [N], each (n,).

    Raises InputError when there is no whole cycle, or too few samples in one.
    """
    starts = crossings(t, z)
    if starts.size < 2 + skip:
        raise InputError(
            f"{max(starts.size - 1, 0)} whole cycles of the displacement between {t[0]:g} s and {t[-1]:g} s, "
            f"at least {1 + skip} wanted"
        )
    cycles = [_cycle(t, z, F, a, b) for a, b in zip(starts[skip:-1], starts[skip + 1 :], strict=True)]
    names = list(UNIT)
    return Loops(
        starts[skip:-1],
        np.array([c[0] for c in cycles]),
        np.array([c[1] for c in cycles]),
        {n: np.array([c[2][n][0] for c in cycles]) for n in names},
        {n: np.array([c[2][n][1] for c in cycles]) for n in names},
    )


def crossings(t: Array, z: Array) -> Array:
    """Times at which z crosses its middle upwards, each from all samples near it: no noise makes a second."""
    middle, A = (z.max() + z.min()) / 2, np.ptp(z) / 2
    x = z - middle
    side = np.where(x > NEAR * A, 1, np.where(x < -NEAR * A, -1, 0))
    outside = np.flatnonzero(side)
    turns = np.flatnonzero(np.diff(side[outside]) == 2)
    found = []
    for k in turns:
        near = slice(int(outside[k]), int(outside[k + 1]) + 1)
        order = min(3, near.stop - near.start - 1)
        origin = t[near.start]
        found.append(origin + np.polyfit(x[near] / A, t[near] - origin, order)[-1])
    return np.array(found)


def _cycle(t: Array, z: Array, F: Array, begin: float, end: float) -> tuple[Array, Array, dict[str, Any]]:
    inside = slice(*np.searchsorted(t, [begin, end]))
    n = inside.stop - inside.start
    if n < FEWEST:
        raise InputError(f"{n} samples in the cycle at {begin:g} s, at least {FEWEST} wanted")
    if np.ptp(F[inside]) == 0:
        raise InputError(f"the force does not change in the cycle at {begin:g} s")
    theta, *channels = _averaged(2 * np.pi * (t[inside] - begin) / (end - begin), z[inside], F[inside])
    gap = float(np.max(np.diff(theta, prepend=theta[-1] - 2 * np.pi)))
    if gap > LONGEST:
        raise InputError(
            f"samples are missing in the cycle at {begin:g} s, over {gap / (2 * np.pi):.2g} of it"
        )
    count = min(HARMONICS, (theta.size - 4) // 4, int(np.pi / gap))
    basis = _basis(theta, count)
    inverse: Array = np.asarray(np.linalg.inv(basis.T @ basis), dtype=float)
    fits = [_Series(np.asarray(inverse @ (basis.T @ y)), basis, inverse, y) for y in channels]
    grid = _basis(np.linspace(0, 2 * np.pi, GRID, endpoint=False), count)
    return grid @ fits[0].c, grid @ fits[1].c, _figures(fits[0], fits[1], grid, 1 / (end - begin))


def _averaged(theta: Array, *channels: Array) -> list[Array]:
    """Phase and channels averaged to BINS phases where there are twice as many samples or more."""
    if theta.size < 2 * BINS:
        return [theta, *channels]
    which = np.minimum((theta * (BINS / (2 * np.pi))).astype(int), BINS - 1)
    count = np.bincount(which, minlength=BINS)
    there = count > 0
    return [np.asarray(np.bincount(which, x, BINS)[there] / count[there]) for x in (theta, *channels)]


class _Series:
    """Fourier coefficients c with the covariance that the residual implies."""

    def __init__(self, c: Array, basis: Array, inverse: Array, y: Array) -> None:
        e = y - basis @ c
        self.c, self.noise = c, float(e @ e) / (y.size - c.size) * _correlated(e)
        self.inverse = inverse

    def var(self, row: Array) -> float:
        """Variance of row · c."""
        return float(self.noise * (row @ self.inverse @ row))


def _correlated(e: Array) -> float:
    """By how much the variance of a mean exceeds that of independent samples: 1 + 2 Σ ρ_k up to the first
    correlation within chance."""
    total, n = 1.0, e.size
    power = float(e @ e)
    for k in range(1, n // 4):
        rho = float(e[:-k] @ e[k:]) / power if power else 0.0
        if rho < 2 / n**0.5:
            break
        total += 2 * rho
    return total


def _basis(theta: Array, count: int) -> Array:
    """1, cos θ … cos nθ, sin θ … sin nθ: (theta.size, 2 count + 1)."""
    angles = np.outer(theta, np.arange(1, count + 1))
    return np.hstack([np.ones((theta.size, 1)), np.cos(angles), np.sin(angles)])


def _figures(z: _Series, F: _Series, grid: Array, f: float) -> dict[str, tuple[float, float]]:
    """Every figure of one cycle with its standard deviation, to first order in the coefficients."""
    count = (z.c.size - 1) // 2
    n = np.arange(1, count + 1)
    zg, Fg = grid @ z.c, grid @ F.c
    span_z = (grid[zg.argmax()] - grid[zg.argmin()]) / 2
    span_F = (grid[Fg.argmax()] - grid[Fg.argmin()]) / 2
    A_z, A_F = float(span_z @ z.c), float(span_F @ F.c)
    u_z, u_F = z.var(span_z) ** 0.5, F.var(span_F) ** 0.5
    k_s = A_F / A_z
    # the velocity's amplitude is 2πf A_z for a sine; for any other motion it is that of the fitted one
    slope = np.hstack([0.0, n * z.c[1 + count :], -n * z.c[1 : 1 + count]])
    vg = grid @ slope
    A_v = 2 * np.pi * f * float(np.ptp(vg)) / 2
    span_v = (grid[vg.argmax()] - grid[vg.argmin()]) / 2
    span_v = np.hstack([0.0, -n * span_v[1 + count :], n * span_v[1 : 1 + count]])
    u_v = 2 * np.pi * f * z.var(span_v) ** 0.5
    h, u_h = _width(z, F, grid, count)
    lossy = np.pi * slope  # ∮F dz = π Σ n (p_n b_n − q_n a_n)
    W, u_W = float(lossy @ F.c), F.var(lossy) ** 0.5
    lost = 2 * np.pi**2 * f * A_z**2
    c_loss = W / lost
    ratio = complex(F.c[1], -F.c[1 + count]) / complex(z.c[1], -z.c[1 + count])
    unit = np.eye(F.c.size)
    u_angle = np.hypot(
        F.var(unit[1]) ** 0.5 / abs(complex(F.c[1], F.c[1 + count])),
        z.var(unit[1]) ** 0.5 / abs(complex(z.c[1], z.c[1 + count])),
    )
    return {
        "f": (f, 2**0.5 * f * z.var(grid[0]) ** 0.5 / (2 * np.pi * A_z)),
        "A_z": (A_z, u_z),
        "A_F": (A_F, u_F),
        "F_0": (float(F.c[0]), F.var(unit[0]) ** 0.5),
        "k_s": (k_s, float(np.hypot(u_F, k_s * u_z)) / A_z),
        "c_s": (A_F / A_v, float(np.hypot(u_F, u_v * A_F / A_v)) / A_v),
        "h_s": (h, u_h),
        "W": (W, u_W),
        "c_loss": (c_loss, float(np.hypot(u_W / lost, 2 * c_loss * u_z / A_z))),
        "loss_angle": (float(np.degrees(np.angle(ratio))), float(np.degrees(u_angle))),
    }


def _width(z: _Series, F: _Series, grid: Array, count: int) -> tuple[float, float]:
    """h_s (6): half of F where z rises through its middle, less F where it falls through it."""
    zg = grid @ z.c
    middle = (zg.max() + zg.min()) / 2
    above = zg >= middle
    angles = 2 * np.pi * np.arange(GRID) / GRID
    rows, slopes = [], []
    for way in (1, -1):
        k = int(np.flatnonzero((above.astype(int) - np.roll(above, 1).astype(int)) == way)[0])
        share = (middle - zg[k - 1]) / (zg[k] - zg[k - 1])
        theta = angles[k] - (1 - share) * 2 * np.pi / GRID
        row = _basis(np.array([theta]), count)[0]
        d = _basis(np.array([theta + 1e-5]), count)[0] - row
        rows.append(row)
        slopes.append(float(d @ F.c) / float(d @ z.c))
    value = float((rows[0] - rows[1]) @ F.c) / 2
    var = F.var(rows[0] - rows[1]) / 4 + z.var(slopes[0] * rows[0] - slopes[1] * rows[1]) / 4
    return value, float(var**0.5)


@dataclass(frozen=True)
class Shift:
    """Force after minus before at the same displacement [N]: mean and standard deviation, and the rms of what
    is not constant along the loop, over the force amplitude."""

    value: float
    std: float
    uneven: float


def shift(before: Loops, after: Loops) -> Shift:
    """The offset between two recordings of one motion, as residual magnetism makes it (MRE paper, sec. 3.4).

    Raises InputError when amplitudes or rates differ by more than 2 %: a stiffness, or a dashpot, would then
    pass for an offset.
    """
    a, b = before.mean(), after.mean()
    for name, what in (("A_z", "displacement amplitudes"), ("f", "frequencies")):
        first, second = a[name][0], b[name][0]
        if abs(second / first - 1) > 0.02:
            raise InputError(
                f"the {what} are {first:.4g} {UNIT[name]} and {second:.4g} {UNIT[name]}, two recordings of "
                "one motion are wanted"
            )
    apart = after.F.mean(axis=0) - before.F.mean(axis=0)
    value = b["F_0"][0] - a["F_0"][0]
    return Shift(value, float(np.hypot(a["F_0"][1], b["F_0"][1])), float(np.std(apart)) / a["A_F"][0])


def strain(z: Array, length: float) -> Array:
    """ε_s [%] (2), from the least displacement on: (z − min z)/d · 100; printed with + max z, the same for a
    displacement about 0."""
    return np.asarray((z - z.min()) / length * 100)


def stress(F: Array, area: float) -> Array:
    """σ_s [kPa] (3): F/a_s for F [N], a_s [mm²]."""
    return np.asarray(F / area * 1e3)
