"""A case: which recordings a model is fitted to, and what is known beforehand (contract: `case.toml`)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from modelgen.errors import did_you_mean
from modelgen.recordings.casefile import CaseFile, RecordingSpec, read_case_file
from modelgen.recordings.columns import read_channels
from modelgen.recordings.signature import Channel, Signature
from modelgen.recordings.table import fail, read_table

__all__ = ["Case", "CaseFile", "Noise", "Recording", "RecordingSpec", "load_case", "read_case_file"]


@dataclass(frozen=True)
class Noise:
    """What the user says of the noise; channels are named as the model names them.

    sigma: standard deviation in the channel's unit, of a complex one that of Re and of Im each. relative: the
    same over the modulus of the value. calibration: (relative rms, correlation length in ln f) of a smooth
    instrument error.
    """

    sigma: Mapping[str, float] = field(default_factory=dict)
    relative: Mapping[str, float] = field(default_factory=dict)
    calibration: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def but(self, other: Noise) -> Noise:
        """This, with what `other` says of a channel in its place."""
        told = {*other.sigma, *other.relative}
        sigma = {n: x for n, x in self.sigma.items() if n not in told} | dict(other.sigma)
        relative = {n: x for n, x in self.relative.items() if n not in told} | dict(other.relative)
        return Noise(sigma, relative, {**self.calibration, **other.calibration})


@dataclass(frozen=True, eq=False)
class Recording:
    """One recording in the model's units. All arrays have shape (n,), are contiguous and read-only.

    kinds: of each output, "real", "complex" (complex128), "modulus" or "phase" (deg) of a complex output.
    constants: values known for this recording alone; they go before those of the case. noise: of this
    recording, where it differs from the case's (an averaged one is quieter).
    """

    name: str
    path: Path | None
    role: str
    inputs: Mapping[str, np.ndarray]
    outputs: Mapping[str, np.ndarray]
    kinds: Mapping[str, str] = field(default_factory=dict)
    constants: Mapping[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    noise: Noise = field(default_factory=Noise)

    def __post_init__(self) -> None:
        inputs = {k: _frozen(v) for k, v in self.inputs.items()}
        outputs = {k: _frozen(v) for k, v in self.outputs.items()}
        sizes = {v.shape for v in (*inputs.values(), *outputs.values())}
        if len(sizes) > 1 or any(len(s) != 1 for s in sizes):
            raise fail(f"recording '{self.name}': arrays of shapes {sorted(sizes)}, wanted one length")
        plain = {k: "complex" if np.iscomplexobj(v) else "real" for k, v in outputs.items()}
        kinds = plain | dict(self.kinds)
        for name, value in (("inputs", inputs), ("outputs", outputs), ("kinds", kinds)):
            object.__setattr__(self, name, value)

    @property
    def n(self) -> int:
        """Number of samples."""
        return int(next(iter((*self.outputs.values(), *self.inputs.values()))).size)


@dataclass(frozen=True, eq=False)
class Case:
    """A model's name, its recordings, and what is known of its parameters, in the model's units."""

    path: Path | None
    model: str
    recordings: tuple[Recording, ...]
    per_recording: tuple[str, ...] = ()
    constants: Mapping[str, float] = field(default_factory=dict)
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    noise: Noise = field(default_factory=Noise)
    options: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        count = Counter(r.name for r in self.recordings)
        twice = next((n for n in count if count[n] > 1), None)
        if twice is not None:  # a recording's own parameters are told by its name
            where = f"{self.path or 'case'}, recordings"
            raise fail(f"{where}: {count[twice]} are called '{twice}', wanted a name of its own for each")

    @property
    def fit(self) -> tuple[Recording, ...]:
        """The recordings that a fit may see."""
        return tuple(r for r in self.recordings if r.role == "fit")

    def noise_of(self, recording: Recording) -> Noise:
        """What is said of a recording's noise: for itself, or else for all."""
        return self.noise.but(recording.noise)

    @property
    def holdout(self) -> tuple[Recording, ...]:
        """The recordings that neither a fit nor a choice between hypotheses may see."""
        return tuple(r for r in self.recordings if r.role == "holdout")

    @property
    def warnings(self) -> tuple[str, ...]:
        """What was odd about the recordings as they were read."""
        return tuple(w for r in self.recordings for w in r.warnings)

    @property
    def files(self) -> tuple[Path, ...]:
        """What it was read from: its own file, its recordings', and its model's where that is the user's."""
        source = self.model.rpartition(":")[0] if ".py:" in self.model else self.model
        model = self.path.parent / source if self.path and source.endswith(".py") else None
        return tuple(p for p in (self.path, model, *(r.path for r in self.recordings)) if p is not None)


def load_case(case_file: CaseFile, signature: Signature) -> Case:
    """Read the recordings of a case and check its names against the model's signature.

    Raises InputError, one line with file and place, for anything that is wrong in the case or its tables.
    """
    case_file = _without(case_file, signature)
    _check_names(case_file, signature)
    recordings = [
        _load(case_file, spec, name, signature)
        for spec, name in zip(case_file.recordings, _names(case_file.recordings), strict=True)
    ]
    recordings = _each_once(recordings)
    noise = _noise(f"{case_file.path}, [noise]", case_file.noise, signature)
    if noise.sigma.get(signature.axis) and recordings:
        said = f"[noise] {signature.axis} counts for nothing: samples are held to be where they say"
        recordings[0] = replace(recordings[0], warnings=(*recordings[0].warnings, said))
    return Case(
        path=case_file.path,
        model=case_file.model,
        recordings=tuple(recordings),
        per_recording=case_file.per_recording,
        constants=case_file.constants,
        bounds=case_file.bounds,
        noise=noise,
        options=case_file.options,
    )


def _frozen(values: Any) -> np.ndarray:
    kind = np.complex128 if np.iscomplexobj(values) else np.float64
    array = np.array(values, dtype=kind, order="C")
    array.setflags(write=False)
    return array


def _load(case_file: CaseFile, spec: RecordingSpec, name: str, signature: Signature) -> Recording:
    path = case_file.path.parent / spec.file
    found = read_channels(read_table(path), signature)
    noise = _noise(f"{case_file.path}, recording '{spec.file}' noise", spec.noise, signature)
    return Recording(
        name, path, spec.role, found.inputs, found.outputs, found.kinds, spec.constants, found.warnings, noise
    )


def _each_once(recordings: Sequence[Recording]) -> list[Recording]:
    """Recordings to be fitted without copies of another, which would make its noise count twice."""
    kept: list[Recording] = []
    for r in recordings:
        twin = next((k for k, other in enumerate(kept) if r.role == "fit" and _same(r, other)), None)
        if twin is None:
            kept.append(r)
        else:
            said = f"'{r.name}' holds the same samples as '{kept[twin].name}': left out"
            kept[twin] = replace(kept[twin], warnings=(*kept[twin].warnings, said))
    return kept


def _same(a: Recording, b: Recording) -> bool:
    """Whether two recordings hold the same, samples and what is known beside them."""
    if (a.role, a.n, a.noise, dict(a.constants)) != (b.role, b.n, b.noise, dict(b.constants)):
        return False
    pairs = ((a.inputs, b.inputs), (a.outputs, b.outputs))
    return all(x.keys() == y.keys() and all(np.array_equal(x[n], y[n]) for n in x) for x, y in pairs)


def _names(specs: Iterable[RecordingSpec]) -> list[str]:
    """The stem of each file; its whole path where two files in different folders share a stem."""
    paths = [Path(s.file) for s in specs]
    count = Counter(p.stem for p in paths)
    return [p.stem if count[p.stem] == 1 else p.as_posix() for p in paths]


def _without(case: CaseFile, signature: Signature) -> CaseFile:
    """The case without what drops out of the model, wherever it is named."""
    for place, table in _places(case):
        for name, only in signature.drops.items():
            if only is not None and table.get(name, only) != only:
                alone = f"{signature.model} holds for {name} = {only:g} alone"
                raise fail(f"{case.path}, {place} {name}: {alone}, found {_told(table[name])}")

    def kept(table: Mapping[str, Any]) -> dict[str, Any]:
        return {k: v for k, v in table.items() if k not in signature.drops}

    return replace(
        case,
        per_recording=tuple(kept(dict.fromkeys(case.per_recording))),
        constants=kept(case.constants),
        bounds=kept(case.bounds),
        recordings=tuple(replace(r, constants=kept(r.constants)) for r in case.recordings),
    )


def _told(value: Any) -> str:
    """A constant, a range to search, or a place in a list of free ones, as a complaint tells it."""
    return "it free" if value is None else f"{list(value)}" if isinstance(value, tuple) else f"{value:g}"


def _places(case: CaseFile) -> list[tuple[str, Mapping[str, Any]]]:
    """Where a case names parameters, and what it says of each."""
    return [
        ("per_recording", dict.fromkeys(case.per_recording)),
        ("[constants]", case.constants),
        ("[bounds]", case.bounds),
        *((f"recording '{s.file}' constants", s.constants) for s in case.recordings),
    ]


def _check_names(case: CaseFile, signature: Signature) -> None:
    """Every parameter named is one of the model's, and is either fixed or searched, not both."""
    for place, names in _places(case):
        for name in names:
            if name not in signature.parameters:
                hint = did_you_mean(name, signature.parameters)
                raise fail(f"{case.path}, {place}: {signature.model} has no parameter '{name}'{hint}")
    everywhere = set.intersection(*(set(s.constants) for s in case.recordings))
    for name in case.bounds:
        if name in case.constants or name in everywhere:
            raise fail(f"{case.path}, [bounds] {name}: has a bound and a constant, wanted one of them")
    for name in case.per_recording:
        if name in case.constants or name in everywhere:
            raise fail(f"{case.path}, per_recording '{name}': is a constant, so it is free nowhere")


def _noise(place: str, table: Mapping[str, float | tuple[float, float]], signature: Signature) -> Noise:
    """Sort a table of noise into its three kinds, named by the model's channels."""
    places: dict[str, tuple[str, Channel]] = {}
    for channel in (*signature.inputs, *signature.outputs):
        for name in channel.names:
            places[name] = ("sigma", channel)
            if channel in signature.outputs:
                places[f"{name}_relative"] = ("relative", channel)
                places[f"{name}_calibration"] = ("calibration", channel)
    found: dict[str, dict[str, Any]] = {"sigma": {}, "relative": {}, "calibration": {}}
    for key, value in table.items():
        where = f"{place} {key}"
        if key not in places:
            plain = key.removeprefix("abs_").removeprefix("phase_").strip("|")  # as a column may be called
            raise fail(f"{where}: {signature.model} has no such channel{did_you_mean(plain, places)}")
        kind, channel = places[key]
        if isinstance(value, tuple) != (kind == "calibration"):
            wanted = "[rms, length in ln f]" if kind == "calibration" else "one number"
            raise fail(f"{where} = {list(value) if isinstance(value, tuple) else value}: wanted {wanted}")
        if value == 0 and channel in signature.outputs:
            raise fail(f"{where} = 0: an output without noise can't be weighted, wanted a number above zero")
        if channel.name in found[kind]:
            raise fail(f"{where}: the noise of '{channel.name}' is given twice")
        found[kind][channel.name] = value
    return Noise(**found)
