"""What a report draws: recordings against models, and the quantity that the base lacks at a port."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from modelgen.diagnose.account.holdout import Held
from modelgen.diagnose.hypotheses.refit import Fit
from modelgen.diagnose.hypotheses.setting import Setting
from modelgen.diagnose.verdict import PortCurve
from modelgen.fit.series import Array, Series
from modelgen.fit.trace import Trace, make_trace

KINDS = {
    "electrical_impedance": "electrical",
    "capacitance": "electrical",
    "mechanical_impedance": "mechanical",
    "stiffness": "mechanical",
}


def traces(
    setting: Setting, base: Fit, best: Fit, marks: Sequence[Array], held: Held, scale: float
) -> tuple[Trace, ...]:
    """One trace for each recording, held-out ones last; white residuals are in units of the noise as it is
    judged."""
    found = []
    for k, s in enumerate(setting.series):
        raws = [f.hypothesis.experiment.raw(f.theta, k) for f in (base, best)]
        found.append(_trace(setting, s, raws[0], raws[1], marks[k], scale))
    for s, before, after in zip(held.series, held.raw_before, held.raw_after, strict=True):
        found.append(_trace(setting, s, before, after, np.zeros(s.n, dtype=bool), scale))
    return tuple(found)


def _trace(setting: Setting, s: Series, before: Array, after: Array, marks: Array, scale: float) -> Trace:
    return make_trace(setting.model, s, before, after, marks, replace(s.whitener, ar=None).scaled(scale))


def port_sensitivities(setting: Setting, base: Fit) -> dict[str, Array]:
    """Frequency models with complex output: port → d(output)/d(quantity at the port), complex, over all
    samples.

    Read off a constant that is added to the port's equation.
    """
    if setting.model.is_time_model or any(s.measure != "complex" for s in setting.series):
        return {}
    from modelgen.diagnose.hypotheses.hypothesis import (
        make_hypotheses,  # a probe is a hypothesis with one parameter
    )
    from modelgen.diagnose.hypotheses.probe import probe

    found: dict[str, Array] = {}
    seen: set[str] = set()
    for port in setting.model.ports:
        side = KINDS.get(port.kind)
        if side is None or side in seen or port.name in found:
            continue
        (h,) = make_hypotheses(setting.model, setting.case, setting.series, [(probe(port),)]) or (None,)
        if h is None:
            continue
        theta = h.place(base.hypothesis, base.theta, {})
        index = h.experiment.layout.wrt.index("port_probe_x")
        parts = []
        for k, s in enumerate(h.experiment.series):
            _, jac = h.experiment.prepared[k].jacobian(h.experiment.local(theta, k), s.measure)
            parts.append(jac[0, index] + 1j * jac[1, index])
        found[port.name] = np.concatenate(parts)
        seen.add(side)
    return found


def port_curve(
    setting: Setting, best: Fit, sensitivities: Mapping[str, Array], port: str
) -> PortCurve | None:
    """What would have to be added at the port of the first effect, and the law through it. Frequency models
    only."""
    name = port if port in sensitivities else next(iter(sensitivities), None)
    if name is None:
        return None
    slope = sensitivities[name]
    raw = [best.hypothesis.experiment.raw(best.theta, k) for k in range(len(setting.series))]
    left = np.concatenate([-(e[0] + 1j * e[1]) for e in raw])
    law = _law(setting, best, slope, name)
    equation = next(p.equation for p in setting.model.ports if p.name == name and p.kind in KINDS)
    x = np.concatenate([s.inputs[setting.model.axis] for s in setting.series])
    sigma = np.concatenate([1 / np.maximum(np.abs(s.whitener.weight), 1e-300) for s in setting.series])
    order = np.argsort(x, kind="stable")
    implied = (left / slope + (law if law is not None else 0.0))[order]
    axis = setting.model.inputs[0]
    return PortCurve(
        name, f"added to {equation}", setting.model[equation].unit, axis.name, axis.unit, x[order], implied,
        None if law is None else law[order], (sigma / np.abs(slope))[order],
    )  # fmt: skip


def _law(setting: Setting, best: Fit, slope: Array, port: str) -> Array | None:
    """The change of the output that the effects at `port` make at the best fit, as a quantity there (first
    order)."""
    here = [a for a in best.hypothesis.added if a.port.name == port] or best.hypothesis.added
    if not here:
        return None
    e = best.hypothesis.experiment
    theta = best.theta.copy()
    for a in here:
        for name, null in a.nulls.items():
            theta[e.layout.names.index(name)] = null
    parts = []
    for k in range(len(setting.series)):
        change = e.raw(best.theta, k) - e.raw(theta, k)
        parts.append(change[0] + 1j * change[1])
    return np.concatenate(parts) / slope
