"""Is the best hypothesis good enough? What remains is tested for what noise is not: dependence on state, and
level."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from modelgen.diagnose.gate.describe import described
from modelgen.diagnose.gate.generic import Remains
from modelgen.diagnose.gate.imitated import Imitated, gained, imitating
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.gate.line import gained_beside
from modelgen.diagnose.gate.not_stated import not_stated
from modelgen.diagnose.gate.notes import beside_note, far_notes, level_note, noise_words
from modelgen.diagnose.gate.rivals import LEFT, as_leftover, nearer, outdone
from modelgen.diagnose.gate.size import Size, is_far, is_gross, reach, smooth_beside
from modelgen.diagnose.gate.unlisted import best_unlisted, refused, with_rivals
from modelgen.diagnose.gate.wholly import but_noise, wholly_described
from modelgen.diagnose.hypotheses.functions import LEVEL
from modelgen.diagnose.hypotheses.ranking import OUTSIDE, standings
from modelgen.diagnose.hypotheses.refit import Fit, mean_square, plain_white
from modelgen.diagnose.hypotheses.setting import ALARM, CLOSE, TEMPER, Outcome, Setting
from modelgen.diagnose.noise.noise import FITS
from modelgen.diagnose.noise.recolour import CONTENDERS
from modelgen.fit.series import Array

REST = 0.1
"""What is left may hold this share of the evidence for the named effects: the right family, its law not
quite. With more it is another thing that they imitate."""
EXPLAINED = 0.85
"""Share of the misfit that named effects must explain to be named although far more than noise is left."""
BEYOND = 100.0
"""ΔBIC of effects that are named beside noise which is smooth along a sweep, if nothing describes what they
leave."""
PART = 0.6
"""The same where even the best hypothesis stays far from the data: real records hold many effects, none
exactly. In records of several simulators names that explained less were wrong, those that explained more
mostly right."""
LIKELY = 0.25
"""Probability of its kin, less what is missing of the way there, from which such an effect is named all the
same."""
NAMELESS = 0.15
"""Probability of the likeliest of them below which it is no name."""
SOME, MUCH = 0.3, 0.95
"""The same, over time and in sweeps, where no description of the whole is better than they are."""
RATHER = 2.0
"""Times the evidence for any description of the whole that named effects need in sweeps that explain less."""
TWICE = 2.0
"""Far from the recordings, terms that describe what named effects leave take their place, if on their own
they leave less than a half as much, in rms."""


@dataclass(frozen=True)
class Gate:
    """The decision: `unknown` physics or not; `floor` mean square of plain white residuals that is noise;
    `scale` its root."""

    unknown: bool
    leftover: Leftover
    probability: float
    floor: float
    scale: float
    noise: str
    notes: tuple[str, ...]
    fit: Fit | None = None
    """The base with what no catalogue holds."""
    tied: Fit | None = None
    """The named effects, where the data do not exclude them beside it."""
    beside: bool = False
    """Whether the named effects need a smooth error that nobody stated, larger than what they explain."""
    error: Leftover | None = None
    """An error of how sweeps were taken that would do as well; `gain`: by how much it is ahead."""


FARTHER = 1.5
"""Times the base's mean square residual beyond which effects are no account of the recordings."""


@dataclass(frozen=True)
class _Look:
    """What has been decided so far: whether physics is `unknown` by what is `left`, `far` from the recordings
    or not; `explained`: the part of the misfit that named effects take; `whole`: whether one description of
    all is what is left. `floor` and `beside` as in `Gate`."""

    unknown: bool
    left: Leftover
    floor: float
    far: bool
    explained: float
    beside: bool
    whole: bool = False


def judge_adequacy(
    setting: Setting,
    outcome: Outcome,
    sensitivities: Mapping[str, Array],
    oddity: Leftover | None = None,
) -> Gate:
    """Gate on the residual of the best hypothesis, and on what the outliers have in common (`oddity`)."""
    remains, size = Remains(setting, outcome, sensitivities), Size.of(setting, outcome)
    look = _by_what_is_left(remains, size)
    look = _by_one_description(remains, size, look)
    rival = None if look.whole else _rival(setting, outcome, look.left if look.unknown else None)
    imitated = Imitated(None) if look.unknown else imitating(remains, look.left, oddity)
    other = oddity if oddity is not None and not outcome.best.hypothesis.added else imitated.other
    told = look.unknown or other is not None or rival is not None
    more = None if told else not_stated(setting, outcome)
    if other is not None or more is not None:
        look = replace(look, unknown=True, left=other or more or look.left)
    elif rival is not None:
        look = replace(look, unknown=True, left=as_leftover(outcome, rival[0], rival[1] + LEFT))
    structured = other is not None or rival is not None or look.left.gain > LEFT
    rival = rival if other is None else None
    lead = rival[1] if rival is not None and outcome.best.hypothesis.added else None
    probability = _probability(look.left, structured, more is not None, lead)
    tied = outcome.best if lead is not None and lead < CLOSE else None
    fit, beside = rival[0] if rival else None, look.beside and not look.unknown
    of_size, floor = _noted(outcome, size, look, fit)
    notes = (*(beside_note(outcome, size.after) if beside else ()), *imitated.notes, *of_size)
    words, scale = noise_words(setting, outcome, size.after, size.stated), float(np.sqrt(floor))
    return Gate(
        look.unknown, look.left, probability, floor, scale, words, notes, fit, tied, beside, imitated.error
    )  # fmt: skip


def _by_what_is_left(remains: Remains, size: Size) -> _Look:
    """By how much the best hypothesis leaves, and with how much evidence for structure in that."""
    setting, outcome, best = remains.setting, remains.outcome, remains.outcome.best
    before, after = size.before, size.after
    left, gross = _left(remains, after), is_gross(setting, outcome, size)
    far = gross or is_far(outcome, left, size)
    floor = size.floor(far)
    explained = (before - after) / max(before - floor, 1e-300) if before > floor else 1.0
    farther = bool(best.ids) and after > FARTHER * before  # a smooth error speaks for them
    unknown = farther or (
        _unexplained(setting, outcome, left, gross, explained)
        and not _better_named(remains, explained, floor)
    )
    allowed = size.stated and bool(best.ids) and smooth_beside(setting, outcome) and not unknown
    beside = allowed and _beside(before, after)
    if beside:
        floor = 1.0
    elif not unknown and best.hypothesis.added and (part := reach(before, after, floor)) < 1.0:
        unknown = _nameless(setting, outcome, left, part)
    return _Look(unknown, left, floor, far, explained, beside)


def _by_one_description(remains: Remains, size: Size, look: _Look) -> _Look:
    """The same, where one function of what is known describes all of the recordings."""
    quiet = min(look.floor, size.floor(True))
    whole = wholly_described(remains, quiet, look.unknown, size.after)
    if whole is None:
        return look
    floor = quiet if remains.setting.model.is_time_model else look.floor
    return replace(look, unknown=True, left=whole, floor=floor, whole=True)


def _noted(outcome: Outcome, size: Size, look: _Look, fit: Fit | None) -> tuple[tuple[str, ...], float]:
    """Notes on how much is left, and the mean square that is noise; `fit`: what no catalogue holds and
    outdoes named effects."""
    notes, floor = tuple[str, ...](), look.floor
    if look.far:
        times = np.sqrt(size.after / floor)
        notes = far_notes(outcome, look.unknown, look.left, look.explained, times)
    if fit is not None:  # what the description leaves, and not what it explains, is noise
        floor = min(floor, size.floor(False, mean_square(plain_white(fit))))
    if size.stated and not look.far:
        notes = level_note(float(np.sqrt(floor)))
    return notes, floor


def _rival(setting: Setting, outcome: Outcome, left: Leftover | None) -> tuple[Fit, float] | None:
    """What no catalogue holds and outdoes named effects, and by how much; not where what they have `left`
    unknown is described better."""
    rival = outdone(setting, outcome)
    better = rival is not None and left is not None and left.gain > rival[1] + LEFT
    return None if better else rival


def _probability(left: Leftover, structured: bool, may_be_noise: bool, lead: float | None) -> float:
    """How sure it is that what is left is physics that nothing names; `lead`: the evidence by which what
    describes it is ahead of named effects."""
    if lead is not None:
        odds = float(np.exp(min(lead, 60.0) / (2 * TEMPER)))
    elif may_be_noise:
        odds = 1.0
    else:
        odds = float(np.exp(min(left.gain, 60.0) / 2 - 5.0)) if structured else 9.0
    return (1 - OUTSIDE) * odds / (1 + odds)


def _left(remains: Remains, after: float) -> Leftover:
    """What is left of the best hypothesis, of mean square `after`, and with how much evidence."""
    setting, outcome = remains.setting, remains.outcome
    left = remains.likeliest(remains.of_best)
    if setting.model.is_time_model and any(s.whitener.root is not None for s in setting.series):
        return replace(left, gain=left.gain * min(1.0, after))  # what is allowed for tells no level
    if setting.model.is_time_model or outcome.best.ids:
        return left
    return left if left.gain > _gained_by_refused(setting, outcome) else replace(left, gain=0.0)


def _nameless(setting: Setting, outcome: Outcome, left: Leftover, part: float) -> bool:
    """Whether effects that go so great a `part` of the way are too unsure for a name, or less near than what
    describes the rest."""
    named = standings(outcome)
    likeliest = part * max(x.probability for x in named)
    if part * max(x.kin for x in named) < LIKELY or likeliest < NAMELESS:
        return True
    return likeliest < LIKELY and nearer(setting, outcome, left)


def modelled(setting: Setting, outcome: Outcome, gate: Gate) -> Gate:
    """The gate with a model of what is unknown, the best that there is; None where nothing describes it, or
    far from the recordings nothing better than effects that are too unsure for a name."""
    if gate.fit is not None or not gate.leftover.terms:
        return gate
    terms = described(setting, outcome, gate.leftover)
    other = best_unlisted(with_rivals(setting, outcome))
    if outcome.judge.temper > 1.0 and outcome.best.ids:
        found = [f for f in (terms, other) if f is not None]
        if min((f.bic for f in found), default=np.inf) > outcome.best.bic:
            return gate
    if other is None or outcome.base.bic - other.bic < ALARM or (terms is not None and terms.bic < other.bic):
        return gate if terms is None else _levelled(replace(gate, fit=terms), terms)
    return replace(gate, fit=other, leftover=as_leftover(outcome, other, gate.leftover.gain))


def _levelled(gate: Gate, terms: Fit) -> Gate:
    """The gate with no more noise than a description leaves: from sample to sample a hum looks like it."""
    floor = min(gate.floor, mean_square(plain_white(terms)))
    return replace(gate, floor=floor, scale=float(np.sqrt(floor)))


def _beside(before: float, after: float) -> bool:
    """Whether named effects explain the smaller part of what is beyond the stated noise, and a smooth error
    that nobody stated the rest: as well it may be what they stand in for."""
    return after > FITS**2 and before - after < PART * (before - 1)


def _unexplained(
    setting: Setting, outcome: Outcome, left: Leftover, gross: bool, explained: float
) -> bool:  # fmt: skip
    """Whether what is left after the best hypothesis is physics that it doesn't name."""
    if outcome.judge.temper > 1.0:
        return not outcome.best.hypothesis.added or explained < PART or nearer(setting, outcome, left, TWICE)
    if left.line and outcome.best.hypothesis.added:  # no other account of what the effects are named for
        beside = gained_beside(outcome.judge, outcome.base, outcome.best, left.line)
        return beside < ALARM * len(outcome.best.ids)
    gained = outcome.base.bic - outcome.best.bic
    if left.gain > LEFT and left.gain > REST * gained:
        return True
    # of a noise that nobody stated, and that is alike along the sweep, neighbours tell no level
    alike = not setting.model.is_time_model and not any(s.stated for s in setting.series) and left.gain <= 0
    return gross and explained < EXPLAINED and not (alike and gained > BEYOND)


def _better_named(remains: Remains, explained: float, floor: float) -> bool:
    """Whether named effects, though they leave a part, are a better account of the recordings than anything
    that describes the whole: real records hold many effects, none exactly.

    A channel that levels off looks like a material that softens: it has to be all that there is.
    """
    setting, outcome = remains.setting, remains.outcome
    least, much = (SOME, SOME) if setting.model.is_time_model else (PART, MUCH)
    if explained <= least or outcome.judge.temper > 1.0 or not outcome.best.hypothesis.added:
        return False
    whole = remains.likeliest(remains.of_base)
    terms = described(setting, outcome, whole)
    if terms is not None and whole.terms[0] == LEVEL and not but_noise(terms, floor):
        terms = None
    unlisted = best_unlisted(outcome)
    modelled = max((outcome.base.bic - f.bic for f in (terms, unlisted) if f is not None), default=0.0)
    named, rival = gained(setting, outcome, outcome.best), max(whole.gain, modelled)
    return named > (rival - CLOSE if explained > much else RATHER * rival)


def _gained_by_refused(setting: Setting, outcome: Outcome) -> float:
    """What the best single effect gains on the base that the search would not claim."""
    if any(s.measure != "real" for s in setting.series):
        return outcome.base.bic - refused(outcome)
    singles = sorted((f for f in outcome.tried if len(f.ids) == 1), key=lambda f: f.bic)[:CONTENDERS]
    return max((gained(setting, outcome, f) for f in singles), default=0.0)
