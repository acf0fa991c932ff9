"""What can be drawn of physics that no catalogue holds: the kinds that have been looked at beside those that
nobody has in mind."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import once_unforeseen, unforeseen

SWEEPS = {**once_unforeseen.SWEEPS, **unforeseen.SWEEPS}
FORCE = {**once_unforeseen.FORCE, **unforeseen.FORCE}
STIFFNESS = {**once_unforeseen.STIFFNESS, **unforeseen.STIFFNESS}
KINDS = {*SWEEPS, *FORCE, *STIFFNESS}


def draw_form(rng: np.random.Generator, effect: str, size: float) -> dict[str, Any]:
    """The parameters of one of `KINDS`."""
    new = effect in {*unforeseen.SWEEPS, *unforeseen.FORCE, *unforeseen.STIFFNESS}
    return (unforeseen if new else once_unforeseen).draw_form(rng, effect, size)
