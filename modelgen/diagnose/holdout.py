"""The recordings that no choice has seen: looked at once, when the verdict stands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from modelgen.diagnose.noise import outliers
from modelgen.diagnose.refit import Fit
from modelgen.diagnose.search import Setting
from modelgen.diagnose.verdict import Rms
from modelgen.errors import InputError
from modelgen.fit import GaussNewton
from modelgen.fit.experiment import Experiment, make_layout
from modelgen.fit.problem import Problem
from modelgen.fit.series import Array, Series, make_series


@dataclass(frozen=True, eq=False)
class Held:
    """Holdout series with raw residuals before and after, and the rms figures of the verdict."""

    series: tuple[Series, ...]
    raw_before: tuple[Array, ...]
    raw_after: tuple[Array, ...]
    before: Rms
    after: Rms
    notes: tuple[str, ...] = ()


def look_at_holdout(setting: Setting, base: Fit, best: Fit, scale: float) -> Held:
    """Residuals of both models on the held-out recordings; own parameters of a recording are fitted on it, no
    others."""
    notes: tuple[str, ...] = ()
    try:
        series = tuple(make_series(setting.model, setting.case, r) for r in setting.case.holdout)
    except InputError as why:
        series, notes = (), (f"hold-out not used: {why}",)
    level = [s.whitener for s in setting.series]
    raws, rms = [], []
    for fit in (base, best):
        held = tuple(predict(setting, fit, s) for s in series)
        raws.append(held)
        mine = [fit.hypothesis.experiment.raw(fit.theta, k) for k in range(len(setting.series))]
        fit_white = [w.apply(e) if w.ar is None else e for w, e in zip(level, mine, strict=True)]
        held_white = [_over_noise(setting, s, e) for s, e in zip(series, held, strict=True)]
        rms.append(Rms(_rms(mine), _rms(held), _rms(fit_white, True) / scale, _rms(held_white, True) / scale))
    return Held(series, raws[0], raws[1], rms[0], rms[1], notes)


def _over_noise(setting: Setting, s: Series, e: Array) -> Array:
    """Residuals over the noise; where its level is not stated, that of the fit recordings counts. Outliers
    are left out."""
    w = s.whitener
    if not s.stated:
        ref = setting.series[0]
        level = float(
            np.median(
                np.abs(ref.whitener.weight[np.abs(ref.whitener.weight) > 0])
                * (ref.size[: ref.n].mean() if np.iscomplexobj(ref.whitener.weight) else 1.0)
            )
        )
        own = float(np.median(np.abs(w.weight)) * (s.size.mean() if np.iscomplexobj(w.weight) else 1.0))
        w = w.scaled(own / level)
    white = w.apply(e)
    mask = outliers(white)
    return np.where(mask[None, :], 0.0, white)


def predict(setting: Setting, fit: Fit, s: Series) -> Array:
    """Raw residual (channels, n) of a fitted hypothesis on another recording."""
    e = fit.hypothesis.experiment
    layout = make_layout(e.model, setting.case, (s,))
    other = Experiment(e.model, e.function, _same_order(e, layout), (s,), e.constants)
    known = dict(zip(e.layout.wrt, e.local(fit.theta, 0), strict=True))
    theta = np.array([known[n.split("[")[0]] for n in other.layout.names])
    own = [k for k, n in enumerate(other.layout.names) if n.split("[")[0] in layout.own]
    if own:
        theta = _fit_own(other, theta, own)
    return other.raw(theta, 0)


def _same_order(e: Experiment, layout):  # type: ignore[no-untyped-def]
    """The layout of one recording with the columns that the compiled function has."""
    from dataclasses import replace

    names = [n.split("[")[0] for n in layout.names]
    place = np.array([[names.index(w) for w in e.layout.wrt]])
    return replace(layout, wrt=e.layout.wrt, place=place)


def _fit_own(e: Experiment, theta: Array, own: list[int]) -> Array:
    """θ with the entries `own` fitted to the recording."""
    whole = e.problem(theta)

    def full(x: Array) -> Array:
        t = theta.copy()
        t[own] = x
        return t

    def linearise(x: Array) -> tuple[Array, Array]:
        r, J = e.linearised(full(x))
        return r, J[:, own]

    low, high = whole.lower[own], whole.upper[own]
    problem = Problem(
        tuple(whole.names[k] for k in own), tuple(whole.units[k] for k in own), low, high,
        np.clip(theta[own], low, high),
        residual=lambda x: linearise(x)[0], linearise=linearise, n_data=whole.n_data,
    )  # fmt: skip
    return full(np.asarray(GaussNewton(max_iter=40).run(problem).theta))


def _rms(parts: list[Array] | tuple[Array, ...], used: bool = False) -> float:
    """Root mean square over recordings: of complex channels the modulus, of real ones the value."""
    if not parts:
        return float("nan")
    if used:
        x = np.concatenate([p.ravel() for p in parts])
        x = x[x != 0]
        return float(np.sqrt(np.mean(x**2))) if x.size else float("nan")
    return float(np.sqrt(np.mean(np.concatenate([np.sum(p**2, axis=0) for p in parts]))))
