"""Runs of samples that have something in common."""

from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[Any]]


def runs(marked: Array) -> list[tuple[int, int]]:
    """[a, b) of the parts of (n,) bool that are true throughout, in order."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], marked, [False]]).astype(int)))
    return [(int(a), int(b)) for a, b in ends.reshape(-1, 2)]
