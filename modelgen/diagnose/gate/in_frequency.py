"""What is left of sweeps, described without a catalogue: resonant atoms at each port, by matching pursuit
beside the fit's own sensitivities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np

from modelgen.diagnose.gate.gains import CHECKED, gain_of, noise_of, parted
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import COLOUR_SWEEP
from modelgen.diagnose.search.screen import Tangent
from modelgen.fit.whitener import Array

SPARE = 10
"""Values beyond parameters and amounts that a description must leave: fewer are met by anything."""


def in_frequency(
    judge: Judge, fit: Fit, tangent: Tangent, sensitivities: Mapping[str, Array]
) -> list[Leftover]:
    e = fit.hypothesis.experiment
    if any(s.measure != "complex" for s in e.series):
        return []
    axis = e.model.axis
    f = np.concatenate([s.inputs[axis] for s in e.series])
    n = effective(fit.white)
    before = cache(lambda: noise_of(judge, fit.white, COLOUR_SWEEP)[0])
    found = []
    for port, slope in sensitivities.items():
        atoms, places = _resonances(f)
        columns = np.concatenate([whitened(judge, e.series, slope[:, None] * a) for a in atoms], axis=1)
        rest = tangent.off(columns)
        size = np.sum(rest**2, axis=0)
        size[size < 1e-12 * np.sum(columns**2, axis=0)] = np.inf
        chosen: list[int] = []
        r = tangent.r
        best = Leftover(0.0, 0.0, port, "")
        for count in range(1, 5):
            if n - fit.parameters - 2 * count < SPARE:
                break
            k = int(np.argmax((rest.T @ r) ** 2 / size))
            pair = [k - k % 2, k - k % 2 + 1]
            chosen += [c for c in pair if c not in chosen]
            price = 2.0 * count * np.log(len(places))
            gain, chi2, left = gain_of(tangent, columns[:, chosen], n, price)
            if gain > max(best.gain, CHECKED):  # coloured noise has peaks, too
                own = before() - noise_of(judge, parted(left, fit.white), COLOUR_SWEEP)[0]
                gain = min(gain, own - len(chosen) * float(np.log(n)) - price)
            if gain > best.gain:
                at = tuple(places[c // 2] for c in chosen[::2])
                where = ", ".join(f"{f0:.4g}" for f0, _ in at)
                best = Leftover(gain, chi2, port, f"resonant terms near {where} Hz at the {port} port", at)
            u, _ = np.linalg.qr(rest[:, chosen])
            r = tangent.r - u @ (u.T @ tangent.r)
        found.append(best)
    return found


def _resonances(f: Array) -> tuple[list[Array], list[tuple[float, float]]]:
    """Complex unit atoms 1/(1 + jQ(f/f0 − f0/f)), each also times j: columns of an amplitude and its
    quadrature."""
    atoms: list[Array] = []
    places: list[tuple[float, float]] = []
    decades = float(np.log(f.max() / f.min()))
    for Q in (2.0, 8.0, 30.0, 120.0):
        for f0 in np.geomspace(f.min(), f.max(), int(np.clip(decades * Q, 12, 150))):
            atom = 1 / (1 + 1j * Q * (f / f0 - f0 / f))
            atoms.append(np.stack([atom, 1j * atom], axis=1))
            places.append((float(f0), Q))
    return atoms, places


def whitened(judge: Judge, series: Sequence[object], z: Array) -> Array:
    """Whitened columns (N, k) of complex changes z (samples, k) of the output."""
    at, out = 0, []
    for s, w in zip(series, judge.whiteners, strict=True):
        part = z[at : at + s.n].T  # type: ignore[attr-defined]
        at += s.n  # type: ignore[attr-defined]
        white = w.apply(np.stack([part.real, part.imag]))  # (2, k, n)
        out.append(white.transpose(0, 2, 1).reshape(-1, z.shape[1]))
    return np.concatenate(out)
