"""What errors of a smoothed motion alone give a hypothesis: the same analysis of records made without it.

A hypothesis that smooths or shifts the model's force (a lag, a mass) also smooths the errors that are left
in the motion, and gains by it although nothing of the kind is there: no covariance that all hypotheses share
can tell the two apart. A parametric bootstrap can (B. Efron, R. Tibshirani, An Introduction to the Bootstrap
(1993), ch. 6): let the smoothed path be the true one and the parent model the truth, add noise to both,
smooth again, fit both. So, too, of two rivals: the one that takes more of these errors leads even where the
other is there (D. R. Cox, J. R. Stat. Soc. B 24 (1962) 406: each in turn is the truth).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from modelgen.diagnose.hypotheses.evidence import deviance
from modelgen.diagnose.hypotheses.hypothesis import Hypothesis
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.fit.colour import noise_like
from modelgen.fit.series import Array, Series, input_noise
from modelgen.fit.whitener import Whitener
from modelgen.language import Model
from modelgen.recordings import Case
from modelgen.recordings.noise import quantum

TIMES = 3
"""Replicas of either rival: enough to tell a lead that the noise gives from one that the effect gives."""
NOTICED = 0.95, 0.01
"""Errors of motion matter where they leave less than this share of a sample's weight, at that share of the
samples."""

WIDER = 2.2
"""Standard deviation of normal numbers over the median of their distances from the median, in threes."""
SETTLED = 10.0
"""χ² by which a rival that is there must lead to have had a fair trial."""

Replica = Sequence[Series]


def motion_matters(whiteners: Sequence[Whitener]) -> bool:
    """Whether errors of the motion are a part of the noise worth speaking of."""
    share, samples = NOTICED
    return any(
        w.smear is not None and w.share is not None and float(np.mean(w.share < share)) > samples
        for w in whiteners
    )


def replicas(
    model: Model, case: Case, parent: Fit, whiteners: Sequence[Whitener], seed: int
) -> tuple[Series, ...]:
    """The series of `parent` measured anew: its smoothed path and its model's force, with fresh noise, that
    of the force as large and as coloured as `whiteners` take it for."""
    from modelgen.codegen.inputs import complete_inputs
    from modelgen.recordings.kinematics import kinematics

    e = parent.hypothesis.experiment
    moved = next(i.derived[1] for i in model.inputs if i.derived and i.derived[0] == "rate")
    rng = np.random.default_rng(seed)
    made = []
    for k, (s, recording, w) in enumerate(zip(e.series, case.fit, whiteners, strict=True)):
        told = input_noise(model, case, recording)
        sigma = told[moved]
        if sigma is None:
            sigma = kinematics(recording.inputs[model.axis], recording.inputs[moved], None).sigma_z
        path = _recorded(s.inputs[moved], recording.inputs[moved], sigma, rng)
        inputs, _ = complete_inputs(model, {**recording.inputs, moved: path}, {**told, moved: sigma})
        force = s.data + e.raw(parent.theta, k)
        share = np.ones(s.n) if w.share is None else np.maximum(w.share, 1e-6)
        level = np.median(share / np.maximum(w.weight, 1e-300), axis=1, keepdims=True)
        own = replace(w, ar=None).apply(e.raw(parent.theta, k))
        made.append(replace(s, inputs=inputs, data=force + level * noise_like(w, own, rng)))
    return tuple(made)


def _recorded(path: Array, like: Array, sigma: float, rng: np.random.Generator) -> Array:
    """A path (n,) as it would be recorded: with noise, in steps where the record is `like` that."""
    step = quantum(like)
    if sigma >= step:
        return path + sigma * rng.standard_normal(len(path))
    noise = float(np.sqrt(max(0.0, sigma**2 - step**2 / 12)))
    x = (path + noise * rng.standard_normal(len(path)) - like[0]) / step
    return np.asarray(like[0] + step * np.round(x))


def on(h: Hypothesis, series: Sequence[Series]) -> Hypothesis:
    """The hypothesis over other series of the same recordings."""
    e: Any = h.experiment
    return Hypothesis(h.added, type(e)(e.model, e.function, e.layout, tuple(series), e.constants))


def undeserved(judge: Judge, parent: Fit, child: Fit, series: Sequence[Series]) -> float:
    """What `child` gains in BIC over `parent` on replicas (`series`) in which `parent` is the truth; 0 or
    more."""
    plain = replace(judge, excess={})
    old = plain.fit(on(parent.hypothesis, series), [parent.theta])
    names = [f"{a.id}_{q.name}" for a in child.hypothesis.added for q in a.effect.shapes]
    values = {n: child.theta[child.hypothesis.names.index(n)] for n in names if n in child.hypothesis.names}
    null = child.hypothesis.place(parent.hypothesis, old.theta, values)
    new = plain.fit(on(child.hypothesis, series), [child.theta, null])
    return max(0.0, old.bic - new.bic)


def unfair(
    judge: Judge, best: Fit, rival: Fit, if_best: Iterable[Replica], if_rival: Iterable[Replica]
) -> float:
    """What `best` leads in BIC because errors of the motion suit it, be the `rival` there or not; 0 or more.

    if_best, if_rival: replicas in which the one or the other is the truth, made as they are asked for. Where
    `best` clearly leads although the rival is there, or its lead is within what it scatters by, it says no
    more than how likely it is with either truth (Student's t), and at least nothing: a few replicas, whose
    noise is as stated, exclude neither. A replica in which the rival is there and clearly leads settles it.
    """

    def lead(series: Replica) -> float:
        return _ahead(judge, *(judge.fit(on(f.hypothesis, series), [f.theta]) for f in (best, rival)))

    theirs: list[float] = []
    for series in if_rival:
        theirs.append(lead(series))
        if theirs[-1] < -SETTLED:
            return 0.0
    here = _ahead(judge, best, rival)
    leads = [np.array([lead(series) for series in if_best]), np.array(theirs)]
    middles, count = [float(np.median(x)) for x in leads], sum(x.size for x in leads)
    aside = np.concatenate([np.abs(x - m) for x, m in zip(leads, middles, strict=True)])
    variance = (WIDER * float(np.median(aside))) ** 2  # a descent that fails in one of them says nothing
    variance = max(variance, 2 * abs(middles[0] - middles[1]))  # at least that of a ratio of likelihoods
    off = [(here - m) ** 2 / (variance * (1 + 1 / x.size)) for x, m in zip(leads, middles, strict=True)]
    logs = [(count - 1) * np.log1p(x / (count - 2)) for x in off]
    clearly = middles[1] > 2 * np.sqrt(variance / leads[1].size)
    scattered = here < 2 * np.sqrt(variance)
    doubted = here > 0 and (clearly or scattered)
    return float(np.clip(here - (logs[1] - logs[0]), 0.0, here)) if doubted else 0.0


def _ahead(judge: Judge, best: Fit, rival: Fit) -> float:
    """By how much `best` fits better than `rival`, less what either is charged for errors of the motion,
    whatever their parameters cost."""
    a, b = (
        deviance(judge.look(f.hypothesis, f.theta).white, judge.prior)
        + judge.excess.get(f.hypothesis.key, 0.0)
        for f in (best, rival)
    )
    return b - a
