"""What is left over time, described without a catalogue: functions of few variables, linear and hysteretic
memories, lines of a spectrum, all under noise with a colour of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from modelgen.diagnose.gate.changes import WAVES, Output, changes
from modelgen.diagnose.gate.channels import places
from modelgen.diagnose.gate.gains import CHECKED, Noise, noise_of, parted
from modelgen.diagnose.gate.leftover import NOTHING, Leftover
from modelgen.diagnose.gate.line import line
from modelgen.diagnose.gate.ports import felt_terms, felt_waves
from modelgen.diagnose.gate.tried import Tried, best_of, channel_of, in_channel
from modelgen.diagnose.hypotheses import functions
from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.functions import Group
from modelgen.diagnose.hypotheses.refit import Fit, Judge, enough
from modelgen.diagnose.hypotheses.setting import COLOUR_TIME
from modelgen.diagnose.noise.slow import gain_in_slow_noise
from modelgen.diagnose.search.screen import Tangent
from modelgen.fit.pool import share
from modelgen.fit.whitener import Array
from modelgen.language import Model


def in_time(model: Model, judge: Judge, fit: Fit) -> list[Leftover]:
    """Groups of terms in time, each judged with the colour of its own residual, so that coloured noise gains
    nothing."""
    plain, fit, tangent = _as_it_is(judge, fit)
    alone = line(model, fit, effective(fit.white))
    if not model.moved:
        tried = [
            best_of(tangent, felt, plain.prior, fit.white, Leftover(0.0, 0.0, at.name, words, (group,)))
            for at, group, words, felt in felt_terms(fit, plain)
        ]
        tried = [replace(g, left=replace(g.left, terms=(g.left.terms[0], 0))) for g in tried]
        tried += _felt_waves(fit, plain, tangent)
        return [alone, *_checked(tried, Coloured(plain, fit.white), alone.gain)]
    tried = _of_motion(model, plain, fit, tangent, functions.groups()) + _changes(model, fit, plain, tangent)
    return [alone, *_checked(tried, Coloured(plain, fit.white), alone.gain)]


def ends(model: Model, judge: Judge, base: Fit) -> list[Leftover]:
    """Channels that level off at the ends of their ranges; nothing where no motion is recorded."""
    if not model.moved or not enough(base):
        return []
    plain, fit, tangent = _as_it_is(judge, base)
    groups = [g for g in functions.groups() if g[1] == "sensor"]
    return _checked(_of_motion(model, plain, fit, tangent, groups), Coloured(plain, fit.white), 0.0)


def _of_motion(
    model: Model, plain: Judge, fit: Fit, tangent: Tangent, groups: Sequence[Group]
) -> list[Tried]:
    """Groups of functions of the recorded motion, at each output that they may act on."""
    e, moved = fit.hypothesis.experiment, model.moved
    names = model.derived_from(moved)
    z = functions.scaled([s.inputs[moved] for s in e.series])
    v = functions.scaled_speed([s.inputs[names["rate"]] for s in e.series])
    modelled = [e.raw(fit.theta, k) + s.data for k, s in enumerate(e.series)]

    def tried_in(place: tuple[Group, str, str]) -> Tried:
        (says, _, make), port, output = place
        at = [channel_of(model, s, output) for s in e.series]
        values = [x[c] for x, c in zip(modelled, at, strict=True)]
        force = functions.scaled(values)
        blocks = []
        for k, (s, c) in enumerate(zip(e.series, at, strict=True)):
            terms = np.stack(list(make(z[k], v[k], s.inputs[model.axis], force[k])))
            blocks.append(in_channel(plain.whiteners[k], terms, c, len(s.data)))
        like = Leftover(0.0, 0.0, port, says, (make.__name__,))
        best = best_of(tangent, np.concatenate(blocks), plain.prior, fit.white, like)
        if make.__name__ == "position":
            return _of_wave(best, [s.inputs[moved] for s in e.series])
        if make.__name__ == "shown":
            limit = functions.level(best.left.terms[1], values)
            return replace(best, left=replace(best.left, terms=(functions.LEVEL, *limit)))
        return best

    return share(tried_in, [(g, *at) for g in groups for at in places(model, e.series, g[1])])


def sudden(model: Model, judge: Judge, base: Fit, named: Fit) -> tuple[Leftover, float]:
    """What gains most on the base of all that is pumped at a frequency of its own, or jumps, as no law of the
    motion does; and what `named` effects gain, by the same measure. Nothing where no motion is recorded."""
    if not model.moved or not enough(base):
        return NOTHING, 0.0
    plain, fit, tangent = _as_it_is(judge, base)
    coloured = Coloured(plain, fit.white)
    gain = coloured.gain(plain.look(named.hypothesis, named.theta).white)
    gain -= (named.parameters - base.parameters) * float(np.log(effective(fit.white)))
    tried = [x for x in _changes(model, fit, plain, tangent) if x.left.terms[-1] != WAVES]
    return max(_checked(tried, coloured, gain), key=lambda x: x.gain), gain


def _as_it_is(judge: Judge, fit: Fit) -> tuple[Judge, Fit, Tangent]:
    """A judge to whom noise has no colour, and the fit and its tangent as it sees them."""
    plain = Judge(tuple(replace(w, ar=None) for w in judge.whiteners), judge.prior)
    fit = plain.look(fit.hypothesis, fit.theta)
    return plain, fit, Tangent.of(*plain.tangent(fit))


def _changes(model: Model, fit: Fit, plain: Judge, tangent: Tangent) -> list[Tried]:
    """What changes while it is recorded, at each output that a force acts on."""
    places_of = places(model, fit.hypothesis.experiment.series, "force")
    return [x for at in places_of for x in changes(model, fit, plain, tangent, Output.of(model, fit, at))]


def _of_wave(best: Tried, z: Sequence[Array]) -> Tried:
    """A wave over the displacement z of each recording, with its number in the place of its pitch's."""
    terms = (functions.WAVE, functions.wave_number(best.left.terms[1], z))
    return replace(best, left=replace(best.left, terms=terms))


def _felt_waves(fit: Fit, plain: Judge, tangent: Tangent) -> list[Tried]:
    """The best wave over the position at each port that knows it, where it is not recorded."""
    found = []
    for at, z, columns in felt_waves(fit, plain):
        words = f"a term that depends on {at['z']}, with short wavelengths"
        like = Leftover(0.0, 0.0, at.name, words, ("position",))
        found.append(_of_wave(best_of(tangent, columns, plain.prior, fit.white, like), z))
    return found


@dataclass(frozen=True, eq=False)
class Coloured:
    """Residuals `white` (channels, n) of each recording, with the likeliest noise of their own."""

    judge: Judge
    white: Sequence[Array]

    @cached_property
    def noise(self) -> Noise:
        return noise_of(self.judge, self.white, COLOUR_TIME)

    def gain(self, left: Sequence[Array]) -> float:
        """What residuals that are `left` gain on them, each with the likeliest noise of its own."""
        (price_before, old), (price_after, new) = self.noise, noise_of(self.judge, left, COLOUR_TIME)
        return min(price_before - price_after, gain_in_slow_noise(old, self.white, new, left))


def _checked(tried: Sequence[Tried], coloured: Coloured, best: float) -> list[Leftover]:
    """Groups of terms with gains that count colours of their own on either side; those that gain no more than
    the `best` even without are not looked at, theirs is what they gain at most."""
    found = []
    for g in sorted(tried, key=lambda g: -g.left.gain):
        gain = g.left.gain
        if gain > max(best, CHECKED):
            gain = min(gain, coloured.gain(parted(g.rest, coloured.white)) - g.price)
        best = max(best, gain)
        found.append(replace(g.left, gain=gain))
    return found
