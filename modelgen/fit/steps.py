"""Whether the steps in which states are integrated are short enough: what they miss looks like physics."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modelgen.fit.experiment import Experiment
from modelgen.fit.series import Array
from modelgen.language import Model, State
from modelgen.language.check import MOST_STEPS

TOLERATED = 0.3
"""Change of the output with twice the steps, in rms over the noise, up to which a recording is simulated well
enough: it adds a twentieth to what is left."""


def finer(model: Model) -> Model:
    """`model` with twice as many steps between samples, as far as a model may have so many."""

    def twice(s: State) -> State:
        return replace(s, substeps=min(2 * s.substeps, MOST_STEPS)) if s.rate is not None else s

    return replace(model, statements=tuple(twice(s) if isinstance(s, State) else s for s in model.statements))


def step_errors(e: Experiment, theta: Array) -> list[float]:
    """What twice the steps change of each recording, in rms over the noise, at θ; none of a model in which
    nothing is integrated."""
    if not any(s.rate is not None for s in e.model.states):
        return []
    from modelgen.codegen import build

    model = finer(e.model)
    other = replace(e, model=model, function=build(model, e.layout.wrt))
    found = []
    for k, s in enumerate(e.series):
        with np.errstate(all="ignore"):
            change = replace(s.whitener, ar=None).apply(other.raw(theta, k) - e.raw(theta, k))
            found.append(float(np.sqrt(np.mean(change[change != 0] ** 2))) if np.any(change) else 0.0)
    return found


def coarse(e: Experiment, theta: Array) -> list[str]:
    """A note for each recording that takes shorter steps."""
    return [
        f"'{s.name}': with twice the steps between samples the model's output changes by {x:.3g} times the "
        "noise, and parameters make up for it; give its states more `substeps`, or `stiff=True`"
        for s, x in zip(e.series, step_errors(e, theta), strict=False)
        if not x < TOLERATED
    ]


def runs_away(e: Experiment, theta: Array) -> str:
    """Where the output ceases to be finite at θ, and what may be the matter; "" where it doesn't."""
    axis = e.model.inputs[0]
    for k, s in enumerate(e.series if np.all(np.isfinite(theta)) else ()):
        with np.errstate(all="ignore"):
            bad = np.flatnonzero(~np.all(np.isfinite(e.raw(theta, k)), axis=0))
        if bad.size:
            x = s.inputs[axis.name]
            where = f"in '{s.name}' from {axis.name} = {x[bad[0]]:.6g} {axis.unit} on"
            steps = np.median(np.diff(x)) if len(x) > 1 else 0.0
            if any(state.rate is not None for state in e.model.states):
                return (
                    f"{where}: steps of {steps:.3g} {axis.unit} are too long for a state (a time in another "
                    "unit?), or it needs more `substeps`, or `stiff=True`"
                )
            return where
    return ""
