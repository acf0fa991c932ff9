"""What is left of sweeps, described without a catalogue: resonant atoms at each port, by matching pursuit
beside the fit's own sensitivities."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache, lru_cache

import numpy as np

from modelgen.diagnose.gate.gains import CHECKED, gain_of, noise_of, parted
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import COLOUR_SWEEP
from modelgen.diagnose.search.screen import Tangent
from modelgen.fit.pool import slices
from modelgen.fit.whitener import Array

SPARE = 10
"""Values beyond parameters and amounts that a description must leave: fewer are met by anything."""
AT_ONCE = 4_000_000
"""Numbers of whitened atoms that are held at once: those of a sweep of some 2500 samples."""
Place = tuple[float, float]
"""Frequency and Q of an atom."""


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
        places = _places(f)

        def columns(some: Sequence[Place], slope: Array = slope) -> Array:
            atoms = [whitened(judge, e.series, slope[:, None] * _atom(f, *place)) for place in some]
            return np.concatenate(atoms, axis=1)

        likest = _likest(tangent, places, columns)
        at: list[Place] = []
        chosen = np.zeros((len(tangent.r), 0))
        r = tangent.r
        best = Leftover(0.0, 0.0, port, "")
        for count in range(1, 5):
            if n - fit.parameters - 2 * count < SPARE:
                break
            place = likest(r)
            if place not in at:
                at.append(place)
                chosen = np.concatenate([chosen, columns([place])], axis=1)
            price = 2.0 * count * np.log(len(places))
            gain, chi2, left = gain_of(tangent, chosen, n, price)
            if gain > max(best.gain, CHECKED):  # coloured noise has peaks, too
                own = before() - noise_of(judge, parted(left, fit.white), COLOUR_SWEEP)[0]
                gain = min(gain, own - chosen.shape[1] * float(np.log(n)) - price)
            if gain > best.gain:
                where = ", ".join(f"{f0:.4g}" for f0, _ in at)
                says = f"resonant terms near {where} Hz at the {port} port"
                best = Leftover(gain, chi2, port, says, tuple(at))
            u, _ = np.linalg.qr(tangent.off(chosen))
            r = tangent.r - u @ (u.T @ tangent.r)
        found.append(best)
    return found


def _likest(
    tangent: Tangent, places: Sequence[Place], columns: Callable[[Sequence[Place]], Array]
) -> Callable[[Array], Place]:
    """Tells where the atom is that explains most of a residual, beside the fit's own sensitivities.

    Atoms of all places at once take 60 kB a sample, so where there are many samples they are made in slices,
    anew for each residual.
    """
    parts = slices(len(places), -(-2 * len(places) * len(tangent.r) // AT_ONCE))

    @lru_cache(maxsize=1)  # of one slice alone there is nothing to make anew
    def apart(k: int) -> tuple[Array, Array]:
        whole = columns(places[parts[k]])
        rest = tangent.off(whole)
        size = np.sum(rest**2, axis=0)
        size[size < 1e-12 * np.sum(whole**2, axis=0)] = np.inf
        return rest, size

    def explained(k: int, r: Array) -> Array:
        rest, size = apart(k)
        return np.asarray((rest.T @ r) ** 2 / size)

    def likest(r: Array) -> Place:
        gains = np.concatenate([explained(k, r) for k in range(len(parts))])
        return places[int(np.argmax(gains)) // 2]

    return likest


def _places(f: Array) -> list[Place]:
    """Where resonances are tried, the closer the sharper they are."""
    decades = float(np.log(f.max() / f.min()))
    return [
        (float(f0), Q)
        for Q in (2.0, 8.0, 30.0, 120.0)
        for f0 in np.geomspace(f.min(), f.max(), int(np.clip(decades * Q, 12, 150)))
    ]


def _atom(f: Array, f0: float, Q: float) -> Array:
    """A complex unit atom 1/(1 + jQ(f/f0 − f0/f)), also times j: columns of an amplitude and its
    quadrature."""
    atom = 1 / (1 + 1j * Q * (f / f0 - f0 / f))
    return np.stack([atom, 1j * atom], axis=1)


def whitened(judge: Judge, series: Sequence[object], z: Array) -> Array:
    """Whitened columns (N, k) of complex changes z (samples, k) of the output."""
    at, out = 0, []
    for s, w in zip(series, judge.whiteners, strict=True):
        part = z[at : at + s.n].T  # type: ignore[attr-defined]
        at += s.n  # type: ignore[attr-defined]
        white = w.apply(np.stack([part.real, part.imag]))  # (2, k, n)
        out.append(white.transpose(0, 2, 1).reshape(-1, z.shape[1]))
    return np.concatenate(out)
