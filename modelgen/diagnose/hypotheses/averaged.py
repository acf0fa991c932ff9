"""Parameters with what they do not agree on among the hypotheses that the data leave open.

A base parameter's variance is that of model averaging: Σ_k w_k (σ_k² + (θ_k − θ)²) over rival fits k of
weight w_k (S. T. Buckland, K. P. Burnham, N. H. Augustin, Biometrics 53 (1997) 603), θ the best fit's.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.ranking import weights
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import Outcome
from modelgen.fit.result import Estimate, estimates
from modelgen.fit.separating import confusions
from modelgen.fit.uncertainty import assess

RIVALS = 8
"""At most so many fits are averaged over; those of less weight than a hundredth are not."""


def parameters(judge: Judge, fit: Fit) -> tuple[Estimate, ...]:
    """Values and standard deviations, the noise's level estimated from the residual; of what a wrong model
    leaves, samples as far apart as `judge.temper` are independent."""
    problem = fit.hypothesis.experiment.problem(fit.theta, judge.whiteners)
    n = effective(fit.white)
    scale = float(np.sqrt(judge.temper * fit.chi2 / max(1, n - fit.parameters)))
    known = assess(problem, fit.theta)
    found = estimates(problem, fit.theta, known)
    return tuple(replace(x, std=x.std * max(scale, 1.0)) for x in found)


def as_one(judge: Judge, fit: Fit) -> tuple[str, ...]:
    """Notes on parameters that are as one in the recordings: each by itself is hardly known."""
    e = fit.hypothesis.experiment
    return tuple(map(str, confusions(e, fit.theta, assess(e.problem(fit.theta, judge.whiteners), fit.theta))))


def averaged(outcome: Outcome, best: Fit) -> tuple[Estimate, ...]:
    """Parameters of `best`; those that the base has, too, as uncertain as the open rivals make them.

    What does the same as parameters of the base (`Outcome.blind`) is no rival: it would share their values
    with them in any way. Nor is what adds to the effects of `best`: that is not claimed.
    """
    own, key = parameters(outcome.judge, best), best.hypothesis.key
    blind = {a.key for a in outcome.blind} - key
    others = (f for f in outcome.tried if not f.hypothesis.key >= key and not f.hypothesis.key & blind)
    rivals = sorted(others, key=lambda f: f.bic)
    fits = [best, *rivals[: RIVALS - 1]]
    w = weights(fits)
    if not best.hypothesis.added or w[0] > 0.99:
        return own
    open_ = [
        (x, {e.name: e for e in parameters(outcome.judge, f)})
        for f, x in zip(fits, w, strict=True)
        if x > 0.01
    ]
    base = set(outcome.base.hypothesis.names)
    return tuple(replace(e, std=_spread(e, open_)) if e.name in base else e for e in own)


def _spread(e: Estimate, rivals: list[tuple[float, dict[str, Estimate]]]) -> float:
    seen = [(w, known[e.name]) for w, known in rivals if np.isfinite(known[e.name].std)]
    if not np.isfinite(e.std) or not seen:
        return e.std
    total = sum(w for w, _ in seen)
    return float(np.sqrt(sum(w * (x.std**2 + (x.value - e.value) ** 2) for w, x in seen) / total))
