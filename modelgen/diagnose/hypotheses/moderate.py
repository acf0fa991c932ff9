"""What recordings leave open of an effect's shape is taken at its middle: a law is used beyond what was
fitted.

Of a softening that is complete at every recorded amplitude nothing tells where it begins. A least sum of
squares lies anywhere in such a valley, often on a bound, and predicts other amplitudes wildly. The mean over
the range in which the shape is searched, weighed by likelihood, is as good an account and the safest guess (a
prior that is uniform in the logarithm: H. Jeffreys, Theory of Probability (1961), sec. 3.1).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modelgen.diagnose.hypotheses.addition import Addition
from modelgen.diagnose.hypotheses.evidence import deviance
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.effects import Shape
from modelgen.fit.uncertainty import assess

OPEN = 0.25
"""A shape is open when its standard deviation is more than this share of the range that is searched."""
POINTS = 7
"""Values of it that are tried there."""
AS_GOOD = 1.0
"""What the middle may lose in −2 ln of the likelihood: a standard deviation."""


def moderated(judge: Judge, f: Fit) -> Fit:
    """`f` with each shape of its effects that the recordings leave open at the middle of what they leave."""
    if not f.hypothesis.added:
        return f
    std = assess(f.hypothesis.experiment.problem(f.theta, judge.whiteners), f.theta).std
    for a in f.hypothesis.added:
        for q in a.effect.shapes:
            at, (low, high) = f.hypothesis.names.index(f"{a.id}_{q.name}"), a.ranges[q.name]
            if q.log and not std[at] < OPEN * np.log(high / low) * f.theta[at]:
                f = _in_the_middle(judge, f, a, q)
    return f


def _in_the_middle(judge: Judge, f: Fit, a: Addition, q: Shape) -> Fit:
    """`f` at the mean of the shape's logarithm over its range, or as it is where that is a worse account."""
    values = np.geomspace(*a.ranges[q.name], POINTS)
    lost = np.array([_lost(judge, f, _held(judge, f, a, q, x)) for x in values])
    w = np.exp(-0.5 * np.maximum(lost, 0.0))
    if not w.sum() > 0:
        return f
    middle = _held(judge, f, a, q, float(np.exp(w @ np.log(values) / w.sum())))
    return middle if _lost(judge, f, middle) < AS_GOOD else f


def _lost(judge: Judge, f: Fit, other: Fit) -> float:
    """By how much −2 ln of the likelihood of `other` is above that of `f`."""
    return (deviance(other.white, judge.prior) - deviance(f.white, judge.prior)) / judge.temper


SLIM = 1e-4
"""Relative width of the bounds that hold a value."""


def _held(judge: Judge, f: Fit, a: Addition, q: Shape, value: float) -> Fit:
    """`f` fitted anew with a shape at `value`."""
    h, name = f.hypothesis, f"{a.id}_{q.name}"
    slim = tuple(
        replace(p, bounds=(value * (1 - SLIM), value * (1 + SLIM))) if p.name == name else p
        for p in h.experiment.layout.parameters
    )
    layout = replace(h.experiment.layout, parameters=slim)
    start = h.place(h, f.theta, {name: value})
    there = judge.fit(replace(h, experiment=replace(h.experiment, layout=layout)), [start])
    return judge.look(h, there.theta)
