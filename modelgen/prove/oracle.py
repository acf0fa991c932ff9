"""What the true law, fitted to the same recordings, would leave of a held-out one.

Chance alone lifts χ²/N of a sweep of 400 points above 1.05 once in six times, an offset or a smooth error of
the instrument more often; and parameters are as uncertain as few samples leave them. Against the residual of
the true law on the same samples, its numbers fitted to the same noise, under the covariance that the noise
really has (a colour or a smooth error weighs as one number, not as one a sample), 1 is as good as can be.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from modelgen.prove.records import Array, Record
from modelgen.truths import Secret
from modelgen.truths.drawing import scene_of
from modelgen.truths.force import ForceScene
from modelgen.truths.further import entries
from modelgen.truths.solve import Scene, tangents

GROSS = 6.0
"""Samples whose own noise is so many times the median's are outliers, of which no law is at fault."""


@dataclass(frozen=True, eq=False)
class Reference:
    """What the true law leaves of the held-out recordings.

    scene    the device as it was recorded
    at       of each held-out recording its place among the scene's
    data     of each all channels (channels, n), in their units
    noise    of each what the true law leaves of them, fitted
    gross    of each where a gross error lies, (n,) bool
    """

    scene: Scene
    at: Sequence[int]
    data: Sequence[Array]
    noise: Sequence[Array]
    gross: Sequence[npt.NDArray[np.bool_]]

    def ratio(self, rests: Sequence[Array]) -> float | None:
        """χ² of residuals (channels, n) over that of the true law, under the true covariance of the noise, on
        the channels that they have. Infinite where a model has no finite value for what was recorded."""
        ours = theirs = 0.0
        parts = zip(self.at, self.data, self.noise, self.gross, rests, strict=True)
        for i, data, noise, gross, rest in parts:
            good = ~gross & np.all(np.isfinite(noise), axis=0)
            if not np.all(np.isfinite(rest[:, good])):
                return float("inf")
            rest = np.where(np.isfinite(rest), rest, -noise[: len(rest)])  # at gross errors, which are masked
            a, b = (self.scene.white(i, x, data)[: len(rest)] for x in (_whole(rest, noise), noise))
            ours += float(np.sum(np.square(a[:, good])))
            theirs += float(np.sum(np.square(b[:, good])))
        return ours / theirs if theirs else None

    def but_for_outliers(self, k: int, rest: Array, r: Record) -> Array:
        """Residuals of the k-th recording, with what the true law leaves at samples that were taken for
        outliers: no residual of the base is kept of these, so they tell nothing of a simpler method."""
        outliers = np.isfinite(r.before) & ~np.all(np.isfinite(r.white), axis=0)
        return np.where(outliers, -self.noise[k][: len(rest)], rest)  # a law's less the data, as `rest` is


def of_truth(secret: Secret, fit: Sequence[Record], held: Sequence[Record]) -> Reference | None:
    """The true law on the held-out recordings, its numbers fitted to the others.

    None where there is no true law (somebody's own case), or recordings were thinned.
    """
    if not secret.setup or not held:
        return None
    scene = scene_of(secret)
    found = dict(zip(_places(secret, "holdout"), held, strict=False))
    records = dict(zip(_places(secret, "fit"), fit, strict=False)) | found
    if len(found) != len(held) or len(records) != len(fit) + len(held):
        return None
    clean = [_rows(x) for x in scene.simulate(secret.strength)]
    if any(clean[i].shape[1] != r.channels.shape[1] for i, r in records.items()):
        return None
    noise = {i: r.channels - clean[i] for i, r in records.items()}
    gross = {i: _gross(secret, scene.white(i, noise[i], r.channels)) for i, r in records.items()}
    if isinstance(scene, ForceScene):  # thousands of samples tell its numbers as well as can be
        noise = {i: x + _through(scene, i, records[i]) for i, x in noise.items()}
    else:
        noise = _fitted(secret, scene, records, noise, gross)
    data, at = [r.channels for r in held], list(found)
    return Reference(scene, at, data, [noise[i] for i in at], [gross[i] for i in at])


def _places(secret: Secret, role: str) -> list[int]:
    """Places in the scene of the recordings of one role."""
    return [i for i, e in enumerate(entries(secret.setup)) if e["role"] == role]


def _gross(secret: Secret, white: Array) -> npt.NDArray[np.bool_]:
    """Where in a recording gross errors lie, if it has any."""
    size = np.abs(white)
    far = size > GROSS * np.median(size, axis=1, keepdims=True) / 0.6745
    return np.asarray(np.any(far, axis=0) & bool(secret.levels.get("share")))


STEP = 0.01
"""Relative step of differences."""
KNOWN = 0.5
"""Standard deviation of the logarithm of a number that is thought possible: noise may not carry it further
than first order holds."""


def _fitted(
    secret: Secret,
    scene: Scene,
    records: Mapping[int, Record],
    noise: Mapping[int, Array],
    gross: Mapping[int, npt.NDArray[np.bool_]],
) -> dict[int, Array]:
    """What the true law leaves when its numbers follow the noise of the recordings for the fit, to first
    order."""
    columns = [x for effect in secret.strength for x in tangents(scene, secret.strength, effect)]
    for name in secret.setup["free"]:
        bases = ({**secret.base, name: secret.base[name] * (1 + s)} for s in (STEP, -STEP))
        up, down = (scene_of(replace(secret, base=b)).simulate(secret.strength) for b in bases)
        columns.append([(a - b) / (2 * STEP) for a, b in zip(up, down, strict=True)])

    def white(parts: Mapping[int, Array]) -> Array:
        fit = (i for i, r in records.items() if not r.holdout)
        return np.concatenate(
            [scene.white(i, parts[i], records[i].channels)[:, ~gross[i]].ravel() for i in fit]
        )

    slopes = [{i: _rows(c[i]) for i in records} for c in columns]
    A = np.array([white(x) for x in slopes])
    change = np.linalg.solve(A @ A.T + np.eye(len(A)) / KNOWN**2, A @ white(noise))
    return {i: x - sum(c * s[i] for c, s in zip(change, slopes, strict=True)) for i, x in noise.items()}


def in_units(r: Record, white: Array) -> Array:
    """Residuals (channels, n) over the noise as the diagnosis has it, in the channels' units."""
    if np.iscomplexobj(r.data):
        return _rows((white[0] + 1j * white[1]) / complex_weight(r))
    return np.asarray(
        white / np.array([_ratio(*x) for x in zip(r.white_after, r.left, strict=True)])[: len(white)]
    )


def complex_weight(r: Record) -> npt.NDArray[Any]:
    """What a residual of an impedance was multiplied with: it turns Re and Im into each other."""
    return _ratio(r.white_after[0] + 1j * r.white_after[1], r.left[0] + 1j * r.left[1])


def _ratio(white: npt.NDArray[Any], left: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """What a channel was multiplied with, by its typical size where nothing was left to see it by."""
    typical = np.linalg.norm(white) / max(float(np.linalg.norm(left)), 1e-300)
    return np.asarray(np.where(left != 0, white / np.where(left != 0, left, 1.0), typical))


def _rows(x: npt.NDArray[Any]) -> Array:
    return np.array([x.real, x.imag]) if np.iscomplexobj(x) else np.atleast_2d(x)


def _whole(rest: Array, noise: Array) -> Array:
    """`rest` with zeros for channels that it does not have."""
    return np.vstack([rest, np.zeros((len(noise) - len(rest), noise.shape[1]))])


def _through(scene: ForceScene, i: int, r: Record) -> Array:
    """Force [N] that errors of the recorded motion, which a law is evaluated on, make through the sample's
    mean stiffness and its dashpot."""
    motion, b = scene.motions[i], scene.base
    z, v, _ = (motion.recorded(x) for x in motion.zva)
    stiffness = b["k_D"] + 0.5 * b["h_D"] * b["rho"]
    return np.asarray(stiffness * (z - r.inputs["z"]) + b["c_D"] * (v - r.inputs["v"]))[None]
