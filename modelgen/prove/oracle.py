"""What the true law would leave of a held-out recording: the noise that is really in it, which we know.

Chance alone lifts χ²/N of a sweep of 400 points above 1.05 once in six times, an offset or a smooth error of
the instrument more often. Against the true law's own residual on the same samples, 1 is as good as can be.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from modelgen.prove.records import Array, Record
from modelgen.truths import Secret
from modelgen.truths.drawing import scene_of
from modelgen.truths.force import ForceScene
from modelgen.truths.further import entries

GROSS = 6.0
"""Samples whose own noise is so many times the median's are outliers, of which no law is at fault."""


def of_truth(secret: Secret, held: Sequence[Record]) -> list[Array] | None:
    """The whitened residual (channels, n) of the true law on each held-out recording, NaN at outliers.

    None where there is no true law (somebody's own case), or recordings were thinned.
    """
    if not secret.setup:
        return None
    scene = scene_of(secret)
    clean = scene.simulate(secret.strength)
    listed = [(i, e) for i, e in enumerate(entries(secret.setup)) if e["role"] == "holdout"]
    if len(listed) != len(held):
        return None
    found = []
    for (i, _), r in zip(listed, held, strict=True):
        truth = np.atleast_2d(clean[i])[0]
        if len(truth) != len(r.data):
            return None
        weight = _weight(r)
        noise = _rows(r.data - truth)
        if isinstance(scene, ForceScene):
            noise = noise + _through(scene, i, r)
        white = noise * weight
        gross = np.any(np.abs(white) > GROSS * np.median(np.abs(white)) / 0.6745, axis=0)
        found.append(np.where(gross, np.nan, white))
    return found


def after(held: Sequence[Record]) -> list[Array]:
    """Whitened residuals of the diagnosis' model."""
    return [_rows(r.after - r.data) * _weight(r) for r in held]


def over(truth: Sequence[Array] | None, rest: Sequence[Array]) -> float | None:
    """Mean square of `rest` over that of the true law, on the samples that are no outliers."""
    if truth is None or not rest:
        return None
    ours = theirs = 0.0
    for a, b in zip(rest, truth, strict=True):
        good = np.isfinite(b) & np.isfinite(a[: len(b)])
        ours += float(np.sum(np.square(a[: len(b)][good])))
        theirs += float(np.sum(np.square(b[good])))
    return ours / theirs if theirs else None


def _rows(x: npt.NDArray[Any]) -> Array:
    return np.array([x.real, x.imag]) if np.iscomplexobj(x) else np.asarray(x)[None]


def _weight(r: Record) -> Array:
    """What whitened the residual; of relative noise it varies along the recording."""
    raw = _rows(r.before - r.data)
    white = r.white[: len(raw)]
    size = np.sqrt(np.nansum(white**2, axis=0) / np.maximum(np.sum(raw**2, axis=0), 1e-300))
    return np.asarray(size)


def _through(scene: ForceScene, i: int, r: Record) -> Array:
    """Force [N] that errors of the recorded motion, which a law is evaluated on, make through the sample's
    mean stiffness and its dashpot."""
    motion, b = scene.motions[i], scene.base
    z, v, _ = (motion.recorded(x) for x in motion.zva)
    stiffness = b["k_D"] + 0.5 * b["h_D"] * b["rho"]
    return np.asarray(stiffness * (z - r.inputs["z"]) + b["c_D"] * (v - r.inputs["v"]))[None]
