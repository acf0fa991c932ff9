"""What is left, described without a catalogue: which variables the remaining residual depends on, and at
which port.

Frequency: resonant atoms at each port, by matching pursuit beside the fit's own sensitivities. Time:
functions of few variables, linear and hysteretic memories, lines of a spectrum. All under the noise as it is
judged, colour included.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from modelgen.diagnose.gate.functions import LEVEL, WAVE, groups, level, scaled, scaled_speed, wave_number
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.gate.line import line
from modelgen.diagnose.gate.ports import felt_terms, felt_waves
from modelgen.diagnose.gate.tables import together
from modelgen.diagnose.hypotheses.evidence import Level, effective, profiled, settled
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import COLOUR_SWEEP, COLOUR_TIME
from modelgen.diagnose.noise.replica import motion_matters
from modelgen.diagnose.noise.slow import gain_in_slow_noise
from modelgen.diagnose.search.screen import Tangent
from modelgen.fit.colour import coloured
from modelgen.fit.whitener import Array, Whitener
from modelgen.language import Model


def leftover(model: Model, judge: Judge, fit: Fit, sensitivities: Mapping[str, Array]) -> Leftover:
    """Describe what the fit leaves. `sensitivities` (frequency models): port → d(output)/d(port quantity),
    complex.

    `gain` is 0 with empty words when no description gains anything.
    """
    return likeliest(model, descriptions(model, judge, fit, sensitivities))


def descriptions(model: Model, judge: Judge, fit: Fit, sensitivities: Mapping[str, Array]) -> list[Leftover]:
    """All that may describe what the fit leaves, one of each kind."""
    if model.is_time_model:
        return _in_time(model, judge, fit)
    if all(s.measure == "real" for s in fit.hypothesis.experiment.series):
        return [together(judge, fit)]
    return _in_frequency(judge, fit, Tangent.of(*judge.tangent(fit)), sensitivities)


def likeliest(model: Model, found: Sequence[Leftover]) -> Leftover:
    """The one that gains most."""
    best = max(found, key=lambda x: x.gain, default=Leftover(0.0, 0.0, "", ""))
    if best.says or not model.is_time_model:
        return best
    # what follows no variable that is known is where the forces add up rather than in a channel
    names = [p.name for p in model.ports if p.kind == "force"]
    return replace(best, port=names[0] if len(names) == 1 else "")


def gain_of(
    tangent: Tangent, columns: Array, n: int, price: float = 0.0, own: Array | None = None
) -> tuple[float, float, Array]:
    """(ΔBIC, χ², residual then) of free amounts of `columns` (N, k) beside the fit, its level profiled;
    `price` for looking; own: (N,) the noise's share in the variances, None where it is all."""
    rest = tangent.off(columns)
    size = np.linalg.norm(rest, axis=0)
    keep = size > 1e-6 * np.linalg.norm(columns, axis=0)
    if not keep.any():
        return 0.0, 0.0, tangent.r
    unit = rest[:, keep] / size[keep]
    values, vectors = np.linalg.eigh(unit.T @ unit)
    good = values > 1e-10 * values[-1]
    part = (vectors.T @ (unit.T @ tangent.r))[good]
    explained = float(np.sum(part**2 / values[good]))
    left = tangent.r - unit @ (vectors[:, good] @ (part / values[good]))
    gain = profiled(settled(tangent.r), own) - profiled(settled(left), own)
    return gain - int(good.sum()) * float(np.log(n)) - price, explained, left


# -- frequency
# ---------------------------------------------------------------------------------------------------


SPARE = 10
"""Values beyond parameters and amounts that a description must leave: fewer are met by anything."""


def _in_frequency(
    judge: Judge, fit: Fit, tangent: Tangent, sensitivities: Mapping[str, Array]
) -> list[Leftover]:
    e = fit.hypothesis.experiment
    if any(s.measure != "complex" for s in e.series):
        return []
    axis = e.model.axis
    f = np.concatenate([s.inputs[axis] for s in e.series])
    n = effective(fit.white)
    before = cache(lambda: _noise(judge, fit.white, COLOUR_SWEEP)[0])
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
                own = before() - _noise(judge, _parted(left, fit.white), COLOUR_SWEEP)[0]
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


# -- time
# --------------------------------------------------------------------------------------------------------


def _in_time(model: Model, judge: Judge, fit: Fit) -> list[Leftover]:
    """Groups of terms in time, each judged with the colour of its own residual, so that coloured noise gains
    nothing."""
    plain = Judge(tuple(replace(w, ar=None) for w in judge.whiteners), judge.prior)
    fit = plain.look(fit.hypothesis, fit.theta)
    tangent = Tangent.of(*plain.tangent(fit))
    e = fit.hypothesis.experiment
    n = effective(fit.white)
    moved = next((i.derived[1] for i in model.inputs if i.derived and i.derived[0] == "rate"), "")
    names = model.derived_from(moved)
    found = [line(model, fit, n)]
    before = cache(lambda: _noise(plain, fit.white, COLOUR_TIME))
    if not moved:
        for at, group, words, felt in felt_terms(fit, plain):
            best = _best_of(tangent, felt, plain, fit.white, before, at.name, words, group)
            found.append(replace(best, terms=(group, 0)))
        found += _felt_waves(fit, plain, tangent, before)
    if not moved:
        return found
    z = scaled([s.inputs[moved] for s in e.series])
    v = scaled_speed([s.inputs[names["rate"]] for s in e.series])
    shown = [e.raw(fit.theta, k)[0] + s.data[0] for k, s in enumerate(e.series)]
    force = scaled(shown)
    for says, kind, make in groups():
        port = next((p.name for p in model.ports if p.kind == kind), kind)
        blocks = []
        for k, s in enumerate(e.series):
            terms = np.stack(list(make(z[k], v[k], s.inputs[model.axis], force[k])))
            blocks.append(plain.whiteners[k].apply(terms[None])[0].T)
        columns = np.concatenate(blocks)
        best = _best_of(tangent, columns, plain, fit.white, before, port, says, make.__name__)
        if make.__name__ == "position":
            best = _of_wave(best, [s.inputs[moved] for s in e.series])
        elif make.__name__ == "shown":
            best = replace(best, terms=(LEVEL, *level(best.terms[1], shown)))
        found.append(best)
    return found


def _of_wave(best: Leftover, z: Sequence[Array]) -> Leftover:
    """A wave over the displacement z of each recording, with its number in the place of its pitch's."""
    return replace(best, terms=(WAVE, wave_number(best.terms[1], z)))


def _felt_waves(fit: Fit, plain: Judge, tangent: Tangent, before: Callable[[], Noise]) -> list[Leftover]:
    """The best wave over the position at each port that knows it, where it is not recorded."""
    found = []
    for at, z, columns in felt_waves(fit, plain):
        words = f"a term that depends on {at['z']}, with short wavelengths"
        best = _best_of(tangent, columns, plain, fit.white, before, at.name, words, "position")
        found.append(_of_wave(best, z))
    return found


TOGETHER = {"position": 2, "shown": 1}
"""Groups of which only so many terms act at a time (a pitch, a limit): each is tried, at the price of
looking."""


def _best_of(
    tangent: Tangent,
    columns: Array,
    judge: Judge,
    white: Sequence[Array],
    before: Callable[[], Noise],
    port: str,
    says: str,
    group: str,
) -> Leftover:
    """The gain of a group of terms, all at once or the best few neighbours of them; checked with colours of
    their own, where it was likely as `before` says."""
    size, n, few = columns.shape[1], effective(white), TOGETHER.get(group, 0)
    sets = [list(range(size))] if not few else [list(range(k, k + few)) for k in range(0, size, few)]
    price = 2 * float(np.log(len(sets)))
    own = _own(judge.prior, white)
    tried = [(*gain_of(tangent, columns[:, c], n, price, own), len(c)) for c in sets]
    best = max(range(len(tried)), key=lambda k: tried[k][0])
    gain, chi2, rest, count = tried[best]
    if gain > CHECKED:
        left, (price_before, old) = _parted(rest, white), before()
        price_after, new = _noise(judge, left, COLOUR_TIME)
        alone = price_before - price_after
        if not motion_matters(judge.whiteners):
            alone = min(alone, gain_in_slow_noise(old, white, new, left))
        gain = min(gain, alone - count * float(np.log(n)) - price)
    return Leftover(float(gain), chi2, port, says, (group, best))


CHECKED = 10.0
"""ΔBIC from which a gain is checked with colours of their own."""


def _own(prior: Sequence[Level], white: Sequence[Array]) -> Array | None:
    """(N,) the noise's share in the variances of all residuals; None where it is all."""
    if all(p.own is None for p in prior):
        return None
    shares = [np.ones(e.shape) if p.own is None else p.own + 0 * e for p, e in zip(prior, white, strict=True)]
    return np.concatenate([x.ravel() for x in shares])


Noise = tuple[float, list[Whitener]]
"""−2 ln of the likelihood of residuals, and whiteners of the colours by which it is that."""


def _noise(judge: Judge, residuals: Sequence[Array], order: int) -> Noise:
    """The likeliest noise of `residuals`, each with a colour of its own, up to `order`."""
    price, found = 0.0, []
    for w, p, e in zip(judge.whiteners, judge.prior, residuals, strict=True):
        own = coloured([replace(w, ar=None)], [e], order, slow=order == COLOUR_TIME)[0]
        square = own.colour(e) ** 2 * (e != 0)
        price += profiled(square, p.own) + own.order * float(np.log(max(int(np.count_nonzero(e)), 2)))
        found.append(own)
    return price, found


def _parted(joined: Array, like: Sequence[Array]) -> list[Array]:
    """Residuals of each recording, with channels as in `like`, from those of all."""
    ends = np.cumsum([e.size for e in like])[:-1]
    return [x.reshape(e.shape) for x, e in zip(np.split(joined, ends), like, strict=True)]
