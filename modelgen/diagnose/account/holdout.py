"""The recordings that no choice has seen: looked at once, when the verdict stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import Outcome, Setting
from modelgen.diagnose.noise.noise import outliers_of
from modelgen.diagnose.verdict import Rms
from modelgen.errors import InputError
from modelgen.fit.experiment import Experiment, make_layout
from modelgen.fit.fitting import channels
from modelgen.fit.motion import errors_in_motion
from modelgen.fit.own import fitted_alone
from modelgen.fit.scatter import local_scatter
from modelgen.fit.series import Array, Series, make_series
from modelgen.fit.uncertainty import assess
from modelgen.language import Model


@dataclass(frozen=True, eq=False)
class Held:
    """Holdout series with raw residuals before and after, and the rms figures of the verdict."""

    series: tuple[Series, ...]
    raw_before: tuple[Array, ...]
    raw_after: tuple[Array, ...]
    before: Rms
    after: Rms
    notes: tuple[str, ...] = ()


def look_at_holdout(setting: Setting, outcome: Outcome, best: Fit, scale: float) -> Held:
    """Residuals of the base and of `best` on the held-out recordings; on each only its own parameters are
    fitted.

    `scale` is the level of the noise in units of what is stated (or was estimated on the fit recordings).
    """
    notes: tuple[str, ...] = ()
    records = setting.case.holdout
    try:
        series = tuple(make_series(setting.model, setting.case, r) for r in records)
    except InputError as why:
        series, notes = (), (f"hold-out not used: {why}",)
    moved = []
    for s, r in zip(series, records, strict=False):
        k = _alike(setting, outcome.base, s)
        told, usual = (setting.case.noise_of(x) for x in (r, setting.case.fit[k]))
        s = _levelled_like(setting.series[k], s, setting.model.axis, told != usual)
        if setting.model.is_time_model:
            e, theta = predict(outcome.base, s, setting)  # as in the recordings that were fitted
            s = errors_in_motion(replace(e, series=(s,)), setting.case, r, theta, 0)
        moved.append(s)
    raws, rms = [], []
    for fit in (outcome.base, best):
        predicted = [predict(fit, s, setting) for s in moved]
        held = [e.raw(theta, 0) for e, theta in predicted]
        mine = [fit.hypothesis.experiment.raw(fit.theta, k) for k in range(len(setting.series))]
        white = [s.whitener.apply(e) for s, e in zip(setting.series, mine, strict=True)]
        held_white = [_without_outliers(e, theta) for e, theta in predicted]
        raws.append(tuple(held))
        shown = (
            _rms(setting.model, setting.series, mine, white), _rms(setting.model, moved, held, held_white),
        )  # fmt: skip
        over = _over_noise(white) / scale, _over_noise(held_white) / scale
        rms.append(Rms(*shown, *over, foreseen(outcome.judge, fit, predicted, scale)))
    return Held(tuple(moved), raws[0], raws[1], rms[0], rms[1], notes)


SEEN = 1.15
"""Residuals over the noise that held-out recordings must show before a claim is asked to explain them."""
CARRIED = 0.5
"""Share that a claim must take away of what held-out recordings miss, where it takes away all that the fitted
ones do. Of nine claims that took away less, in 1200 records whose physics was known, seven were wrong."""


CHANGED = 4.0
"""χ² by which a claim must change what is predicted of held-out recordings to be asked to make it better: two
standard deviations."""


def carries_over(held: Held) -> bool:
    """Whether what takes misfit beyond the noise from the fitted recordings takes it from the held-out ones;
    and whether these get better at all, if it changes what is predicted of them. Of 23 claims that made them
    no better, in 1440 records whose physics was known, 15 were wrong."""
    before, after = held.before.holdout_over_noise, held.after.holdout_over_noise
    if not_better(held):
        return False
    if not min(before, after) > SEEN:
        return True
    return taken(before, after) >= CARRIED * taken(held.before.fit_over_noise, held.after.fit_over_noise)


def not_better(held: Held) -> bool:
    """Whether a claim changes what is predicted of held-out recordings, and not for the better."""
    if not held.after.holdout_over_noise >= held.before.holdout_over_noise:
        return False
    pairs = zip(held.series, held.raw_before, held.raw_after, strict=True)
    return sum(float(np.sum(s.whitener.apply(b - a) ** 2)) for s, b, a in pairs) > CHANGED


def taken(before: float, after: float) -> float:
    """The share of a mean square beyond the noise, of rms `before` over it, that `after` no longer has."""
    return 1 - max(0.0, after**2 - 1) / (before**2 - 1) if before > 1 else 1.0


def foreseen(judge: Judge, fit: Fit, predicted: Sequence[tuple[Experiment, Array]], scale: float) -> float:
    """The rms over the noise by which recordings are missed if the law is right: √(1 + tr(J C Jᵀ)/N).

    J (N, p): whitened Jacobian on what was `predicted`, less what each recording's own parameters take up; C:
    the fit's covariance. NaN where the fit leaves a parameter open, or nothing is predicted.
    """
    problem = fit.hypothesis.experiment.problem(fit.theta, judge.whiteners)
    spread = max(1.0, judge.temper * fit.chi2 / max(1, effective(fit.white) - fit.parameters))
    covariance = assess(problem, fit.theta).covariance * spread
    places: dict[str, int] = {}
    for k, n in enumerate(fit.hypothesis.names):
        places.setdefault(n.split("[")[0], k)
    total, count = 0.0, 0
    for e, theta in predicted:
        J = e.linearised(theta)[1]
        own = np.array([n.split("[")[0] in e.layout.own for n in e.layout.names], dtype=bool)
        q = np.linalg.qr(J[:, own])[0]
        rest = J[:, ~own] - q @ (q.T @ J[:, ~own])
        at = [places[n.split("[")[0]] for n, mine in zip(e.layout.names, own, strict=True) if not mine]
        total += float(np.sum((rest @ covariance[np.ix_(at, at)]) * rest))
        count += len(J)
    return float(np.sqrt(1 + total / (count * scale**2))) if count else float("nan")


def _alike(setting: Setting, base: Fit, s: Series) -> int:
    """Which of the fit recordings of the same measure has the level of noise by which the base's residual
    scatters in a held-out one between neighbours, or the nearest to it."""
    alike = [k for k, x in enumerate(setting.series) if x.measure == s.measure] or [0]
    if len(alike) == 1:
        return alike[0]
    e, theta = predict(base, s, setting)
    own = float(np.median([local_scatter(x) for x in s.whitener.apply(e.raw(theta, 0))]))
    levels = [_weight(s) / _weight(setting.series[k]) for k in alike]
    return alike[int(np.argmin(np.abs(np.log(np.maximum(levels, 1e-300) / max(own, 1e-300)))))]


def _levelled_like(fit: Series, s: Series, axis: str, differs: bool) -> Series:
    """A held-out recording with the noise of the fit recordings, where that is not (all) stated, or what is
    stated `differs`."""
    if s.stated and differs:
        return replace(s, turning=fit.turning).spread_by(s.spread) if s.measure == "complex" else s
    if s.measure == fit.measure == "complex":
        s = replace(s, turning=fit.turning).spread_by(fit.spread)
        f, uneven = _over_spread(fit, axis)
        over = np.interp(np.log(s.inputs[axis]), np.log(f), uneven)
        return replace(s, whitener=s.whitener.scaled(over))
    if s.stated or s.measure != fit.measure:
        return s
    return replace(s, whitener=s.whitener.scaled(_weight(s) / _weight(fit)))


def _over_spread(s: Series, axis: str) -> tuple[Array, Array]:
    """The noise of a sweep over what its spread alone says, and at which frequencies (both (n,)): fewer
    averages at some."""
    w = s.whitener
    share = np.ones(s.n) if w.share is None else w.share
    used = share > 0
    alone = replace(s, whitener=replace(w, root=None)).spread_by(s.spread).whitener.weight
    over = np.abs(alone[used]) * share[used] / np.abs(w.weight[used])
    order = np.argsort(s.inputs[axis][used])
    return s.inputs[axis][used][order], over[order]


def _weight(s: Series) -> float:
    """The typical weight, were no sample less sure than others; of complex data that of the relative
    residual."""
    w = np.abs(s.whitener.weight)
    w = w if s.whitener.share is None else w / np.where(s.whitener.share > 0, s.whitener.share, np.inf)
    used = w * (s.size if np.iscomplexobj(s.whitener.weight) else 1.0)
    return float(np.median(used[used > 0]))


def _without_outliers(e: Experiment, theta: Array) -> Array:
    return np.where(outliers_of(e, theta, 0)[None, :], 0.0, e.whitened(theta)[0])


def predict(fit: Fit, s: Series, setting: Setting) -> tuple[Experiment, Array]:
    """A fitted hypothesis on another recording: the experiment and θ, the recording's own parameters
    fitted."""
    e = fit.hypothesis.experiment
    case = replace(setting.case, per_recording=(*setting.case.per_recording, *e.layout.own))
    layout = make_layout(e.model, case, (s,), e.layout.wrt)
    other = Experiment(e.model, e.function, layout, (s,), e.constants)
    names = [n.split("[")[0] for n in other.layout.names]
    there = [dict(zip(e.layout.wrt, e.local(fit.theta, k), strict=True)) for k in range(len(e.series))]
    theta, *others = (np.array([known[n] for n in names]) for known in there)
    own = np.array([n in layout.own for n in names], dtype=bool)
    level = fit.chi2 / max(1, effective(fit.white))
    return other, fitted_alone(other, own, theta, [x[own] for x in others], level)


def _rms(model: Model, series: Sequence[Series], raw: Sequence[Array], white: Sequence[Array]) -> float:
    """Root mean square of raw residuals in the first output's unit (amperes don't add to millimetres), of the
    samples that weigh something, as `white` residuals show."""
    parts = []
    for s, e, w in zip(series, raw, white, strict=True):
        first, used = next(iter(channels(model, s, e).values())), np.any(w != 0, axis=0)
        parts.append(first[np.tile(used, first.size // used.size)])
    x = np.concatenate(parts) if parts else np.zeros(0)
    return float(np.sqrt(np.mean(x**2))) if x.size else float("nan")


def _over_noise(parts: Sequence[Array]) -> float:
    """Root mean square of whitened residuals that weigh something."""
    x = np.concatenate([p.ravel() for p in parts]) if parts else np.zeros(0)
    x = x[x != 0]
    return float(np.sqrt(np.mean(x**2))) if x.size else float("nan")
