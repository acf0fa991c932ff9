"""What is left over time, described without a catalogue: functions of few variables, linear and hysteretic
memories, lines of a spectrum, all under noise with a colour of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from modelgen.diagnose.gate.channels import places, shown
from modelgen.diagnose.gate.gains import CHECKED, Noise, gain_of, noise_of, parted
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.gate.line import line
from modelgen.diagnose.gate.ports import felt_terms, felt_waves
from modelgen.diagnose.hypotheses import functions
from modelgen.diagnose.hypotheses.evidence import Level, effective
from modelgen.diagnose.hypotheses.functions import Group
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import COLOUR_TIME
from modelgen.diagnose.noise.replica import motion_matters
from modelgen.diagnose.noise.slow import gain_in_slow_noise
from modelgen.diagnose.search.screen import Tangent
from modelgen.fit.pool import share
from modelgen.fit.series import Series
from modelgen.fit.whitener import Array, Whitener
from modelgen.language import Model


def in_time(model: Model, judge: Judge, fit: Fit) -> list[Leftover]:
    """Groups of terms in time, each judged with the colour of its own residual, so that coloured noise gains
    nothing."""
    plain = Judge(tuple(replace(w, ar=None) for w in judge.whiteners), judge.prior)
    fit = plain.look(fit.hypothesis, fit.theta)
    tangent = Tangent.of(*plain.tangent(fit))
    e = fit.hypothesis.experiment
    moved = model.moved
    alone = line(model, fit, effective(fit.white))
    if not moved:
        tried = [
            _best_of(tangent, felt, plain.prior, fit.white, Leftover(0.0, 0.0, at.name, words, (group,)))
            for at, group, words, felt in felt_terms(fit, plain)
        ]
        tried = [replace(g, left=replace(g.left, terms=(g.left.terms[0], 0))) for g in tried]
        return [alone, *_checked([*tried, *_felt_waves(fit, plain, tangent)], plain, fit.white, alone.gain)]
    names = model.derived_from(moved)
    z = functions.scaled([s.inputs[moved] for s in e.series])
    v = functions.scaled_speed([s.inputs[names["rate"]] for s in e.series])
    modelled = [e.raw(fit.theta, k) + s.data for k, s in enumerate(e.series)]

    def tried_in(place: tuple[Group, str, str]) -> _Tried:
        (says, _, make), port, output = place
        at = [_channel(model, s, output) for s in e.series]
        values = [x[c] for x, c in zip(modelled, at, strict=True)]
        force = functions.scaled(values)
        blocks = []
        for k, (s, c) in enumerate(zip(e.series, at, strict=True)):
            terms = np.stack(list(make(z[k], v[k], s.inputs[model.axis], force[k])))
            blocks.append(_in_channel(plain.whiteners[k], terms, c, len(s.data)))
        like = Leftover(0.0, 0.0, port, says, (make.__name__,))
        best = _best_of(tangent, np.concatenate(blocks), plain.prior, fit.white, like)
        if make.__name__ == "position":
            return _of_wave(best, [s.inputs[moved] for s in e.series])
        if make.__name__ == "shown":
            limit = functions.level(best.left.terms[1], values)
            return replace(best, left=replace(best.left, terms=(functions.LEVEL, *limit)))
        return best

    tried = share(tried_in, [(g, *at) for g in functions.groups() for at in places(model, e.series, g[1])])
    jumps = [_jump(model, fit, plain, tangent, *at) for at in places(model, e.series, "force")]
    tried = [*tried, *jumps]
    return [alone, *_checked(tried, plain, fit.white, alone.gain)]


MOMENTS = 60
"""At which a jump is tried in each recording."""


def _jump(model: Model, fit: Fit, plain: Judge, tangent: Tangent, port: str, output: str) -> _Tried:
    """The best jump of an output at one moment of one recording: a clamp slips, a sensor is knocked."""
    series, blocks, moments = fit.hypothesis.experiment.series, [], []
    unit = next(i.unit for i in model.inputs if i.name == model.axis)
    for k, s in enumerate(series):
        t = s.inputs[model.axis]
        starts = np.linspace(0, s.n, MOMENTS + 2)[1:-1].astype(int)
        steps = (np.arange(s.n) >= starts[:, None]).astype(float)
        columns = _in_channel(plain.whiteners[k], steps, _channel(model, s, output), len(s.data))
        blocks.append(np.pad(columns, ((0, 0), (MOMENTS * k, MOMENTS * (len(series) - 1 - k)))))
        moments += [f"a jump of the force at {t[m]:.4g} {unit} in {s.name}" for m in starts]
    like = Leftover(0.0, 0.0, port, "", (JUMP,))
    best = _best_of(tangent, np.concatenate(blocks), plain.prior, fit.white, like)
    return replace(best, left=replace(best.left, says=moments[best.left.terms[1]], terms=()))


def _channel(model: Model, s: Series, output: str) -> int:
    """Which channel of a recording shows an output; the first where none does."""
    names = shown(model, s)
    return names.index(output) if output in names else 0


def _in_channel(w: Whitener, terms: Array, channel: int, outputs: int) -> Array:
    """Whitened columns (outputs·n, k) of `terms` (k, n) in one of a recording's channels."""
    there = np.zeros((outputs, *terms.shape))
    there[channel] = terms
    return np.asarray(w.apply(there).transpose(0, 2, 1).reshape(-1, len(terms)))


@dataclass(frozen=True, eq=False)
class _Tried:
    """A group of terms, with its gain as if noise had no colour; the residual `rest` (N,) that it leaves; and
    the price of its amounts and of looking."""

    left: Leftover
    rest: Array
    price: float


def _of_wave(best: _Tried, z: Sequence[Array]) -> _Tried:
    """A wave over the displacement z of each recording, with its number in the place of its pitch's."""
    terms = (functions.WAVE, functions.wave_number(best.left.terms[1], z))
    return replace(best, left=replace(best.left, terms=terms))


def _felt_waves(fit: Fit, plain: Judge, tangent: Tangent) -> list[_Tried]:
    """The best wave over the position at each port that knows it, where it is not recorded."""
    found = []
    for at, z, columns in felt_waves(fit, plain):
        words = f"a term that depends on {at['z']}, with short wavelengths"
        like = Leftover(0.0, 0.0, at.name, words, ("position",))
        found.append(_of_wave(_best_of(tangent, columns, plain.prior, fit.white, like), z))
    return found


JUMP = "jump"
TOGETHER = {"position": 2, "shown": 1, JUMP: 1}
"""Groups of which only so many terms act at a time (a pitch, a limit): each is tried, at the price of
looking."""


def _best_of(
    tangent: Tangent, columns: Array, prior: Sequence[Level], white: Sequence[Array], like: Leftover
) -> _Tried:
    """The gain of a group of terms, which `like` names, all at once or the best few neighbours of them."""
    size, n, few = columns.shape[1], effective(white), TOGETHER.get(like.terms[0], 0)
    sets = [list(range(size))] if not few else [list(range(k, k + few)) for k in range(0, size, few)]
    price = 2 * float(np.log(len(sets)))
    own = _own(prior, white)
    tried = [(*gain_of(tangent, columns[:, c], n, price, own), len(c)) for c in sets]
    best = max(range(len(tried)), key=lambda k: tried[k][0])
    gain, chi2, rest, count = tried[best]
    left = replace(like, gain=float(gain), chi2=chi2, terms=(*like.terms, best))
    return _Tried(left, rest, count * float(np.log(n)) + price)


def _checked(tried: Sequence[_Tried], judge: Judge, white: Sequence[Array], best: float) -> list[Leftover]:
    """Groups of terms with gains that count colours of their own on either side; those that gain no more than
    the `best` even without are not looked at, theirs is what they gain at most."""
    before = cache(lambda: noise_of(judge, white, COLOUR_TIME))
    found = []
    for g in sorted(tried, key=lambda g: -g.left.gain):
        gain = g.left.gain
        if gain > max(best, CHECKED):
            gain = min(gain, _coloured_gain(judge, before(), white, parted(g.rest, white)) - g.price)
        best = max(best, gain)
        found.append(replace(g.left, gain=gain))
    return found


def _coloured_gain(judge: Judge, before: Noise, white: Sequence[Array], left: Sequence[Array]) -> float:
    """What residuals that are `left` gain on `white`, each with the likeliest noise of its own, which was
    `before`."""
    (price_before, old), (price_after, new) = before, noise_of(judge, left, COLOUR_TIME)
    alone = price_before - price_after
    if motion_matters(judge.whiteners):
        return alone
    return min(alone, gain_in_slow_noise(old, white, new, left))


def _own(prior: Sequence[Level], white: Sequence[Array]) -> Array | None:
    """(N,) the noise's share in the variances of all residuals; None where it is all."""
    if all(p.own is None for p in prior):
        return None
    shares = [np.ones(e.shape) if p.own is None else p.own + 0 * e for p, e in zip(prior, white, strict=True)]
    return np.concatenate([x.ravel() for x in shares])
