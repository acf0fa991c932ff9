"""Long time records are averaged in blocks, so that memory and time stay bounded; the verdict says so."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from modelgen.codegen.lower import primary_outputs
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import ALARM
from modelgen.diagnose.noise.between import MATTERS, less, outputs_of
from modelgen.diagnose.noise.replica import on
from modelgen.fit.series import Array, make_series
from modelgen.language import Model
from modelgen.recordings import Case, Noise, Recording

MOST = 24_000
"""Samples over all recordings that a diagnosis works on."""
FINER = 16
"""Times as many on which it is seen what averaging does to the model."""


@dataclass(frozen=True)
class Thinned:
    """The case to work on, and, where its records are averaged over blocks, what they are the averages of:
    the same with up to FINER times, `block` times as many samples, averages of the `first` few."""

    case: Case
    finer: Case | None = None
    first: int = 1
    block: int = 1
    notes: tuple[str, ...] = ()


def thin(model: Model, case: Case) -> Thinned:
    """The case with records of time models averaged over blocks, when they hold more than MOST samples in
    all."""
    fit = sum(r.n for r in case.fit)
    if not model.is_time_model or fit <= MOST:
        return Thinned(case)
    first = -(-fit // (FINER * MOST))
    finer = _blocks(case, first)
    block = -(-sum(r.n for r in finer.fit) // MOST)
    note = (
        f"{fit} samples were averaged in blocks of {first * block}; what happens faster than that is not "
        "judged, and parameters are those of averages: a fit of the extended model to all tells them best"
    )
    return Thinned(_blocks(finer, block), finer, first, block, (note,))


AGREES, LARGER = 1.1, 1.2
"""Times the stated noise that single samples leave at the most where it is right, and averages at least where
it is not independent."""


def told_rightly(thinned: Thinned, fit: Fit) -> Thinned:
    """Without what is stated of the outputs' noise where `fit` leaves as much of single samples, and more of
    averages than of independent noise: what neighbours share does not average out."""
    finer, e = thinned.finer, fit.hypothesis.experiment
    if finer is None:
        return thinned
    names, shared = primary_outputs(e.model), set()
    for fine, r in zip(finer.fit, thinned.case.fit, strict=True):
        told = finer.noise_of(fine).sigma
        rests = zip(names, outputs_of(finer, e, fit.theta, fine), strict=True)
        for n, rest in ((n, fine.outputs[n] - y) for n, y in rests if n in told and n in fine.outputs):
            among = np.mean(np.diff(rest) ** 2) / 2 * (thinned.first - 1)  # in what is averaged already
            single = np.sqrt((np.mean(rest**2) + among) / thinned.first) / told[n]
            block = 1 if fine.n == r.n else thinned.block
            averaged = np.sqrt(np.mean(_mean(rest, block) ** 2) * block) / told[n]
            shared |= {n} if single < AGREES and averaged > LARGER else set()
    if not shared:
        return thinned
    case = thinned.case
    records = tuple(replace(r, noise=_untold(r.noise, shared)) for r in case.recordings)
    return replace(thinned, case=replace(case, recordings=records, noise=_untold(case.noise, shared)))


def _untold(noise: Noise, names: set[str]) -> Noise:
    return replace(noise, sigma={n: s for n, s in noise.sigma.items() if n not in names})


def unblurred(thinned: Thinned, fit: Fit, judge: Judge) -> Case | None:
    """The case without what averaging over blocks makes of the model of `fit`, whose mean output is not that
    of the mean motion where it bends within a block; None where it does not fit far better so."""
    if thinned.finer is None:
        return None
    e, case = fit.hypothesis.experiment, thinned.case
    sharp = []
    for fine, r in zip(thinned.finer.recordings, case.recordings, strict=True):
        exact = outputs_of(thinned.finer, e, fit.theta, fine)
        exact = exact if fine.n == r.n else _mean(exact, thinned.block)
        sharp.append(less(e.model, r, exact - outputs_of(case, e, fit.theta, r)))
    found = replace(case, recordings=tuple(sharp))
    series = tuple(
        replace(s, data=make_series(e.model, found, r).data) for s, r in zip(e.series, found.fit, strict=True)
    )
    moved = [(a.data - b.data) * a.whitener.weight for a, b in zip(series, e.series, strict=True)]
    if all(np.sqrt(np.mean(x**2)) < MATTERS for x in moved):
        return None
    return found if judge.fit(on(fit.hypothesis, series), [fit.theta]).bic < fit.bic - ALARM else None


def _blocks(case: Case, block: int) -> Case:
    told = tuple(replace(r, noise=case.noise_of(r)) for r in case.recordings)
    return replace(case, recordings=tuple(_averaged(r, block) for r in told))


def _quieter(noise: Noise, block: int) -> Noise:
    sigma, relative = ({n: s / np.sqrt(block) for n, s in x.items()} for x in (noise.sigma, noise.relative))
    return replace(noise, sigma=sigma, relative=relative)


def _averaged(r: Recording, block: int) -> Recording:
    if r.n < 4 * block:
        return r
    return replace(
        r,
        inputs={k: _mean(x, block) for k, x in r.inputs.items()},
        outputs={k: _mean(x, block) for k, x in r.outputs.items()},
        noise=_quieter(r.noise, block),
    )


def _mean(x: Array, block: int) -> Array:
    """Means over blocks along the last axis; what is left over at the end is left out."""
    whole = x.shape[-1] // block * block
    return np.asarray(x[..., :whole].reshape(*x.shape[:-1], -1, block).mean(axis=-1))
