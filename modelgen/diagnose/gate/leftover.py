"""What a fit leaves, in words and numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Leftover:
    """The best description of what remains: ΔBIC gained (positive is better), χ² explained, port and
    sentence.

    terms: (frequency, Q) of resonant terms; in time the name of a group of terms, which of them, and on which
    side. line: the frequency of one that does not follow the motion, 0 where it is none. weights: of an error
    of how sweeps are taken, what it is weighed by.
    """

    gain: float
    chi2: float
    port: str
    says: str
    terms: tuple[Any, ...] = ()
    line: float = 0.0
    weights: tuple[float, ...] = ()


NOTHING = Leftover(0.0, 0.0, "", "")
