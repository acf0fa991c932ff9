"""Errors of a recorded displacement: through the model they are noise of the output, as large as it reacts.

The displacement is smoothed and differentiated (recordings/kinematics.py); what this leaves of its noise is
known, and moves the modelled output by ∂F/∂z δz, ∂F/∂v δv and ∂F/∂a δa (errors in variables, to first order).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modelgen.fit.banded import beside, smears
from modelgen.fit.experiment import Experiment
from modelgen.fit.series import Array, Series, input_noise
from modelgen.fit.whitener import Smear
from modelgen.language.derived import derived_scale, values_before
from modelgen.recordings import Case, Recording
from modelgen.recordings.kinematics import Kinematics
from modelgen.recordings.turns import SURE

ENDS = 4.0
"""How much worse a smoothed motion is near the ends of a record than its own estimate says."""
SLIGHT = 0.02
"""Share of the variance, in the mean, up to which a fit leaves errors of the motion aside."""


@dataclass(frozen=True, eq=False)
class MotionError:
    """What errors of the motion do to the output of a recording, sample by sample (n,), at one θ.

    by_value, by_rate, by_acceleration: standard deviations, signed by the direction in which the output
    moves, of what errors of the smoothed displacement and of its derivatives make of it. window: half-widths
    of the smoothing in samples. std: (3, n) of those errors themselves, in the units of the model's inputs.
    """

    by_value: Array
    by_rate: Array
    by_acceleration: Array
    window: Array
    std: Array

    @property
    def smear(self) -> Smear:
        return Smear(self.window, np.stack([self.by_value, self.by_rate, self.by_acceleration]))

    @property
    def variance(self) -> Array:
        """(n,) of the output, errors of the three as if independent."""
        return np.asarray(self.by_value**2 + self.by_rate**2 + self.by_acceleration**2)


def motion_error(
    ex: Experiment, case: Case, recording: Recording, theta: Array, k: int
) -> MotionError | None:
    """Errors of the displacement that recording k of `ex` rests on, through the model at θ; None without."""
    s, model = ex.series[k], ex.model
    moved = model.moved
    if not moved:
        return None
    motion = model.derived_from(moved)
    from modelgen.recordings.kinematics import kinematics

    found = kinematics(
        recording.inputs[model.axis], recording.inputs[moved], input_noise(model, case, recording)[moved]
    )
    n = np.arange(s.n)
    window = np.maximum(np.broadcast_to(found.window, s.n), 1)
    ends = np.where((n < window) | (s.n - 1 - n < window), ENDS, 1.2)
    base, z = _output(ex, theta, k, s)[0], s.inputs[moved]
    turned_from = np.concatenate([z[:1], z[:-1]])

    def moves(std: Array, *names: str) -> Array:
        if not (np.any(std > 0) and np.all(np.isfinite(std))):
            return np.zeros(s.n)
        # the path moves between its turns: what is remembered changes with the way since the last of them
        before = np.concatenate([std[:1], std[:-1]])
        on = np.ones(s.n) if "turning" not in motion else s.inputs[motion["turning"]] == turned_from
        ways = {"turning": before * on, "previous": before}
        path = {motion[m]: d for m, d in ways.items() if m in motion and moved in names}
        path |= {n: before for n, of in values_before(model).items() if of in names and of != moved}
        shifted = {name: s.inputs[name] + d for name, d in ({n: std for n in names} | path).items()}
        return _output(ex, theta, k, replace(s, inputs={**s.inputs, **shifted}))[0] - base

    value = np.broadcast_to(found.sigma, s.n) * ends
    own = {i.name: derived_scale(model, i) for i in model.inputs if i.name in motion.values()}
    rate = np.broadcast_to(found.sigma_v, s.n) * ends * own[motion["rate"]]
    bent = np.broadcast_to(found.sigma_a, s.n) * ends * own.get(motion.get("acceleration", ""), 1.0)
    by_bend = moves(bent, motion["acceleration"]) if "acceleration" in motion else np.zeros(s.n)
    std = np.stack([value, rate, bent])
    return MotionError(moves(value, moved), moves(rate, motion["rate"]), by_bend, window, std)


SEEN = 0.3
"""Length of a turn's whitened effect from which it counts."""
MOST = 300
"""Turns that count at most, those with the largest effects: the cost goes with their square."""


HIDDEN = 2.0
"""Noise of the displacement by which a path may go too far, and back, before a rest, unseen."""
REST = 3
"""Samples that make a rest."""


@dataclass(frozen=True, eq=False)
class TurnError:
    """What errors of the turns of a path do to the whitened output of a recording: a hysteresis remembers.

    effect: (n, m), of one standard deviation of each turn. at: (m,) their steps. std: (m,) of where they are.
    """

    effect: Array
    at: Array
    std: Array


def turn_error(ex: Experiment, case: Case, recording: Recording, theta: Array, k: int) -> TurnError:
    """Errors of the turns that recording k of `ex` rests on at θ, of those alone that are seen in it."""
    from modelgen.recordings.kinematics import kinematics

    s, model = ex.series[k], ex.model
    turning = next((i for i in model.inputs if i.derived and i.derived[0] == "turning"), None)
    seen: list[tuple[Array, int, float]] = []
    if turning is not None and turning.derived is not None:
        moved = turning.derived[1]
        sigma = input_noise(model, case, recording)[moved]
        found = kinematics(recording.inputs[model.axis], recording.inputs[moved], sigma)
        base, weight = _output(ex, theta, k, s)[0], s.whitener.weight[0]
        stops = _stops(found)
        sizes = found.sigma_turn.copy()
        sizes[stops] = HIDDEN * found.sigma_z
        unsure = np.union1d(found.reversals[found.sigma_turn[found.reversals] > 0], stops)
        for n in unsure[:: 1 + len(unsure) // (4 * MOST)].tolist():
            turns, std = s.inputs[turning.name].copy(), float(sizes[n])
            turns[n] += std
            there = replace(s, inputs={**s.inputs, turning.name: turns})
            effect = weight * (_output(ex, theta, k, there)[0] - base)
            if np.all(np.isfinite(effect)) and effect @ effect > SEEN**2:
                seen.append((effect, n, std))
    seen = sorted(seen, key=lambda x: -float(x[0] @ x[0]))[:MOST]
    effects, at, std_of = zip(*seen, strict=True) if seen else ((), (), ())
    columns = np.stack(effects, axis=1) if seen else np.zeros((s.n, 0))
    return TurnError(columns, np.array(at, dtype=int), np.array(std_of))


def _stops(found: Kinematics) -> NDArray[np.intp]:
    """Steps at which a motion has come to rest, between ways that are sure, without a turn that is seen."""
    stops: list[int] = []
    if found.sigma_z == 0:
        return np.array(stops, dtype=np.intp)
    moves = np.flatnonzero(np.abs(found.v) > SURE * found.sigma_v)
    ends = np.append(moves[1:], len(found.v))[: len(moves)]
    long = ends - moves > REST
    for begin, end in zip(moves[long].tolist(), ends[long].tolist(), strict=True):
        rest = found.z[begin + 1 : end]
        if not np.any((found.reversals > begin) & (found.reversals <= end)):
            arrived = begin + 1 + int(np.argmax(np.abs(rest - np.median(rest)) < found.sigma_z))
            stops.append(min(arrived + 1, end - 1))
    return np.array(stops, dtype=np.intp)


def errors_in_motion(ex: Experiment, case: Case, recording: Recording, theta: Array, k: int) -> Series:
    """Recording k of `ex` with the noise that errors of its motion make in the output, so that they count as
    noise and not as physics: `share` and `smear` of its whitener."""
    return allowing(ex.series[k], motion_error(ex, case, recording, theta, k))


def allowing(s: Series, error: MotionError | None) -> Series:
    """A recording whose noise holds errors of its motion."""
    if error is None:
        return s
    level = np.sqrt(1.0 + np.abs(s.whitener.weight[0]) ** 2 * error.variance)
    return replace(s, whitener=replace(s.whitener.masked(1.0 / level), smear=error.smear))


def with_motion(ex: Experiment, case: Case, recordings: Sequence[Recording], theta: Array) -> Experiment:
    """`ex` with errors of the motion, as at θ, in the noise of its recordings; `ex` where they are slight."""
    if not ex.model.moved:
        return ex
    found = []
    for k, (s, r) in enumerate(zip(ex.series, recordings, strict=True)):
        error = motion_error(ex, case, r, theta, k)
        assert error is not None
        weight = np.abs(s.whitener.weight[0])
        rows = smears(error.smear, weight)
        slight = float(np.mean(np.sum(rows**2, axis=1))) < SLIGHT
        found.append(s if slight else replace(s, whitener=beside(s.whitener, rows)))
    same = all(a is b for a, b in zip(found, ex.series, strict=True))
    return ex if same else replace(ex, series=tuple(found))


def _output(ex: Experiment, theta: Array, k: int, s: Series) -> Array:
    """Model minus data of `s` in the place of recording k."""
    layout = replace(ex.layout, place=ex.layout.place[k : k + 1], held=ex.layout.held[k : k + 1])
    return Experiment(ex.model, ex.function, layout, (s,), ex.constants).raw(theta, 0)
