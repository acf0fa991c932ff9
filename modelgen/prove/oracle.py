"""What the true law would leave of a held-out recording: the noise that is really in it, which we know.

Chance alone lifts χ²/N of a sweep of 400 points above 1.05 once in six times, an offset or a smooth error of
the instrument more often. Against the true law's own residual on the same samples, under the covariance that
the noise really has (a colour or a smooth error weighs as one number, not as one a sample), 1 is as good as
can be.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from modelgen.prove.records import Array, Record
from modelgen.truths import Secret
from modelgen.truths.drawing import scene_of
from modelgen.truths.force import ForceScene
from modelgen.truths.further import entries
from modelgen.truths.solve import Scene

GROSS = 6.0
"""Samples whose own noise is so many times the median's are outliers, of which no law is at fault."""


@dataclass(frozen=True, eq=False)
class Reference:
    """What the true law leaves of the held-out recordings.

    scene    the device as it was recorded
    at       of each held-out recording its place among the scene's
    data     of each all channels (channels, n), in their units
    noise    of each what the true law leaves of them
    gross    of each where a gross error lies, (n,) bool
    """

    scene: Scene
    at: Sequence[int]
    data: Sequence[Array]
    noise: Sequence[Array]
    gross: Sequence[npt.NDArray[np.bool_]]

    def ratio(self, rests: Sequence[Array]) -> float | None:
        """χ² of residuals (channels, n) over that of the true law, under the true covariance of the noise, on
        the channels that they have."""
        ours = theirs = 0.0
        parts = zip(self.at, self.data, self.noise, self.gross, rests, strict=True)
        for i, data, noise, gross, rest in parts:
            a, b = (self.scene.white(i, x, data)[: len(rest)] for x in (_whole(rest, noise), noise))
            good = ~gross & np.all(np.isfinite(a) & np.isfinite(b), axis=0)
            ours += float(np.sum(np.square(a[:, good])))
            theirs += float(np.sum(np.square(b[:, good])))
        return ours / theirs if theirs else None


def of_truth(secret: Secret, held: Sequence[Record]) -> Reference | None:
    """The true law on the held-out recordings.

    None where there is no true law (somebody's own case), or recordings were thinned.
    """
    if not secret.setup or not held:
        return None
    scene = scene_of(secret)
    clean = scene.simulate(secret.strength)
    at = [i for i, e in enumerate(entries(secret.setup)) if e["role"] == "holdout"]
    if len(at) != len(held):
        return None
    noises, gross = [], []
    for i, r in zip(at, held, strict=True):
        truth = _rows(clean[i])
        if truth.shape[1] != r.channels.shape[1]:
            return None
        noise = r.channels - truth
        if isinstance(scene, ForceScene):
            noise = noise + _through(scene, i, r)
        size = np.abs(scene.white(i, noise, r.channels))
        noises.append(noise)
        far = size > GROSS * np.median(size, axis=1, keepdims=True) / 0.6745
        gross.append(np.any(far, axis=0) & bool(secret.levels.get("share")))
    return Reference(scene, at, [r.channels for r in held], noises, gross)


def in_units(r: Record, white: Array) -> Array:
    """Residuals (channels, n) over the noise as the diagnosis has it, in the channels' units."""
    if np.iscomplexobj(r.data):  # a complex weight turns Re and Im into each other
        weight = _ratio(r.white_after[0] + 1j * r.white_after[1], r.left[0] + 1j * r.left[1])
        return _rows((white[0] + 1j * white[1]) / weight)
    return np.asarray(
        white / np.array([_ratio(*x) for x in zip(r.white_after, r.left, strict=True)])[: len(white)]
    )


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
