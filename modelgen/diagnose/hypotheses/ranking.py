"""How sure: which hypotheses the data do not exclude, and with which probability."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modelgen.diagnose.hypotheses.addition import Addition
from modelgen.diagnose.hypotheses.refit import Fit, misfit
from modelgen.diagnose.hypotheses.setting import ALARM, CLOSE, TEMPER, Outcome

Key = tuple[str, str, int]

OUTSIDE = 0.04
"""How often what is there is none of the tried hypotheses (another law, a combination) although one fits: so
much less sure is a claim. On our own truths it was 2 % (PROOF.md); in records of other simulators, which held
laws that neither these truths nor the catalogue had, 6 of 230 such claims were wrong, earlier 7 of 67."""
HELD: tuple[tuple[float, ...], ...] = ((1.0,), (1.0, 0.8), (0.65, 0.5, 0.2))
"""How often, then, each of one, two, three claimed effects was there, by what they explain: a second one may
be what the first, of another law, leaves, and with three none may be the right one. A third that takes away
three quarters of what two leave is there as often as the second: no law that is nearly right leaves that."""
LITTLE, MUCH, PLENTY = 0.45, 0.8, 0.3
"""… a second one over time, where laws of friction and of memory are seldom exact: if it brings next to none
of the evidence, and from this part of it on. As counted in records of several simulators with other laws."""


@dataclass(frozen=True)
class Standing:
    """One effect of the verdict among its rivals: its probability, and ids that explain the data as well.

    elsewise: hypotheses as good that differ in more than this effect.
    kin: the same of it, another of its family or of the same variables at the same port, by the evidence
    alone, among rivals that differ in this effect alone.
    """

    addition: Addition
    probability: float
    equivalents: tuple[str, ...]
    share: float
    elsewise: tuple[Fit, ...] = ()
    kin: float = 0.0


def weights(fits: Sequence[Fit]) -> np.ndarray:
    """Posterior odds of rival fits: evidence times how common their physics is, normalised."""
    best = min(f.bic for f in fits)
    logs = np.array([-(f.bic - best) / (2 * TEMPER) for f in fits])
    w = np.exp(logs - logs.max())
    return np.asarray(w / w.sum())


def standings(outcome: Outcome) -> tuple[Standing, ...]:
    """The effects of the best fit, the one that explains most first, each with its rivals.

    Rivals of an effect are the tried hypotheses that differ from the best one in this effect alone; its
    equivalents are also of those that say it with more effects, or fewer. A rival counts as no better than
    the best: where coloured noise alone makes its evidence greater, it was refused for that.
    """
    best = outcome.best
    others = _elsewise(outcome)
    found = []
    for a in best.hypothesis.added:
        rest = best.hypothesis.key - {a.key}
        rivals = [
            f
            for f in outcome.tried
            if len(f.hypothesis.key) == len(best.hypothesis.key) and rest <= f.hypothesis.key
        ]
        if not any(f.hypothesis is best.hypothesis for f in rivals):
            rivals.append(best)
        odds = weights([f if f.bic > best.bic else replace(f, bic=best.bic) for f in rivals])
        w = np.maximum(odds, [_likelihood(outcome, f) * _alike(outcome, f) for f in rivals])
        w /= w.sum()
        by_id: dict[str, float] = {}
        kin = 0.0
        tied: dict[str, float] = {}
        for f, x, y in zip(rivals, w, odds, strict=True):
            other = next(b for b in f.hypothesis.added if b.key not in rest)
            by_id[other.id] = by_id.get(other.id, 0.0) + float(x)
            kin += float(y) if _akin(a, other) else 0.0
            if close(outcome, f):
                told = other.effect.alike if f.parameters <= best.parameters else ()  # not of what holds it
                for i in (other.id, *told):
                    tied[i] = min(tied.get(i, np.inf), f.bic)
        for i, f in others.get(a.key, ()):
            tied[i] = min(tied.get(i, np.inf), best.bic + _price(outcome, f))
        equivalents = tuple(sorted((i for i in tied if i != a.id), key=lambda i: tied[i]))
        elsewise = tuple({id(f): f for _, f in others.get(a.key, ())}.values())
        mine = next(float(x) for f, x in zip(rivals, w, strict=True) if f.hypothesis is best.hypothesis)
        sure = (1 - OUTSIDE) / (1 + mine * sum(_likelihood(outcome, f) for f in elsewise))
        share = _share(outcome, a)
        found.append(Standing(a, by_id[a.id] * sure, equivalents, share, elsewise, kin * (1 - OUTSIDE)))
    found.sort(key=lambda x: -x.share)
    held = _held(outcome, [x.addition for x in found])
    found = [replace(x, probability=x.probability * p) for x, p in zip(found, held, strict=True)]
    if len(found) == 2 and held[1] < DOUBTFUL:
        found[0] = _or_alone(outcome, found[0], held[1])
    return tuple(found)


DOUBTFUL = 0.5
"""Chance of a second effect below which the first one stands for what is told without it, too: what a law
that is not quite right leaves may decide between two that explain the rest alike."""


def _or_alone(outcome: Outcome, first: Standing, sure: float) -> Standing:
    """The `first` of two effects, the second of which is there with a chance of `sure`."""
    mine = frozenset({first.addition.key})
    best = next((f for f in outcome.tried if f.hypothesis.key == mine), None)
    if best is None:
        return first
    alone = standings(replace(outcome, best=best))[0]
    rivals = [
        f
        for f in outcome.tried
        if len(f.ids) == 1 and f.ids[0] in alone.equivalents and close(replace(outcome, best=best), f)
    ]
    return replace(
        first,
        probability=sure * first.probability + (1 - sure) * alone.probability,
        equivalents=tuple(dict.fromkeys((*first.equivalents, *alone.equivalents))),
        elsewise=(*first.elsewise, *rivals, *alone.elsewise),
    )


def _akin(a: Addition, b: Addition) -> bool:
    same = a.port.name == b.port.name and set(a.effect.needs) == set(b.effect.needs)
    return a.family == b.family or same


def _held(outcome: Outcome, added: Sequence[Addition]) -> tuple[float, ...]:
    """How often each of these effects, the first explains most, was there when a hypothesis of them fits."""
    if not added:
        return ()
    held, best = HELD[min(len(added), len(HELD)) - 1], outcome.best
    if len(added) == 3:
        takes = 1 - misfit(best) / max(_without(outcome, added[2]), 1e-300)
        return *held[:2], held[2] + (held[1] - held[2]) * float(np.clip(2 * takes - 0.5, 0.0, 1.0))
    if len(added) != 2 or not best.hypothesis.experiment.model.is_time_model:
        return held
    rest = best.hypothesis.key - {added[1].key}
    without = min((f.bic for f in outcome.tried if f.hypothesis.key == rest), default=outcome.base.bic)
    part = (without - best.bic) / max(outcome.base.bic - best.bic, ALARM)
    return held[0], LITTLE + (MUCH - LITTLE) * float(np.clip(part / PLENTY, 0.0, 1.0))


FEW = 2
"""Hypotheses of another kind that are told."""


def _elsewise(outcome: Outcome) -> dict[Key, list[tuple[str, Fit]]]:
    """Hypotheses that differ in more than one effect and that the data exclude as little: the best few, each
    of their effects in the place of one of the best hypothesis (of its family, or at its port).

    More effects cost what each has to gain to be claimed. One that adds to the same physics, by other laws,
    is another account if it has fewer numbers.
    """
    best = outcome.best
    tied = []
    for f in outcome.tried:
        shared = best.hypothesis.key & f.hypothesis.key
        single = len(f.ids) == len(best.ids) and len(shared) == len(best.ids) - 1
        if (
            f.ids
            and not single
            and not _adds(f, best)
            and not set(f.ids) <= set(best.ids)
            and (_price(outcome, f) < CLOSE or _as_wrong(outcome, f))
        ):
            tied.append(f)
    found: dict[Key, list[tuple[str, Fit]]] = {}
    for f in sorted(tied, key=lambda f: _price(outcome, f))[:FEW]:
        added = [a for a in best.hypothesis.added if a.key not in f.hypothesis.key]
        gone = [a for a in added if a.id not in f.ids] or added
        for b in f.hypothesis.added:
            if b.id not in best.ids and not _beside(outcome, f, b):
                alike = [a for a in gone if a.family == b.family]
                near = [a for a in gone if a.port.name == b.port.name]
                found.setdefault((alike or near or gone)[0].key, []).append((b.id, f))
    return found


SMALL = 0.1
"""Part of what is explained that an effect brings which only mends what another law leaves."""


def _beside(outcome: Outcome, f: Fit, b: Addition) -> bool:
    """Whether `f` has more effects than the best hypothesis, and without this one would explain nearly as
    much: then the others stand in its place, and this one in nobody's."""
    if len(f.ids) <= len(outcome.best.ids):
        return False
    rest = f.hypothesis.key - {b.key}
    without = min((g.chi2 for g in outcome.tried if g.hypothesis.key == rest), default=np.inf)
    return without - f.chi2 < SMALL * (outcome.base.chi2 - f.chi2)


def _adds(f: Fit, best: Fit) -> bool:
    """Whether `f` is the physics of the best hypothesis with more beside it, and no simpler for that."""
    more = set(f.ids) >= set(best.ids)
    return more and (f.parameters >= best.parameters or f.hypothesis.key >= best.hypothesis.key)


WRONG = 1.5
"""Where even the best hypothesis leaves far more than noise, none is true: those whose residual is at most so
many times as large are no worse an account."""
ALIKE = 0.75
"""… if what differs takes away this share of the misfit that its counterpart in the best one takes away,"""
WIDE = 3 * CLOSE
"""… and ΔBIC, in so many independent data as the rest has, is no more than this."""


def _as_wrong(outcome: Outcome, f: Fit) -> bool:
    """Whether `f`, with as many effects, is as good an account of recordings that none accounts for."""
    best = outcome.best
    if outcome.judge.temper == 1.0 or len(f.ids) != len(best.ids):
        return False
    if f.bic - best.bic > WIDE or f.chi2 >= WRONG**2 * best.chi2:
        return False
    shared = best.hypothesis.key & f.hypothesis.key
    less = min((g.chi2 for g in outcome.tried if g.hypothesis.key == shared), default=outcome.base.chi2)
    return less - f.chi2 >= ALIKE * (less - best.chi2)


NEARLY = 0.03
"""Of all that is explained, in rms: so much a law of fewer numbers may leave beside the best one. A tapered
rod is not the textbook's, and a law with one number more bends to what that leaves."""


def _nearly(outcome: Outcome, f: Fit) -> bool:
    """Whether `f`, with as many effects and fewer numbers, leaves no more than what laws of the right kind
    are off by, though by its evidence it is excluded, but not by far."""
    best = outcome.best
    if not best.ids or len(f.ids) != len(best.ids) or f.parameters >= best.parameters:
        return False
    if not CLOSE <= f.bic - best.bic <= WIDE:
        return False
    shared, after = best.hypothesis.key & f.hypothesis.key, misfit(best)
    less = min((misfit(g) for g in outcome.tried if g.hypothesis.key == shared), default=misfit(outcome.base))
    return misfit(f) - after < NEARLY**2 * (less - after)


def _alike(outcome: Outcome, f: Fit) -> bool:
    return _as_wrong(outcome, f) or _nearly(outcome, f)


def close(outcome: Outcome, f: Fit) -> bool:
    """Whether the data do not exclude `f`, with as many effects as the best hypothesis."""
    return f.bic - outcome.best.bic < CLOSE or _alike(outcome, f)


def _likelihood(outcome: Outcome, f: Fit) -> float:
    """Of `f`, over that of the best hypothesis."""
    if _as_wrong(outcome, f):
        return float(outcome.best.chi2 / f.chi2)
    if _nearly(outcome, f):
        return 1.0
    return float(np.exp(-_price(outcome, f) / (2 * TEMPER)))


def _price(outcome: Outcome, f: Fit) -> float:
    """By how much the evidence for `f` is less than that for the best hypothesis; if `f` has more effects,
    also than for the best one with as many: what a law that is not quite right leaves, one effect more mends
    beside any of them.

    0 where coloured noise alone makes it greater: for that the search has refused it.
    """
    best = outcome.best
    more = [g.bic for g in outcome.tried if len(g.ids) == len(f.ids) and set(g.ids) > set(best.ids)]
    return max(0.0, f.bic - min([best.bic - ALARM * (len(f.ids) - len(best.ids)), *more]))


def as_ranked(outcome: Outcome, f: Fit) -> Fit:
    """`f` with the evidence that it is ranked by: where coloured noise alone makes that greater, or where
    both are wrong alike, as much as the best hypothesis has."""
    price = 0.0 if _alike(outcome, f) else _price(outcome, f)
    return replace(f, bic=outcome.best.bic + price)


def _share(outcome: Outcome, a: Addition) -> float:
    """The part of the explained misfit that is back when this effect alone is left out of the best
    hypothesis: of the misfit as it stands in the recordings, whatever the colour of what is left."""
    after, before = misfit(outcome.best), misfit(outcome.base)
    level = _without(outcome, a)
    return float(np.clip((level - after) / (before - after), 0.0, 1.0)) if before > after else 1.0


def _without(outcome: Outcome, a: Addition) -> float:
    """What the best hypothesis leaves without one of its effects; what fewer do, these can."""
    rest = outcome.best.hypothesis.key - {a.key}
    less = [misfit(f) for f in outcome.tried if f.hypothesis.key <= rest]
    return min(less, default=misfit(outcome.base))
