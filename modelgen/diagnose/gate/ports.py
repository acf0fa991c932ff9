"""What is left where the motion is not recorded but follows from a drive: terms of displacement and speed at
each port, as the output feels them through the model itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from modelgen.codegen import build
from modelgen.diagnose.gate.describe import POWERS, powers
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.errors import InputError
from modelgen.fit.experiment import Experiment
from modelgen.fit.series import Array
from modelgen.language import Port

SAYS = {
    "displacement": "a term that depends on {z} alone",
    "speed": "a term that depends on {v} alone",
    "both": "a term that depends on {z} and {v} together",
}


def felt_terms(fit: Fit, judge: Judge) -> Iterator[tuple[Port, str, str, Array]]:
    """(port, group of `POWERS`, words, whitened derivatives (N, terms)) for each port that knows its motion,
    first order about the fit."""
    e = fit.hypothesis.experiment
    for port in e.model.ports:
        at = {key: str(x) for key, x in port.variables}
        for group, says in SAYS.items():
            if {"z", "v"} <= set(at):
                columns = _columns(e, fit.theta, judge, port, group)
                if columns is not None:
                    yield port, group, says.format(**at), columns


def _columns(e: Experiment, theta: Array, judge: Judge, port: Port, group: str) -> Array | None:
    """Derivatives by the amounts of a group's terms at none of them; none where they can't be had."""
    effect = powers(f"unknown_{port.name}", port, POWERS[group])
    try:
        model = effect.extend(e.model, port)
    except InputError:
        return None
    new = tuple(effect.parameters(e.model, port).values())
    names, count, old = tuple(p.name for p in new), len(new), e.layout
    place = np.tile(len(old.names) + np.arange(count), (len(e.series), 1))
    layout = replace(
        old,
        wrt=(*old.wrt, *names),
        names=(*old.names, *names),
        parameters=(*old.parameters, *new),
        place=np.concatenate([old.place, place], axis=1),
        held=np.concatenate([old.held, np.full(place.shape, np.nan)], axis=1),
    )
    grown = Experiment(model, build(model, layout.wrt, wait=True), layout, e.series, e.constants)
    here = np.concatenate([theta, np.zeros(count)])
    with np.errstate(all="ignore"):
        columns = grown.columns(here, range(len(theta), len(here)), judge.whiteners)
    columns = columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    return columns if np.all(np.isfinite(columns)) else None
