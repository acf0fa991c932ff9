"""The colour of the noise, taken from the best hypothesis so far: by it all are judged again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from modelgen.diagnose.hypotheses.bounds import moving
from modelgen.diagnose.hypotheses.evidence import bic, effective, settled
from modelgen.diagnose.hypotheses.refit import Fit, Judge, misfit, plain_white
from modelgen.diagnose.hypotheses.setting import ALARM, Setting
from modelgen.diagnose.noise.follows import ignores_motion
from modelgen.diagnose.noise.noise import FITS, correlation_length, first_order, fitful, local_level, scatter
from modelgen.diagnose.noise.one_instrument import colours
from modelgen.diagnose.noise.smooth_error import SIZES, quietness, smooth_error
from modelgen.fit.series import Array
from modelgen.fit.whitener import Whitener

GROSS_STATED, GROSS_ESTIMATED = 3.0, 8.0
"""A residual this many times the noise (stated, or in bursts; scatter between neighbours) is a wrong model's,
not coloured noise."""


def recolour(s: Setting, judge: Judge, base: Fit, fits: list[Fit]) -> tuple[Judge, Fit, list[Fit]]:
    """Judge again with the colour of the best hypothesis' residual, where that has one."""
    best = _likeliest(s, judge, [base, *fits])
    plain = tuple(replace(x.whitener, ar=None) for x in s.series)
    white = [w.apply(best.hypothesis.experiment.raw(best.theta, k)) for k, w in enumerate(plain)]
    if gross(s, white) and not near_smooth(s, judge, best, white):
        return _uncoloured(s, judge, best, base, fits)
    filters, missed = colours(s, plain, white)
    uneven = [
        local_level(w.colour(e)) if s.model.is_time_model and not m else np.ones(e.shape[1])
        for w, e, m in zip(filters, white, missed, strict=True)
    ]
    if any(np.any(u != 1) for u in uneven):
        plain = tuple(w.scaled(u) for w, u in zip(plain, uneven, strict=True))
        white = [w.apply(best.hypothesis.experiment.raw(best.theta, k)) for k, w in enumerate(plain)]
        filters, _ = colours(s, plain, white)
    before = judge.temper > 1.0 or any(w.ar is not None for w in judge.whiteners)
    if not before and all(w.ar is None for w in filters) and all(np.all(u == 1) for u in uneven):
        return judge, base, fits
    new, base_then, then = judged_anew(s, replace(judge, whiteners=filters, temper=1.0), base, fits)
    led = min([base_then, *then], key=lambda f: f.bic)
    if s.model.is_time_model and _size(led) > max(SPOILT * _size(best), 1.0):
        within = all(x.stated for x in s.series) and _size(base) < FITS
        return (judge, base, fits) if within else _uncoloured(s, judge, best, base, fits)
    return new, base_then, then


SPOILT = 1.25
"""Over time the best account under a colour leaves no more than this many times what the colour was taken
from: more, it is no noise's. Each further colour would let more of the misfit pass, as long as it is smooth.
Nothing is spoilt within the noise and what errors of the motion make."""


def _size(f: Fit) -> float:
    """Rms of a fit's residual over the noise's level and errors of the motion, whatever its colour."""
    white = plain_white(f)
    return float(np.sqrt(sum(np.sum(e**2) for e in white) / max(sum(map(np.count_nonzero, white)), 1)))


def _uncoloured(
    s: Setting, judge: Judge, best: Fit, base: Fit, fits: list[Fit]
) -> tuple[Judge, Fit, list[Fit]]:
    """All as if what `best` leaves were a wrong model's, by which evidence is divided."""
    plain = tuple(replace(x.whitener, ar=None) for x in s.series)
    new = Judge(plain, judge.prior, correlation_length(plain_white(best)), judge.excess)
    first, *rest = s.each(lambda f: new.look(f.hypothesis, f.theta), [base, *fits])
    return new, first, rest


CONTENDERS = 4
"""Fits whose own colours are compared."""
NEAREST = 2
"""And of those nearest to the recordings as they are, where what a colour hides is slow."""


def _likeliest(s: Setting, judge: Judge, fits: Sequence[Fit]) -> Fit:
    """The best of `fits`. The colour that one of them has left may hide what another explains: where there is
    one, each of the first few is judged by its own."""
    first = sorted(fits, key=lambda f: f.bic)[:CONTENDERS]
    if all(w.ar is None or len(w.ar) < 2 for w in judge.whiteners):
        return first[0]
    if s.model.is_time_model:
        first += [f for f in sorted(fits, key=misfit)[:NEAREST] if all(f is not x for x in first)]
    return first[int(np.argmin(own_colours(s, judge, first)))]


def judged_anew(s: Setting, new: Judge, base: Fit, fits: Sequence[Fit]) -> tuple[Judge, Fit, list[Fit]]:
    """The best of `fits` and the base fitted again under a new judge, the rest looked at.

    In sweeps those that are best a step on: where a fit had ended, an error that is smooth may be far too
    large.
    """
    ahead = (lambda f: f.bic) if s.model.is_time_model else partial(_ahead, new)
    rough = sorted(s.each(lambda f: new.look(f.hypothesis, f.theta), fits), key=ahead)
    first = s.each(lambda f: new.fit(f.hypothesis, [f.theta]), [base, *rough[: s.refits]])
    return new, first[0], first[1:] + rough[s.refits :]


def _ahead(judge: Judge, f: Fit) -> float:
    """BIC that a fit has a step on, at first order."""
    r, J = judge.tangent(f)
    size = np.linalg.norm(J, axis=0)
    told = moving(f.hypothesis.experiment.layout, f.theta, f.hypothesis.shapes) & (size > 0)
    if not (np.all(np.isfinite(r)) and np.all(np.isfinite(size)) and f.chi2 > 0):
        return f.bic
    columns = J[:, told] / size[told]
    step = np.linalg.lstsq(columns, -r, rcond=1e-10)[0]
    return f.bic - judge.evidence(f, f.chi2 - float(np.sum((r + columns @ step) ** 2)))


ROUNDS = 3
"""Times that the colour is taken anew: what a single effect had left is not the noise of a pair."""


def recolour_pairs(
    s: Setting, judge: Judge, base: Fit, grown: list[Fit], best: Fit
) -> tuple[Judge, Fit, list[Fit], Fit]:
    """`recolour` for hypotheses that have grown, and the best of those before, until the noise settles."""
    for _ in range(ROUNDS):
        new, base, fits = recolour(s, judge, base, [*grown, best])
        grown = [f for f in fits if f.hypothesis is not best.hypothesis]
        best = next(f for f in fits if f.hypothesis is best.hypothesis)
        same = new is judge or _alike(new, judge)
        judge = new
        if same:
            break
    return judge, base, grown, best


def _alike(a: Judge, b: Judge) -> bool:
    """Whether two judges have the same colour, to a tenth."""

    def filters(j: Judge) -> list[Array]:
        return [np.ones(1) if w.ar is None else w.ar for w in j.whiteners]

    pairs = zip(filters(a), filters(b), strict=True)
    return all(len(x) == len(y) and np.allclose(x, y, atol=0.1) for x, y in pairs)


def near_smooth(s: Setting, judge: Judge, best: Fit, white: Sequence[Array]) -> bool:
    """Whether what is left may be a smooth error of the instrument, no larger than those have been seen."""
    if s.model.is_time_model:
        return False
    over = quietness(s.series, judge.whiteners)
    largest = max(
        float(np.sqrt(np.mean(e[e != 0] ** 2))) / q for e, q in zip(white, over, strict=True) if np.any(e)
    )
    return largest < SIZES[-1] and smooth_error(judge, best)[2] is not None


@dataclass(frozen=True, eq=False)
class OwnNoise:
    """The likeliest noise of a fit's own residual: BIC under it, and whiteners of the recordings."""

    bic: float
    whiteners: tuple[Whitener, ...]


def own_colours(s: Setting, judge: Judge, fits: Sequence[Fit]) -> list[float]:
    """BIC of each fit under the likeliest noise of its own residual."""
    return [x.bic for x in own_noises(s, judge, fits)]


def own_noises(s: Setting, judge: Judge, fits: Sequence[Fit]) -> list[OwnNoise]:
    """The likeliest noise of each fit's own residual: coloured along the samples, lone ones counting little,
    or in sweeps a smooth error of the instrument.

    A recording whose colour is no noise's by one of the fits has none by the others. Colour many times as
    large as the independent noise is rare: −2 ln of its prior is twice its size.
    """
    plain = tuple(replace(w, ar=None) for w in judge.whiteners)
    raw = [[f.hypothesis.experiment.raw(f.theta, k) for k in range(len(plain))] for f in fits]
    white = [[w.apply(e) for w, e in zip(plain, rows, strict=True)] for rows in raw]
    found = s.each(lambda x: colours(s, plain, x), white)
    missed = [any(m) for m in zip(*(m for _, m in found), strict=True)]
    noises = []
    for f, rows, x, (filters, _) in zip(fits, raw, white, found, strict=True):
        own = tuple(v if m else w for v, w, m in zip(plain, filters, missed, strict=True))
        innovations = [w.apply(e) for w, e in zip(own, rows, strict=True)]
        size = max(float(np.sqrt(np.mean(e[e != 0] ** 2))) if np.any(e) else 0.0 for e in x)
        price = _own_price(s, judge, f, innovations, sum(w.order for w in own), 2 * size)
        noises.append(OwnNoise(price, own))
    return noises


def by_own_noise(s: Setting, judge: Judge, best: Fit, tried: Sequence[Fit]) -> Fit:
    """The best account of sweeps, or of those that come next one that is better by far with the smooth error
    of the instrument that it leaves: a law of many numbers says such an error, too."""
    if s.model.is_time_model or not best.ids:
        return best
    others = (f for f in sorted(tried, key=lambda f: f.bic) if len(f.ids) == len(best.ids))
    first = {best.ids: best}
    for f in others:
        first.setdefault(f.ids, f)
    fits = list(first.values())[:CONTENDERS]
    own = own_colours(s, judge, fits)
    return best if own[0] - min(own) < ALARM else fits[int(np.argmin(own))]


def _own_price(
    s: Setting, judge: Judge, f: Fit, innovations: Sequence[Array], orders: int, rare: float
) -> float:
    """BIC of a fit by what filters of so many `orders` leave, and how `rare` they are; in sweeps or with a
    smooth error in their place."""
    if s.model.is_time_model or any(x.measure == "real" for x in s.series):
        return bic(innovations, judge.prior, f.parameters, orders, robust=True) + rare
    smooth, gain, _ = smooth_error(judge, f)
    n = effective(innovations)
    level = float(np.sum(settled(np.concatenate([e.ravel() for e in innovations])))) / n
    colour = n * float(np.log(level)) + (f.parameters + orders) * float(np.log(n)) + rare
    return min(smooth - gain, colour - 2 * f.hypothesis.log_common)


def gross(s: Setting, white: Sequence[Array]) -> bool:
    """Whether the best hypothesis leaves far more than noise, and than one of the first order, or one that
    ignores the motion, of which nobody stated how large it is."""
    over = (
        [1.0] * len(white) if s.model.is_time_model else quietness(s.series, [x.whitener for x in s.series])
    )
    for x, e, q in zip(s.series, white, over, strict=True):
        used = e[e != 0] / q
        rough = float(np.median([scatter(x, channel) for channel in e]))
        told = x.stated or (s.model.is_time_model and fitful(e))
        limit = GROSS_STATED * beyond(rough) if told else GROSS_ESTIMATED
        large = used.size and float(np.sqrt(np.mean(used**2))) > limit
        if large and (told or not first_order(e, len(white))):
            return told or not ignores_motion(s.model, s.series, white)
    return False


AS_ROUGH = 1.35
"""Residuals up to this many times the scatter between their neighbours are as rough as independent noise."""


def beyond(scatter: float) -> float:
    """Factor on what counts as far from a stated noise, where neighbours scatter `scatter` times as much:
    physics doesn't, so it is what was stated that is wrong."""
    return max(1.0, scatter / AS_ROUGH)
