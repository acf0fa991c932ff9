"""The whitened residuals that a fitted base leaves, as the diagnosing process wrote them down."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from collections.abc import Sequence

    from modelgen.diagnose.verdict import Trace

Array = npt.NDArray[np.float64]

CURVES = ("data", "before", "after", "channels", "left", "white_after")
"""What is kept of a verdict's trace under its own name."""


@dataclass(frozen=True, eq=False)
class Record:
    """One recording: `white` (channels, n) residual over the noise, NaN at outliers; `inputs` name -> (n,);
    `data` (n,) as recorded, `before` and `after` as the base and the diagnosis' model have it, the first
    channel where there are several; `channels` (channels, n) all data, `left` the residual after [their
    units], `white_after` the same over the noise."""

    holdout: bool
    white: Array
    inputs: Mapping[str, Array]
    data: npt.NDArray[Any]
    before: npt.NDArray[Any]
    after: npt.NDArray[Any]
    channels: Array
    left: Array
    white_after: Array


def write_records(path: Path, traces: Sequence[Trace]) -> None:
    """Write the records of a verdict's traces."""
    found: dict[str, npt.NDArray[Any]] = {}
    for k, t in enumerate(traces):
        found[f"{k}:holdout"] = np.array(t.role == "holdout")
        found[f"{k}:white"] = np.where(t.outliers, np.nan, t.white_before)
        found |= {f"{k}:{name}": getattr(t, name) for name in CURVES}
        found |= {f"{k}:input:{name}": x for name, x in t.inputs.items()}
    np.savez(path, **found)  # type: ignore[arg-type]


def records(path: Path) -> list[Record]:
    """The inverse of `write_records`."""
    with np.load(path) as file:
        parts = dict(file)
    found = []
    for k in range(sum(name.endswith(":white") for name in parts)):
        start = f"{k}:input:"
        inputs = {n.removeprefix(start): x for n, x in parts.items() if n.startswith(start)}
        curves = (parts[f"{k}:{name}"] for name in CURVES)
        found.append(Record(bool(parts[f"{k}:holdout"]), parts[f"{k}:white"], inputs, *curves))
    return found
