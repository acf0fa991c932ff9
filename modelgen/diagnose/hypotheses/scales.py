"""Typical sizes in the recordings, by which the search ranges of effects are set."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from modelgen.fit.experiment import Experiment
from modelgen.fit.series import Array, Series
from modelgen.language import Model, Port
from modelgen.language.derived import derived_scale

CYCLES = 4
"""Times that a motion goes and comes back before what wanders with time is told from what follows it."""


def record_scales(model: Model, series: Sequence[Series]) -> dict[str, Array]:
    """Scales of `effects.Shape` that depend on the recordings alone (arrays over samples or recordings)."""
    if not model.is_time_model:
        omega = np.concatenate([2 * np.pi * s.inputs[model.axis] for s in series])
        return {
            "omega": omega,
            "time": 1 / omega,
            "duration": np.array([1 / omega.min()]),
            "samples": np.array([float(s.n) for s in series]),
        }
    time = [s.inputs[model.axis] for s in series]
    duration = np.array([t[-1] - t[0] for t in time])
    step = np.array([float(np.median(np.diff(t))) for t in time])
    scales: dict[str, Array] = {"duration": duration, "cycles": duration}
    moved = next((i.derived[1] for i in model.inputs if i.derived and i.derived[0] == "rate"), None)
    rate = next((i for i in model.inputs if i.derived and i.derived[0] == "rate"), None)
    fastest = 0.3 / step.min()
    if moved and rate:
        z = [s.inputs[moved] for s in series]
        v = [s.inputs[rate.name] for s in series]
        scales |= _sizes(z, v)
        stroke = scales["displacement"] * derived_scale(model, rate)  # in the speed's unit times that of time
        path = np.array([float(np.trapezoid(np.abs(x), t)) for x, t in zip(v, time, strict=True)])
        often = path > 4 * CYCLES * stroke
        scales["cycles"] = duration[often]
        fastest = min(fastest, float(np.max(scales["speed"] / stroke)) * 3)
    slowest = float(2 * np.pi / duration.max())
    scales["omega"] = np.array([slowest, max(fastest, 3 * slowest)])
    scales["time"] = np.array([1 / scales["omega"][1], duration.max()])
    return {n: x for n, x in scales.items() if x.size}


def _sizes(z: Sequence[Array], v: Sequence[Array]) -> dict[str, Array]:
    """Scales of a motion: half the stroke and the greatest speed of each record, and the range in all."""
    known = {}
    if z:
        known["displacement"] = np.array([max(float(np.ptp(x)) / 2, 1e-300) for x in z])
        known["position"] = np.array([min(x.min() for x in z), max(x.max() for x in z)])
    if v:
        known["speed"] = np.array([max(float(np.quantile(np.abs(x), 0.995)), 1e-300) for x in v])
    return known


def motion_scales(
    model: Model, port: Port, values: Sequence[dict[str, Array]], time: Sequence[Array]
) -> dict[str, Array]:
    """Scales of a motion that is not recorded but follows from what drives the model: by the base fit.

    values: every equation and state of the model, in each recording, at the times `time`. Empty where a
    motion is recorded, or the fit has none. A port that tells its speed alone moves as far as that goes.
    """
    if any(i.derived and i.derived[0] == "rate" for i in model.inputs):
        return {}
    at = {key: str(x) for key, x in port.variables}
    z, v = ([x[at[key]] for x in values if at.get(key) in x] for key in ("z", "v"))
    if any(np.ndim(x) != 1 or not np.isfinite(x).all() for x in (*z, *v)):
        return {}
    if v and "z" not in at:
        steps = [(x[1:] + x[:-1]) / 2 * np.diff(t) for x, t in zip(v, time, strict=True)]
        z = [np.cumsum(np.append(0.0, x)) for x in steps]
    return _sizes(z, v)


def port_scale(port: Port, values: Sequence[dict[str, Array]]) -> Array:
    """Modulus of the port's quantity by the base fit, over all samples."""
    sizes = np.concatenate([np.abs(np.atleast_1d(v[port.equation])).ravel() for v in values])
    good = np.isfinite(sizes) & (sizes > 0)
    return np.where(good, sizes, np.median(sizes[good]) if good.any() else 1.0)


def values_at(e: Experiment, theta: Array, k: int) -> dict[str, Array]:
    """Every equation of the model at θ in recording k, at all of its samples."""
    from modelgen.codegen import build_many

    (f,) = build_many([(e.model, e.layout.wrt)], ("all",))
    free = dict(zip(e.layout.wrt, e.local(theta, k), strict=True))
    known = {**e.constants, **e.series[k].constants, **free}
    recorded = e.series[k].inputs
    inputs = {i.name: recorded[i.name] for i in e.model.inputs if i.name in recorded}
    scalars = {p.name for p in e.model.scalar_parameters}
    return f.all(**inputs, **{n: v for n, v in known.items() if n in scalars})
