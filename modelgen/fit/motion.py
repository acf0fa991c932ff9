"""Errors of a recorded displacement: through the model they are noise of the output, as large as it reacts.

The displacement is smoothed and differentiated (recordings/kinematics.py); what this leaves of its noise is
known, and moves the modelled output by ∂F/∂z δz, ∂F/∂v δv and ∂F/∂a δa (errors in variables, to first order).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modelgen.fit.colour import beside
from modelgen.fit.experiment import Experiment
from modelgen.fit.series import Array, Series, input_noise
from modelgen.recordings import Case, Recording

ENDS = 4.0
"""How much worse a smoothed motion is near the ends of a record than its own estimate says."""
WIDEST = 200
"""Half-width of smoothing, in samples, up to which its noise is told apart: the cost goes with its square."""
SLIGHT = 0.02
"""Share of the variance, in the mean, up to which a fit leaves errors of the motion aside."""


@dataclass(frozen=True, eq=False)
class MotionError:
    """What errors of the motion do to the output of a recording, sample by sample (n,), at one θ.

    by_value, by_rate, by_acceleration: standard deviations, signed by the direction in which the output
    moves, of what errors of the smoothed displacement and of its derivatives make of it. window: half-widths
    of the smoothing in samples.
    """

    by_value: Array
    by_rate: Array
    by_acceleration: Array
    window: Array

    @property
    def variance(self) -> Array:
        """(n,) of the output, errors of the three as if independent."""
        return np.asarray(self.by_value**2 + self.by_rate**2 + self.by_acceleration**2)


def motion_error(
    ex: Experiment, case: Case, recording: Recording, theta: Array, k: int
) -> MotionError | None:
    """Errors of the displacement that recording k of `ex` rests on, through the model at θ; None without."""
    s, model = ex.series[k], ex.model
    motion = {i.derived[0]: i.name for i in model.inputs if i.derived}
    moved = next((i.derived[1] for i in model.inputs if i.derived and i.derived[0] == "rate"), None)
    if moved is None:
        return None
    from modelgen.recordings.kinematics import kinematics

    found = kinematics(
        recording.inputs[model.axis], recording.inputs[moved], input_noise(model, case, recording)[moved]
    )
    n = np.arange(s.n)
    window = np.maximum(np.broadcast_to(found.window, s.n), 1)
    ends = np.where((n < window) | (s.n - 1 - n < window), ENDS, 1.2)
    base = _output(ex, theta, k, s)[0]

    def moves(std: Array, *names: str) -> Array:
        if not (np.any(std > 0) and np.all(np.isfinite(std))):
            return np.zeros(s.n)
        # the whole path moves, so that no step of it changes
        before = np.concatenate([std[:1], std[:-1]])
        path = {motion[m]: before for m in ("turning", "previous") if m in motion and moved in names}
        shifted = {name: s.inputs[name] + d for name, d in ({n: std for n in names} | path).items()}
        return _output(ex, theta, k, replace(s, inputs={**s.inputs, **shifted}))[0] - base

    value = np.broadcast_to(found.sigma_z * _left(window), s.n) * ends
    rate = np.broadcast_to(found.sigma_v, s.n) * ends
    bent = np.broadcast_to(found.sigma_a, s.n) * ends
    by_bend = moves(bent, motion["acceleration"]) if "acceleration" in motion else np.zeros(s.n)
    return MotionError(moves(value, moved), moves(rate, motion["rate"]), by_bend, window)


def errors_in_motion(ex: Experiment, case: Case, recording: Recording, theta: Array, k: int) -> Series:
    """Recording k of `ex` with the noise that errors of its motion make in the output, so that they count as
    noise and not as physics: `share` and `smear` of its whitener."""
    s, found = ex.series[k], motion_error(ex, case, recording, theta, k)
    if found is None:
        return s
    level = np.sqrt(1.0 + np.mean(np.abs(s.whitener.weight), axis=0) ** 2 * found.variance)
    return replace(s, whitener=replace(s.whitener.masked(1.0 / level), smear=found.window))


def with_motion(ex: Experiment, case: Case, recordings: Sequence[Recording], theta: Array) -> Experiment:
    """`ex` with errors of the motion, as at θ, in the noise of its recordings; `ex` where they are slight."""
    if not any(i.derived and i.derived[0] == "rate" for i in ex.model.inputs):
        return ex
    found = []
    for k, (s, r) in enumerate(zip(ex.series, recordings, strict=True)):
        error = motion_error(ex, case, r, theta, k)
        assert error is not None
        weight = np.mean(np.abs(s.whitener.weight), axis=0)
        rows = smoothed(error, weight)
        slight = float(np.mean(np.sum(rows**2, axis=1))) < SLIGHT
        found.append(s if slight else replace(s, whitener=beside(s.whitener, rows)))
    same = all(a is b for a, b in zip(found, ex.series, strict=True))
    return ex if same else replace(ex, series=tuple(found))


def smoothed(error: MotionError, weight: Array) -> Array:
    """(n, 2 m + 1) rows of R, centred on its diagonal: R Rᵀ is the covariance of what white noise of the
    displacement leaves in the output, in units of its own noise 1/`weight`.

    A sample's smoothed value and derivatives are sums over its window: local quintics (Savitzky and Golay,
    Anal. Chem. 36 (1964) 1627), in the narrowest window the value itself and the derivatives of the
    polynomial through nine.
    """
    from scipy.signal import savgol_coeffs

    half = np.clip(error.window, 4, WIDEST).astype(int)
    most = int(half.max())
    rows = np.zeros((len(half), 2 * most + 1))
    for deriv, by in enumerate((error.by_value, error.by_rate, error.by_acceleration)):
        for h in np.unique(half) if np.any(by) else ():
            at, span = half == h, slice(most - h, most + h + 1)
            c = savgol_coeffs(2 * int(h) + 1, 8 if h == 4 else 5, deriv=deriv, use="dot")
            rows[at, span] += np.outer(by[at], c / np.linalg.norm(c))
    return np.asarray(rows * weight[:, None])


def _output(ex: Experiment, theta: Array, k: int, s: Series) -> Array:
    """Model minus data of `s` in the place of recording k."""
    layout = replace(ex.layout, place=ex.layout.place[k : k + 1], held=ex.layout.held[k : k + 1])
    return Experiment(ex.model, ex.function, layout, (s,), ex.constants).raw(theta, 0)


def _left(half: Array) -> Array:
    """(n,) share of the noise that a local quintic over `half` samples to either side leaves in the value."""
    from scipy.signal import savgol_coeffs

    left = {
        h: 1.0 if h <= 4 else float(savgol_coeffs(2 * h + 1, 5)[h]) ** 0.5 for h in np.unique(half).tolist()
    }
    return np.array([left[h] for h in half.tolist()])
