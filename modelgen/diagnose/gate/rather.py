"""A smooth error of the instrument that nobody stated, weighed against a description of what may be in its
place.

The process can be anything that is smooth, and pays for that: marginal likelihoods of the two are compared,
each with noise of its own.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modelgen.diagnose.gate.unlisted import cheaper, is_unlisted, with_rivals
from modelgen.diagnose.hypotheses.refit import refine
from modelgen.diagnose.hypotheses.setting import Outcome, Setting
from modelgen.diagnose.noise.recolour import own_colours
from modelgen.diagnose.noise.smooth_error import quietness, smooth_error, with_smooth

FIRST = 3
"""Descriptions, the best by the noise as it was stated or estimated, whose own noise is looked at."""
RATHER = 30.0
"""ΔBIC by which a description must be better than the process: a dozen of them are tried at many places, and
what is broad comes near a smooth error."""


def rather_described(setting: Setting, outcome: Outcome) -> Outcome:
    """The outcome under the noise that a description leaves, where that is a better account than a smooth
    error of all that the base leaves."""
    judge = outcome.judge
    if judge.smooth is None or outcome.best.ids:
        return outcome
    whiteners = tuple(replace(s.whitener, ar=None) for s in setting.series)
    plain = replace(judge, whiteners=whiteners, smooth=None)
    base = refine(plain, [outcome.base])[0]
    tried = tuple(plain.look(f.hypothesis, f.theta) for f in outcome.tried)
    seen = with_rivals(setting, replace(outcome, judge=plain, base=base, best=base, tried=tried))
    rivals = sorted((f for f in seen.tried if is_unlisted(f)), key=lambda f: f.bic)[:FIRST]
    if not rivals:
        return outcome
    alone, *prices = own_colours(setting, plain, [base, *rivals])
    first = rivals[int(np.argmin(prices))]
    if alone - min(prices) < RATHER:
        return outcome
    others = [f for f in rivals if f is not first]  # by their own noise they say less
    seen = replace(seen, tried=tuple(f for f in seen.tried if all(f is not g for g in others)))
    process = smooth_error(plain, first)[2]
    if process is not None:
        lnf = [np.log(s.inputs[setting.model.axis]) for s in setting.series]
        roots = with_smooth(whiteners, lnf, process, quietness(setting.series, whiteners))
        plain = replace(plain, whiteners=roots, smooth=process)
        base = refine(plain, [base])[0]
        own = refine(plain, [first])[0]
        tried = tuple(own if f is first else plain.look(f.hypothesis, f.theta) for f in seen.tried)
        seen = replace(seen, judge=plain, base=base, best=base, tried=tried)
    return outcome if cheaper(seen) is None else seen
