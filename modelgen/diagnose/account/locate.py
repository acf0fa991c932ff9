"""Where the model differs from the recordings: the stretch of the axis, or the part of the stroke, with most
misfit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from modelgen.diagnose.verdict import Mismatch
from modelgen.fit.series import Array, Series
from modelgen.language import Model

MASS = 0.8
"""A mismatch is the shortest stretch that holds this share of the excess misfit."""


def locate(
    model: Model, series: Sequence[Series], white: Sequence[Array], port: str, floor: float
) -> tuple[Mismatch, ...]:
    """One mismatch for each recording whose residual stands above the noise `floor` (mean square), worst
    first."""
    found = []
    for s, e in zip(series, white, strict=True):
        power = np.mean(e**2, axis=0)
        excess = np.maximum(power - floor, 0.0)
        if np.mean(power) < 1.1 * floor or excess.sum() <= 0:
            continue
        x = np.asarray(s.inputs[model.axis])
        order = np.argsort(x, kind="stable")
        lo, hi = _shortest(excess[order])
        start, end = float(x[order][lo]), float(x[order][hi])
        ratio = float(np.sqrt(np.mean(power[order][lo : hi + 1]) / floor))
        unit = model.inputs[0].unit
        says = f"residual {ratio:.1f} times the noise from {start:.4g} to {end:.4g} {unit}"
        if model.is_time_model:
            says = f"residual {ratio:.1f} times the noise; {_state(model, s, e)}"
        found.append((float(excess.sum()), Mismatch(port, model.axis, start, end, unit, says, s.name)))
    return tuple(m for _, m in sorted(found, key=lambda f: -f[0]))


def _shortest(excess: Array) -> tuple[int, int]:
    """First and last index of the shortest stretch that holds MASS of the excess."""
    total = np.concatenate([[0.0], np.cumsum(excess)])
    need = MASS * total[-1]
    ends = np.searchsorted(total, total[:-1] + need, side="left")
    valid = ends < len(total)
    starts = np.flatnonzero(valid)
    if starts.size == 0:
        return 0, len(excess) - 1
    best = starts[np.argmin(ends[starts] - starts)]
    return int(best), int(min(ends[best] - 1, len(excess) - 1))


def _state(model: Model, s: Series, e: Array) -> str:
    """In which part of the motion the residual is: by displacement, speed, time after a reversal."""
    power = np.mean(e**2, axis=0)
    moved = next((i.derived[1] for i in model.inputs if i.derived and i.derived[0] == "rate"), None)
    rate = next((i for i in model.inputs if i.derived and i.derived[0] == "rate"), None)
    if moved is None or rate is None:
        return "spread over the record"
    z, v = s.inputs[moved], s.inputs[rate.name]
    unit = next(i.unit for i in model.inputs if i.name == moved)
    tests: list[tuple[float, str]] = []
    for x, name, u in ((z, moved, unit), (np.abs(v), f"|{rate.name}|", rate.unit)):
        edges = np.quantile(x, np.linspace(0, 1, 9))
        bins = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, 7)
        count = np.bincount(bins, minlength=8)
        means = np.bincount(bins, power, minlength=8) / np.maximum(count, 1)
        k = int(np.argmax(means))
        tests.append(
            (
                float(means[k] / max(power.mean(), 1e-300)),
                f"largest at {name} from {edges[k]:.3g} to {edges[k + 1]:.3g} {u}",
            )
        )
    best = max(tests)
    return best[1] if best[0] > 1.5 else "spread over the whole stroke"
