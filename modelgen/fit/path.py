"""The likeliest path of a recorded motion, given the force beside it: errors in variables.

A function of a speed that is itself in error is met by other laws than its own: the errors are in both. Along
the path that force and motion together say, if the model is right, what is left no longer holds them (W. A.
Fuller, Measurement Error Models (1987), ch. 1.2: residual and estimated true value are independent).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modelgen.fit.banded import factor, smears, smoothing, through
from modelgen.fit.experiment import Experiment
from modelgen.fit.motion import MotionError, TurnError, motion_error, turn_error
from modelgen.fit.series import Array, Series
from modelgen.fit.together import Together
from modelgen.fit.whitener import Whitener
from modelgen.language import Model
from modelgen.language.derived import values_before
from modelgen.recordings import Case, Recording


def likeliest(
    ex: Experiment, case: Case, recording: Recording, theta: Array, k: int
) -> tuple[Series, float] | None:
    """Recording k of `ex` along its likeliest path if the model at θ is right, with the noise that errors of
    the recorded path make; and their variance over its own. None for a model without a motion.

    To first order: the data are shifted by what the path changes in the model at θ, so that the residual
    there and its covariance remain as they were.
    """
    s = ex.series[k]
    if len(s.data) > 1:
        return None
    share = np.ones(s.n) if s.whitener.share is None else s.whitener.share
    used = share > 0
    own = np.where(used, s.whitener.weight[0] / np.where(used, share, 1.0), 0.0)
    plain = Whitener(own[None], share=used.astype(float))
    ex = _with(ex, k, replace(s, whitener=plain))
    error = motion_error(ex, case, recording, theta, k)
    if error is None:
        return None
    turns, before = turn_error(ex, case, recording, theta, k), ex.raw(theta, k)
    e, tips = _errors(smears(error.smear, own), turns, -own * before[0])
    there = replace(s, inputs=_moved(ex.model, s, error, turns, e, tips))
    data = s.data + _with(ex, k, there).raw(theta, k) - before
    level = 1.0 + own**2 * error.variance
    effects = turns.effect / np.sqrt(level)[:, None]
    root = Together.of(effects) if len(turns.at) else None
    whitener = replace(plain.masked(1 / np.sqrt(level)), smear=error.smear, root=root)
    added = float(np.mean(level[used])) - 1 + float(np.sum(effects**2)) / s.n
    return replace(there, data=data, whitener=whitener), added


def _errors(rows: Array, turns: TurnError, r: Array) -> tuple[Array, Array]:
    """The likeliest errors of the displacement (n,) and of the turns (n,), 0 where there is none, in standard
    deviations; r: (n,) what they and independent noise of variance 1 make.

    Errors e of covariance 1 make R e; the likeliest e is Rᵀ (1 + R Rᵀ + T Tᵀ)⁻¹ r, with T of the turns.
    """
    from scipy.linalg import cho_solve_banded

    L = factor(np.ones(1), 1.0, np.zeros(len(r)), through(np.ones(1), rows))
    T, tips = turns.effect, np.zeros(len(r))
    solved = cho_solve_banded((L, True), np.column_stack([r, T]))
    first, others = solved[:, 0], solved[:, 1:]
    tips[turns.at] = np.linalg.solve(np.eye(T.shape[1]) + T.T @ others, T.T @ first)
    return _spread(rows, first - others @ tips[turns.at]), tips


def _moved(
    model: Model, s: Series, error: MotionError, turns: TurnError, e: Array, tips: Array
) -> dict[str, Array]:
    """Inputs of a series whose displacement and turns err by e, tips (n,), in standard deviations."""
    z, v, a = error.std * smoothing(error.window, e)
    moved = model.moved
    motion = model.derived_from(moved)
    before = np.concatenate([z[:1], z[:-1]])
    turned = before.copy()
    if "turning" in motion:
        x = s.inputs[moved]
        turned[s.inputs[motion["turning"]] != np.concatenate([x[:1], x[:-1]])] = 0.0
        turned[turns.at] += turns.std * tips[turns.at]
    change = {"rate": v, "acceleration": a, "previous": before, "turning": turned}
    moves = {moved: z} | {motion[k]: x for k, x in change.items() if k in motion}
    for n, of in values_before(model).items():
        if of in moves and n not in moves:
            moves[n] = np.concatenate([moves[of][:1], moves[of][:-1]])
    return {i.name: s.inputs[i.name] + moves.get(i.name, 0.0) for i in model.inputs}


def _spread(rows: Array, x: Array) -> Array:
    """(n,) Rᵀ x."""
    m, out = rows.shape[1] // 2, np.zeros(len(x) + rows.shape[1] - 1)
    for j in range(rows.shape[1]):
        out[j : j + len(x)] += rows[:, j] * x
    return out[m : m + len(x)]


def _with(ex: Experiment, k: int, s: Series) -> Experiment:
    return replace(ex, series=tuple(s if i == k else x for i, x in enumerate(ex.series)))
