"""Contestants take turns, so that what slows the machine slows all of them; medians are compared."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

Run = Callable[[], Any]
OURS = "modelgen"
PATIENCE = 0.4  # seconds of each contestant
TURN = 5e-3


@dataclass(frozen=True)
class Entry:
    """One contestant at one piece of work: median and least seconds; answer: largest difference from ours."""

    work: str
    who: str
    seconds: float | None
    least: float | None = None
    per: float = 1.0  # what `seconds` is divided by to be shown: points, fits
    difference: float | None = None
    note: str = ""


def race(
    work: str, contestants: Mapping[str, Callable[[], Run]], per: float = 1.0, patience: float = PATIENCE,
    check: bool = True,
) -> list[Entry]:  # fmt: skip
    """Times each contestant. Each factory makes a call that returns its answer; one that cannot be made is
    named with its reason."""
    runs: dict[str, Run] = {}
    failed: list[Entry] = []
    for who, make in contestants.items():
        try:
            runs[who] = make()
            runs[who]()
        except ImportError as why:
            failed.append(Entry(work, who, None, note=f"not installed: {why.name}"))
        except Exception as why:  # a contestant that fails is a result
            failed.append(Entry(work, who, None, note=f"fails: {str(why).splitlines()[0][:80]}"))
    wanted = flat(runs[OURS]()) if check else None
    seen: dict[str, list[float]] = {who: [] for who in runs}
    while waiting := [w for w, t in seen.items() if len(t) < 5 or sum(t) < patience]:
        for who in waiting:
            seen[who] += turn(runs[who])
    entries = [
        Entry(work, who, statistics.median(t), min(t), per,
              None if wanted is None or who == OURS else difference(flat(runs[who]()), wanted))
        for who, t in seen.items()
    ]  # fmt: skip
    return entries + failed


def turn(run: Run) -> list[float]:
    """Seconds of each call of one turn; the first, with the caches full of others' numbers, is left out if
    there are more."""
    found, left = [], TURN
    while left > 0:
        start = time.perf_counter()
        run()
        found.append(time.perf_counter() - start)
        left -= found[-1]
    return found[1:] or found


def flat(answer: Any) -> Any:
    """An answer as real numbers in a row; complex ones as pairs."""
    found = np.asarray(answer)
    if np.iscomplexobj(found):
        found = np.stack([found.real, found.imag], axis=-1)
    return found.astype(float).ravel()


def difference(found: Any, wanted: Any) -> float:
    """The largest, relative to the largest number of the answer."""
    if found.shape != wanted.shape:
        return float("nan")
    return float(np.max(np.abs(found - wanted)) / np.max(np.abs(wanted)))
