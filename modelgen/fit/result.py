"""The result of a fit as a value, and as the JSON of the contract."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from modelgen.errors import InputError, did_you_mean
from modelgen.files import write_atomically
from modelgen.fit.problem import Matrix, Problem
from modelgen.fit.trace import Trace
from modelgen.fit.uncertainty import Uncertainty

SCHEMA = "modelgen.fit/1"


@dataclass(frozen=True)
class Estimate:
    """One parameter: value and standard deviation (NaN when not determined) in `unit`."""

    name: str
    value: float
    std: float
    unit: str
    at_bound: bool = False
    determined: bool = True


@dataclass(frozen=True)
class OutputFit:
    """How one output of a recording is fitted: rms of the residual in `unit`, and relative to the noise."""

    output: str
    rms: float
    unit: str
    rms_over_noise: float


@dataclass(frozen=True)
class RecordingFit:
    """How one recording is fitted: rms of the residual in the output's unit, and relative to the noise.

    others: (rms, unit) of outputs in further units. outputs: each by itself.
    """

    file: str
    role: str
    points: int
    rms: float
    unit: str
    rms_over_noise: float
    others: tuple[tuple[float, str], ...] = ()
    outputs: tuple[OutputFit, ...] = ()


@dataclass(frozen=True, repr=False)
class FitResult:
    """What a fit found. rms: by output unit, each {"fit": …, "holdout": …}; the first unit is the main one.

    rms_over_noise: {"fit": …, "holdout": …}, 1 where only noise is left. correlation (p, p), rank and
    `undetermined` (sentences) as in `Uncertainty`. A figure that does not exist is NaN here and null in the
    JSON. warnings: those of `notes` that say more than how large the residual is and how many starts arrived.
    refitted: what held-out recordings have of their own, by them alone, std as if the rest were known.
    traces: what `plot` draws.
    """

    model: str
    parameters: tuple[Estimate, ...]
    correlation: Matrix
    rank: int
    undetermined: tuple[str, ...]
    rms: Mapping[str, Mapping[str, float]]
    rms_over_noise: Mapping[str, float]
    seconds: float
    reason: str
    method: str
    recordings: tuple[RecordingFit, ...] = ()
    notes: tuple[str, ...] = field(default=())
    warnings: tuple[str, ...] = field(default=())
    refitted: tuple[Estimate, ...] = ()
    traces: tuple[Trace, ...] = field(default=(), compare=False, repr=False)

    def __repr__(self) -> str:
        """What a notebook shows: the parameters, and how near the fit is."""
        rows = [f"  {e.name} = {e.value:.6g} ± {e.std:.2g} {e.unit}" for e in self.parameters]
        rms = [f"  rms {x['fit']:.3g} {unit}" for unit, x in self.rms.items() if "fit" in x]
        return "\n".join((f"FitResult({self.model!r})", *rows, *rms, *(f"  {n}" for n in self.warnings)))

    def __getitem__(self, name: str) -> Estimate:
        """The estimate of one parameter. Raises InputError, with the nearest name, for an unknown one."""
        known = (*self.parameters, *self.refitted)
        for estimate in known:
            if estimate.name == name:
                return estimate
        raise InputError(f"unknown parameter '{name}'{did_you_mean(name, [e.name for e in known])}")

    @property
    def values(self) -> dict[str, float]:
        """name → value, to hand to a model."""
        return {e.name: e.value for e in self.parameters}

    def to_dict(self) -> dict[str, Any]:
        """The `fit` result of the contract, and more: correlation, rank, refitted, recordings, notes, …"""
        main = next(iter(self.rms), "")
        whole = {
            "schema": SCHEMA,
            "model": self.model,
            "parameters": _by_name(self.parameters),
            "rms": _fit_and_holdout(self.rms.get(main, {})) | {"unit": main},
            "rms_over_noise": _fit_and_holdout(self.rms_over_noise),
            "seconds": self.seconds,
            "rms_by_unit": {unit: _fit_and_holdout(rms) for unit, rms in self.rms.items()},
            "correlation": np.asarray(self.correlation).tolist(),
            "rank": self.rank,
            "refitted": _by_name(self.refitted),
            "undetermined": self.undetermined,
            "recordings": [asdict(recording) for recording in self.recordings],
            "notes": self.notes,
            "reason": self.reason,
            "method": self.method,
        }
        plain: dict[str, Any] = jsonable(whole)
        return plain

    def to_json(self) -> str:
        """`to_dict` as text."""
        return json.dumps(self.to_dict(), indent=1, ensure_ascii=False, allow_nan=False) + "\n"

    def write_json(self, path: str | Path) -> None:
        """Write `to_json` whole or not at all. Raises InputError or ToolError as `write_atomically` does."""
        write_atomically(path, self.to_json())

    def plot(self, path: str | Path) -> None:
        """Draw each recording against the model and its residual over the noise: .svg, .png or .pdf.

        Raises InputError and ToolError as `write_atomically` does.
        """
        from modelgen.report.fits import (
            write_plot,  # the one import upwards: a result shows itself when asked
        )

        write_plot(self, path)


def estimates(problem: Problem, theta: ArrayLike, known: Uncertainty) -> tuple[Estimate, ...]:
    """Put names, values θ (p,), standard deviations and units side by side."""
    rows = zip(
        problem.names, np.asarray(theta).tolist(), known.std.tolist(), problem.units,
        known.at_bound.tolist(), known.determined.tolist(), strict=True,
    )  # fmt: skip
    return tuple(Estimate(*row) for row in rows)


def _by_name(found: Sequence[Estimate]) -> dict[str, dict[str, Any]]:
    return {e.name: {n: x for n, x in asdict(e).items() if n != "name"} for e in found}


def _fit_and_holdout(figures: Mapping[str, float]) -> dict[str, float]:
    return {role: float(figures.get(role, np.nan)) for role in ("fit", "holdout")}


def jsonable(thing: Any) -> Any:
    """The same with what JSON has not (NaN, ±inf) as null."""
    if isinstance(thing, dict):
        return {name: jsonable(value) for name, value in thing.items()}
    if isinstance(thing, list | tuple):
        return [jsonable(value) for value in thing]
    return None if isinstance(thing, float) and not np.isfinite(thing) else thing
