"""A further effect that may be almost anything is not claimed where models stay far from the recordings
(whatever bends takes a part of the rest), nor one that is seldom there when it is named so; and three that
take the place of one are no names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from modelgen.diagnose.gate.gate import Gate
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.hypotheses.ranking import Standing
from modelgen.diagnose.hypotheses.refit import mean_square, misfit, plain_white
from modelgen.diagnose.hypotheses.setting import Outcome, Setting
from modelgen.diagnose.search.fewer import parts

FAMILIES = 4
"""Families of physics that a further effect may be one of, and still be told."""
SURELY, MISSED = 0.5, 1.5
"""… unless it takes away more than this share of what is left without it, and leaves noise (no more than so
many times its mean square): then something is there, whatever it is, and its rivals are told."""
SELDOM = 0.2
"""Probability below which a third one is only noted, where the rest leaves little."""

LITTLE, STAND_IN = 0.25, 0.65
"""Share of what two leave up to which a third one is none of its own, and how sure it is then that something
else is there: it was in five of six records of other simulators."""


def told(
    setting: Setting, outcome: Outcome, standing: Sequence[Standing]
) -> tuple[Outcome, tuple[Standing, ...], tuple[str, ...]]:
    """Outcome and standings without further effects that may be of more than FAMILIES kinds, and a note on
    each."""
    notes: tuple[str, ...] = ()
    families = {a.id: a.family for a in setting.additions}
    kept = list(standing)
    for s in standing[:0:-1]:
        names = (s.addition.id, *s.equivalents)
        if len({families.get(i, i) for i in names}) <= FAMILIES:
            continue
        less, share = _without(setting, outcome, s)
        if share > SURELY and outcome.judge.temper == 1.0 and mean_square(plain_white(outcome.best)) < MISSED:
            continue
        kept.remove(s)
        outcome = less
        notes += (
            f"one more effect would take away {share:.0%} of what is left: any of {', '.join(names)}. "
            "Not told apart, so none is claimed",
        )
    return outcome, tuple(kept), notes


def likely(
    setting: Setting, outcome: Outcome, standing: tuple[Standing, ...]
) -> tuple[Outcome, tuple[Standing, ...], tuple[str, ...]]:
    """Outcome and standings without a third effect that is seldom there when it is named so, and a note."""
    last = standing[-1] if standing else None
    if last is None or len(standing) < 3 or outcome.judge.temper > 1.0 or last.probability >= SELDOM:
        return outcome, standing, ()
    outcome, share = _without(setting, outcome, last)
    note = (
        f"one more effect would take away {share:.0%} of what is left: {last.addition.id}, which at "
        f"{last.probability:.0%} is not claimed"
    )
    return outcome, standing[:-1], (note,)


def of_many(setting: Setting, outcome: Outcome, standing: Sequence[Standing], gate: Gate) -> Gate | None:
    """The gate for what takes three effects of which the third is seldom there and takes away little of what
    two leave: a law of its own that they put together, as a rule."""
    last = standing[-1] if standing else None
    if last is None or len(standing) < 3 or outcome.judge.temper > 1.0 or last.probability >= SELDOM:
        return None
    less, share = _without(setting, outcome, last)
    if share >= LITTLE:
        return None
    first = standing[0].addition
    together = ", ".join(s.addition.id for s in standing[:-1]) + f" and {last.addition.id}"
    says = f"it takes three of them together, {together}, which as a rule stand in for one that is not listed"
    rest = Leftover(gain=0.0, chi2=0.0, port=first.port.name, says=says)
    return replace(
        gate, unknown=True, leftover=rest, probability=STAND_IN, notes=(), fit=outcome.best, tied=less.best
    )


def _without(setting: Setting, outcome: Outcome, s: Standing) -> tuple[Outcome, float]:
    """The outcome without one effect of its best hypothesis, and the share of what is left then that it takes
    away."""
    rest = outcome.best.hypothesis.key - {s.addition.key}
    less = next(f for f in parts(setting, outcome.judge, outcome.best) if f.hypothesis.key == rest)
    tried = [f for f in outcome.tried if f.hypothesis.key != rest]
    share = 1 - misfit(outcome.best) / misfit(less)
    return replace(outcome, best=less, tried=(less, *tried)), share
