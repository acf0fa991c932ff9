"""A further effect that may be almost anything is not claimed: where models stay far from the recordings,
whatever bends takes a part of the rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from modelgen.diagnose.hypotheses.ranking import Standing
from modelgen.diagnose.hypotheses.refit import misfit
from modelgen.diagnose.hypotheses.setting import Outcome, Setting
from modelgen.diagnose.search.swap import parts

FAMILIES = 4
"""Families of physics that a further effect may be one of, and still be told."""


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
        kept.remove(s)
        rest = outcome.best.hypothesis.key - {s.addition.key}
        less = next(f for f in parts(setting, outcome.judge, outcome.best) if f.hypothesis.key == rest)
        share = 1 - misfit(outcome.best) / misfit(less)
        notes += (
            f"one more effect would take away {share:.0%} of what is left: any of {', '.join(names)}. "
            "Not told apart, so none is claimed",
        )
        outcome = replace(outcome, best=less)
    return outcome, tuple(kept), notes
