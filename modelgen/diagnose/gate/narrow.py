"""A claim from sweeps that stands on a few frequencies alone: a line that the samples do not resolve, or a
glitch of one sweep."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.gate.oddities import LOUD
from modelgen.diagnose.gate.rivals import LEFT
from modelgen.diagnose.hypotheses.refit import Fit
from modelgen.diagnose.hypotheses.setting import Outcome
from modelgen.diagnose.noise.noise import modelled_output, standing_alone
from modelgen.fit.series import Array

LONE = 3
"""Frequencies too few to carry a claim."""
BROAD = 0.2
"""Share of the evidence that must be found elsewhere."""


def narrow(outcome: Outcome) -> Leftover | None:
    """What is claimed from sweeps, when it stands on a few frequencies alone."""
    found = _claimed(outcome, outcome.base, outcome.best)
    return None if found is None or _elsewhere(outcome, found[1]) else found[0]


def glitch(outcome: Outcome) -> list[Array] | None:
    """(n,) bool of each sweep: the samples on which a claim stands, or one effect more of it, where they are
    of one sweep and another that passes there shows nothing of it; in a single sweep those on which one more
    of several effects stands; None where there are none such."""
    if len(outcome.best.white) == 1:
        return _of_the_sweep(outcome)
    for fewer in range(len(outcome.best.ids)):
        others = [f for f in outcome.tried if len(f.ids) == fewer] if fewer else [outcome.base]
        less = min(others, key=lambda f: f.bic, default=None)
        found = None if less is None else _of_one_sweep(outcome, less)
        if found is not None:
            return found
    return None


def _of_one_sweep(outcome: Outcome, less: Fit) -> list[Array] | None:
    """`glitch` of what the best hypothesis explains beyond `less`."""
    found = _claimed(outcome, less)
    if found is None or len(found[1]) < 2:
        return None
    e = outcome.best.hypothesis.experiment
    f = [s.inputs[e.model.axis] for s in e.series]
    loud = [m & (np.sum(x**2, axis=0) > LOUD) for m, x in zip(found[1], less.white, strict=True)]
    of = [k for k, m in enumerate(loud) if m.any()]
    if len(of) != 1:
        return None
    low, high = _around(f[of[0]], loud[of[0]])
    passed = [np.count_nonzero((low <= x) & (x <= high)) for k, x in enumerate(f) if k != of[0]]
    return loud if max(passed) >= np.count_nonzero(loud[of[0]]) else None


def _of_the_sweep(outcome: Outcome) -> list[Array] | None:
    """`glitch` of the only sweep: a lone sample that one effect of several has been taken in for."""
    for less in outcome.tried:
        if less.ids and less.hypothesis.key < outcome.best.hypothesis.key:
            found = _claimed(outcome, less)
            loud = found[1][0] & (np.sum(less.white[0] ** 2, axis=0) > LOUD) if found else np.zeros(0)
            if np.count_nonzero(loud) == 1:
                return [loud]
    return None


def _around(f: Array, some: Array) -> tuple[float, float]:
    """The band of some samples and one more on either side."""
    beside = f[np.convolve(some, np.ones(3), "same") > 0]
    return float(beside.min()), float(beside.max())


def _claimed(outcome: Outcome, less: Fit, own: Fit | None = None) -> tuple[Leftover, list[Array]] | None:
    """`lone` of the best hypothesis beside one with `less`; resonances that `own` has are no lines."""
    best = outcome.best
    e = best.hypothesis.experiment
    if e.model.is_time_model or not best.hypothesis.added or any(s.measure == "real" for s in e.series):
        return None
    f = [s.inputs[e.model.axis] for s in e.series]
    peaks = [np.zeros(len(x)) for x in f]
    if own is not None:
        peaks = [
            standing_alone(modelled_output(own.hypothesis.experiment, own.theta, k)) for k in range(len(f))
        ]
    return lone(f, less.white, best.white, peaks, best.hypothesis.added[0].port.name)


def lone(
    f: Sequence[Array], before: Sequence[Array], after: Sequence[Array], own: Sequence[Array], port: str
) -> tuple[Leftover, list[Array]] | None:
    """Evidence that stands on LONE frequencies of sweeps, a line narrower than the samples can resolve; and
    in each sweep the samples there, (n,) bool.

    before, after: (channels, n) whitened residuals without and with what is claimed. own: (n,) how far the
    model itself stands off its neighbours: where its own narrow resonance is shifted, so much is no line.
    """
    all_f = np.concatenate(f)
    gain = np.concatenate([np.sum(b**2 - a**2, axis=0) for b, a in zip(before, after, strict=True)])
    if all_f.size < 10 * LONE:
        return None
    places, which = np.unique(np.round(np.log(all_f), 4), return_inverse=True)
    at = np.bincount(which, gain, len(places))
    top = np.argsort(at)[::-1][:LONE]
    total = float(np.sum(at))
    if total < 2 * LOUD or total - float(np.sum(at[top])) > BROAD * total:
        return None  # faint, or wide
    if _rising(top, len(places)):
        return None
    if at[top[0]] < np.bincount(which, np.concatenate(own) ** 2, len(places))[top[0]]:
        return None
    says = f"something at {np.exp(places[top[0]]):.4g} Hz that is narrower than the samples can resolve"
    hit = np.isin(which, top)
    return Leftover(total, total, port, says), np.split(hit, np.cumsum([len(x) for x in f])[:-1])


def _rising(top: Array, count: int) -> bool:
    """Whether what is strongest is at an end of the band, and next to it what comes next: it rises towards
    what lies beyond."""
    first, second = min((top[0], top[1]), (count - 1 - top[0], count - 1 - top[1]))
    return bool(first == 0 and second <= LONE)


def _elsewhere(outcome: Outcome, line: Sequence[Array]) -> bool:
    """Whether the claim stands without the samples of a line, by which the base is bent no more."""
    masks = [np.where(m, 0.0, 1.0) for m in line]
    whiteners = tuple(w.masked(m) for w, m in zip(outcome.judge.whiteners, masks, strict=True))
    judge, base, best = replace(outcome.judge, whiteners=whiteners), outcome.base, outcome.best
    starts = [base.theta, best.hypothesis.values_of(best.theta, base.hypothesis)]
    gained = judge.fit(base.hypothesis, starts).bic - judge.fit(best.hypothesis, [best.theta]).bic
    return gained > LEFT
