"""What keeps its shape and differs in size from sweep to sweep: no error of an instrument, alike in all."""

from __future__ import annotations

import numpy as np

from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.setting import ALARM, Outcome
from modelgen.diagnose.noise.smooth_error import smooth_error

SIZES = (0.05, 0.3, 1.0, 2.0, 4.0)
"""In one sweep, beside that in the others, that are tried."""
ROUNDS = 2


def growing(outcome: Outcome) -> Leftover | None:
    """What is counted as a smooth error of the instrument, where it is far likelier to be of another size in
    each sweep, with one shape, than of one size in all: something follows what differs between them."""
    judge, base = outcome.judge, outcome.base
    series = base.hypothesis.experiment.series
    if judge.smooth is None or outcome.best.hypothesis.added or len(series) < 2:
        return None
    _, alike, process = smooth_error(judge, base)
    best, found = alike, [1.0] * len(series)
    for _ in range(ROUNDS):
        for k in range(len(series)):
            for size in SIZES:
                tried = [*found[:k], size, *found[k + 1 :]]
                _, gain, other = smooth_error(judge, base, sizes=tried)
                if gain > best:
                    best, found, process = gain, tried, other
    gain = best - alike - (len(series) - 1) * float(np.log(effective(base.white)))
    if gain < ALARM or process is None or not process.shared:
        return None
    top = max(found)
    each = ", ".join(f"{x / top:.2g} in '{s.name}'" for s, x in zip(series, found, strict=True))
    says = (
        f"something smooth over {base.hypothesis.experiment.model.axis} that keeps its shape and differs in "
        f"size from sweep to sweep ({each}): an error of the instrument would be alike in all"
    )
    return Leftover(gain, 0.0, "", says, weights=tuple(found))
