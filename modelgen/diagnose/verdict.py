"""What a diagnosis says, as a value: the contract's JSON, and what a report needs to show it."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from modelgen.files import write_atomically
from modelgen.fit.result import Estimate
from modelgen.fit.trace import Trace

SCHEMA = "modelgen.verdict/1"
Array = np.ndarray[Any, np.dtype[Any]]


@dataclass(frozen=True)
class Mismatch:
    """Where the model differs from the recordings: a stretch of an axis, seen at a port."""

    port: str
    axis: str
    start: float
    end: float
    unit: str
    says: str
    recording: str = ""


@dataclass(frozen=True)
class Finding:
    """One piece of physics that was left out. `share` is the part of the misfit's χ² that it explains."""

    id: str
    port: str
    says: str
    probability: float
    family: str = ""
    source: str = ""
    equivalents: tuple[str, ...] = ()
    separating_experiment: str | None = None
    parameters: tuple[Estimate, ...] = ()
    share: float = float("nan")


@dataclass(frozen=True)
class Trial:
    """One hypothesis that was fitted: its ids, evidence against the base (ΔBIC, negative is better),
    misfit.

    ports: where each of its effects stands; "" where there is but one place for it.
    """

    ids: tuple[str, ...]
    family: str
    delta_bic: float
    parameters: int
    rms_over_noise: float
    probability: float = float("nan")
    ports: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class PortCurve:
    """What would have to be added at a port so that the base fits (`implied`), and the identified law through
    it.

    x may be a frequency (implied is then complex) or a variable such as displacement or speed (real).
    """

    port: str
    quantity: str
    unit: str
    x_name: str
    x_unit: str
    x: Array
    implied: Array
    law: Array | None
    std: Array | None = None
    log_x: bool = True


@dataclass(frozen=True)
class Rms:
    """Root mean square of residuals, in the output's unit and over the noise; NaN where there is no such
    recording.

    foreseen: what the hold-out's over the noise would be if the law were right, noise and what is uncertain
    of the parameters taken together; NaN where it is not known.
    """

    fit: float
    holdout: float
    fit_over_noise: float
    holdout_over_noise: float
    foreseen: float = float("nan")


@dataclass(frozen=True, eq=False, repr=False)
class Verdict:
    """The outcome of a diagnosis. `effects` is ordered, best first; `judged`: the recordings hold values
    enough to tell whether something is missing."""

    model: str
    adequate: bool
    mismatch: tuple[Mismatch, ...]
    effects: tuple[Finding, ...]
    parameters: tuple[Estimate, ...]
    parameters_before: tuple[Estimate, ...]
    before: Rms
    after: Rms
    unit: str
    extended_model: str | None
    seconds: float
    summary: str = ""
    trials: tuple[Trial, ...] = ()
    traces: tuple[Trace, ...] = ()
    curve: PortCurve | None = None
    notes: tuple[str, ...] = ()
    noise: str = ""
    law: str = ""
    judged: bool = True

    def __repr__(self) -> str:
        """What a notebook shows: the summary, not all that a page needs."""
        return f"Verdict({self.model!r}, adequate={self.adequate}: {self.summary})"

    def to_dict(self) -> dict[str, Any]:
        """The contract's JSON object, with additions (judged, summary, trials, notes, noise)."""
        return _plain(
            {
                "schema": SCHEMA,
                "model": self.model,
                "adequate": self.adequate,
                "judged": self.judged,
                "summary": self.summary,
                "mismatch": [
                    {
                        "port": m.port, "axis": m.axis, "from": m.start, "to": m.end, "unit": m.unit,
                        "says": m.says, "recording": m.recording,
                    }
                    for m in self.mismatch
                ],
                "effects": [
                    {
                        "id": e.id, "port": e.port, "says": e.says, "probability": e.probability,
                        "family": e.family, "equivalents": list(e.equivalents),
                        "separating_experiment": e.separating_experiment,
                        "parameters": _estimates(e.parameters), "explains": e.share, "source": e.source,
                    }
                    for e in self.effects
                ],
                "parameters": _estimates(self.parameters),
                "parameters_before": _estimates(self.parameters_before),
                "fit": {"before": _rms(self.before), "after": _rms(self.after), "unit": self.unit},
                "holdout_foreseen_over_noise": self.after.foreseen,
                "extended_model": self.extended_model,
                "seconds": self.seconds,
                "hypotheses": [
                    {
                        "ids": list(t.ids), "family": t.family, "delta_bic": t.delta_bic,
                        "parameters": t.parameters, "rms_over_noise": t.rms_over_noise,
                        "probability": t.probability,
                    }
                    for t in self.trials
                ],
                "noise": self.noise,
                "notes": list(self.notes),
            }
        )  # fmt: skip

    def to_json(self) -> str:
        return json.dumps(self.to_dict(), indent=1, ensure_ascii=False, allow_nan=False) + "\n"

    def write_json(self, path: str | Path) -> None:
        """Write the JSON whole or not at all. Raises InputError or ToolError."""
        write_atomically(path, self.to_json())


def _estimates(found: tuple[Estimate, ...]) -> dict[str, Any]:
    return {e.name: {"value": e.value, "std": e.std, "unit": e.unit, "at_bound": e.at_bound} for e in found}


def _rms(r: Rms) -> dict[str, float]:
    return {
        "fit_rms": r.fit, "holdout_rms": r.holdout,
        "fit_rms_over_noise": r.fit_over_noise, "holdout_rms_over_noise": r.holdout_over_noise,
    }  # fmt: skip


def _plain(x: Any) -> Any:
    """JSON has no NaN and no infinity: null stands for both."""
    if isinstance(x, dict):
        return {str(k): _plain(v) for k, v in x.items()}
    if isinstance(x, list | tuple):
        return [_plain(v) for v in x]
    if isinstance(x, bool | np.bool_):
        return bool(x)
    if isinstance(x, float | np.floating):
        return float(x) if math.isfinite(x) else None
    if isinstance(x, np.integer):
        return int(x)
    return x
