"""What is left where the motion is not recorded but follows from a drive: terms of displacement and speed at
each port, as the output feels them through the model itself."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from modelgen.codegen import build
from modelgen.diagnose.gate.describe import POWERS, powers, wave
from modelgen.diagnose.hypotheses.functions import PITCHES, wave_number
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.scales import values_at
from modelgen.effects import Effect
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


def felt_waves(fit: Fit, judge: Judge) -> Iterator[tuple[Port, list[Array], Array]]:
    """(port, its position in each recording, whitened derivatives (N, 2 × pitches) by the amplitudes of waves
    over it) for each port that knows its position, first order about the fit."""
    e = fit.hypothesis.experiment
    for port in e.model.ports:
        at = {key: str(x) for key, x in port.variables}
        values = [values_at(e, fit.theta, k) for k in range(len(e.series))] if "z" in at else []
        z = [x[at["z"]] for x in values if np.ndim(x.get(at["z"], 0.0)) == 1]
        if not z or len(z) < len(values) or not all(np.ptp(x) > 0 and np.isfinite(x).all() for x in z):
            continue
        id = f"unknown_{port.name}"
        effect = wave(id, port, 1.0, harmonics=1)
        grown = _grown(e, effect, port, [f"{id}_{q.name}" for q in effect.strengths])
        if grown is None:
            continue
        numbers = (wave_number(k, z) for k in range(len(PITCHES)))
        waves = (replace(grown, constants={**e.constants, f"{id}_kappa": kappa}) for kappa in numbers)
        columns = [_felt(x, fit.theta, judge) for x in waves]
        if all(c is not None for c in columns):
            yield port, z, np.concatenate([c for c in columns if c is not None], axis=1)


def _columns(e: Experiment, theta: Array, judge: Judge, port: Port, group: str) -> Array | None:
    """Derivatives by the amounts of a group's terms at none of them; none where they can't be had."""
    effect = powers(f"unknown_{port.name}", port, POWERS[group])
    grown = _grown(e, effect, port, [f"{effect.id}_{q.name}" for q in effect.strengths])
    return None if grown is None else _felt(grown, theta, judge)


def _grown(e: Experiment, effect: Effect, port: Port, names: Sequence[str]) -> Experiment | None:
    """The experiment with an effect's strengths, called `names`, beside its parameters; None where the effect
    can't be had."""
    try:
        model = effect.extend(e.model, port)
    except InputError:
        return None
    new = [p for p in effect.parameters(e.model, port).values() if p.name in names]
    old = e.layout
    place = np.tile(len(old.names) + np.arange(len(new)), (len(e.series), 1))
    layout = replace(
        old,
        wrt=(*old.wrt, *names),
        names=(*old.names, *names),
        parameters=(*old.parameters, *new),
        place=np.concatenate([old.place, place], axis=1),
        held=np.concatenate([old.held, np.full(place.shape, np.nan)], axis=1),
    )
    return Experiment(model, build(model, layout.wrt, wait=True), layout, e.series, e.constants)


def _felt(grown: Experiment, theta: Array, judge: Judge) -> Array | None:
    """Whitened derivatives, each of length 1, by what has been added at none of it."""
    here = np.concatenate([theta, np.zeros(len(grown.layout.names) - len(theta))])
    with np.errstate(all="ignore"):
        columns = grown.columns(here, range(len(theta), len(here)), judge.whiteners)
    columns = columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    return columns if np.all(np.isfinite(columns)) else None
