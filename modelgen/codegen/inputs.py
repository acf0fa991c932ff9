"""Completes a model's inputs: what is derived from a recorded input (rate, previous value, …) is computed
here."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from modelgen.errors import InputError
from modelgen.language import Model
from modelgen.language.derived import derived_scale

Array = np.ndarray[Any, np.dtype[Any]]


def complete_inputs(
    model: Model, given: Mapping[str, Any], sigma: Mapping[str, float | None] | None = None
) -> tuple[dict[str, Array], tuple[int, ...]]:
    """All inputs of `model` as contiguous float arrays, in order, and their common shape.

    `given` holds at least the recorded inputs; derived ones that are missing follow from them
    (`recordings.kinematics`; `sigma` is the noise of recorded inputs, estimated when None).
    Raises InputError when an input is missing, not numeric, empty, or of another shape, or when what a memory
    runs along does not increase.
    """
    arrays: dict[str, Array] = {}
    for i in model.inputs:
        if i.name in given:
            try:
                if np.asarray(given[i.name]).dtype.kind in "USc":  # numpy reads numbers out of text
                    raise TypeError
                arrays[i.name] = np.asarray(given[i.name], dtype=float)
            except (TypeError, ValueError):
                raise InputError(f"input '{i.name}' of model '{model.id}' is not numeric") from None
        elif i.derived is None:
            raise InputError(f"model '{model.id}' needs input '{i.name}' [{i.unit}]")
    try:
        broadcast = np.broadcast_arrays(*arrays.values())
    except ValueError:
        shapes = ", ".join(f"{n} {a.shape}" for n, a in arrays.items())
        raise InputError(f"inputs of model '{model.id}' have different lengths: {shapes}") from None
    shape = broadcast[0].shape
    if broadcast[0].size == 0:
        raise InputError(f"inputs of model '{model.id}' are empty")
    arrays = {n: np.ascontiguousarray(a).ravel() for n, a in zip(arrays, broadcast, strict=True)}
    integrated = any(s.rate is not None for s in model.states)
    computed = any(i.derived and i.derived[0] != "previous" and i.name not in arrays for i in model.inputs)
    if model.states and (integrated or computed):
        _check_order(model, arrays[model.axis])
    for of in dict.fromkeys(
        i.derived[1]
        for i in model.inputs
        if i.derived and i.name not in arrays and i.derived[0] != "previous"
    ):
        arrays |= _motion(model, of, arrays, dict(sigma or {}))
    for i in model.inputs:
        if i.name not in arrays and i.derived:
            x = arrays[i.derived[1]]
            arrays[i.name] = np.concatenate([x[:1], x[:-1]])
    return {i.name: arrays[i.name] for i in model.inputs}, shape


def _check_order(model: Model, t: Array) -> None:
    later = np.diff(t) > 0
    if not later.all():
        k = int(np.argmin(later))
        raise InputError(
            f"input '{model.axis}' of model '{model.id}', which has a memory, must increase: found "
            f"{t[k + 1]:g} after {t[k]:g} at sample {k + 1}"
        )


def _motion(
    model: Model, of: str, arrays: Mapping[str, Array], sigma: Mapping[str, float | None]
) -> dict[str, Array]:
    """Input `of`, smoothed as far as its noise demands, and what is derived from its motion and not given,
    each in its own unit."""
    from modelgen.recordings.envelope import amplitude, quadrature
    from modelgen.recordings.kinematics import kinematics

    k = kinematics(arrays[model.axis], arrays[of], sigma.get(of, 0.0), of)
    found = {
        "rate": lambda: k.v, "acceleration": lambda: k.a, "turning": lambda: k.z_turn,
        "amplitude": lambda: amplitude(k.z), "quadrature": lambda: quadrature(k.z),
    }  # fmt: skip
    wanted = {
        i.name: found[i.derived[0]]() * derived_scale(model, i)
        for i in model.inputs
        if i.derived and i.derived[1] == of and i.derived[0] in found and i.name not in arrays
    }
    new = {of: k.z, **wanted}
    return {n: np.ascontiguousarray(x) for n, x in new.items()}
