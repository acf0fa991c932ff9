"""What callers give, looked at before anything is done with it."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from modelgen.errors import InputError
from modelgen.fit.method import Method
from modelgen.fit.recipe import Recipe
from modelgen.language import Model
from modelgen.recordings import Case


def check_given(model: Any, case: Any, method: Any = None) -> None:
    """Raises InputError where one of these is of another kind."""
    if isinstance(model, Case) and isinstance(case, Model):
        raise InputError(
            "a case stands where the model is wanted, and the model where the case is: it is "
            "fit(model, case) and diagnose(case, model)"
        )
    if not isinstance(model, Model):
        raise InputError(f"model: found {kind(model)}, wanted a Model; mg.open_case reads one and its case")
    if not isinstance(case, Case):
        raise InputError(f"case: found {kind(case)}, wanted a Case; mg.read_case reads one")
    if not (method is None or isinstance(method, Method | Recipe)):
        raise InputError(f"method: found {kind(method)}, wanted one such as mg.PSO(40) >> mg.IPOPT()")


def check_seed(seed: Any) -> None:
    """Raises InputError for a seed that is no whole number from 0."""
    if isinstance(seed, bool) or not hasattr(seed, "__index__") or seed < 0:
        raise InputError(f"seed: found {seed!r}, wanted a whole number from 0")


def check_start(start: Any) -> None:
    """Raises InputError for a start that is no values by name."""
    if not (start is None or isinstance(start, Mapping)):
        raise InputError(f"start: found {kind(start)}, wanted values by name, as {{'k': 2.0}}")


def check_effects_given(effects: Any) -> None:
    """Raises InputError for effects that are no list of them."""
    if isinstance(effects, str | Path):
        raise InputError(
            f"effects: found {str(effects)!r}, wanted a list of Effects; "
            "modelgen.effects.load_effects reads them from a file"
        )
    if not (effects is None or isinstance(effects, Collection)):
        raise InputError(f"effects: found {kind(effects)}, wanted a list of Effects")


def check_held(case: Case) -> None:
    """Raises InputError where a hold-out lacks a constant that all fitted recordings have, each its own."""
    everywhere = set.intersection(*(set(r.constants) for r in case.fit)) if case.fit else set()
    for r in case.holdout:
        if lost := everywhere - set(case.constants) - set(r.constants):
            raise InputError(
                f"recording '{r.name}': '{min(lost)}' is a constant of every other, but not here"
            )


def is_finite(value: Any) -> bool:
    """Whether it is one finite real number; NaN would stand for the centre of the bounds."""
    try:
        return np.ndim(value) == 0 and math.isfinite(value)
    except (TypeError, ValueError, OverflowError):  # of another kind, ragged, beyond a float
        return False


def kind(x: Any) -> str:
    """What was found, in words: text as it is, else the type."""
    return repr(x) if isinstance(x, str) else f"something of type {type(x).__name__}"
