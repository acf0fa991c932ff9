"""Long time records are averaged in blocks, so that memory and time stay bounded; the verdict says so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modelgen.fit.series import Array
from modelgen.language import Model
from modelgen.recordings import Case, Noise, Recording

MOST = 24_000
"""Samples over all recordings that a diagnosis works on."""


def thin(model: Model, case: Case) -> tuple[Case, tuple[str, ...]]:
    """The case with records of time models averaged over blocks, when they hold more than MOST samples in
    all."""
    fit = sum(r.n for r in case.fit)
    if not model.is_time_model or fit <= MOST:
        return case, ()
    block = -(-fit // MOST)
    records = tuple(_averaged(r, block) for r in case.recordings)
    note = f"{fit} samples were averaged in blocks of {block}; what happens faster than that is not judged"
    return replace(case, recordings=records, noise=_quieter(case.noise, block)), (note,)


def _quieter(noise: Noise, block: int) -> Noise:
    return replace(noise, sigma={n: s / np.sqrt(block) for n, s in noise.sigma.items()})


def _averaged(r: Recording, block: int) -> Recording:
    def mean(x: Array) -> Array:
        whole = len(x) // block * block
        return np.asarray(x[:whole].reshape(-1, block).mean(axis=1))

    if r.n < 4 * block:
        return r
    return replace(
        r,
        inputs={k: mean(x) for k, x in r.inputs.items()},
        outputs={k: mean(x) for k, x in r.outputs.items()},
        noise=_quieter(r.noise, block),
    )
