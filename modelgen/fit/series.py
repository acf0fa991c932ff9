"""Recordings as a fit sees them: completed inputs, real channels of data, and the noise that whitens."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from modelgen.errors import InputError
from modelgen.fit.together import Together, smooth_modes
from modelgen.fit.whitener import Array, Whitener
from modelgen.language import Model
from modelgen.recordings import Case, Channel, Recording, Signature
from modelgen.recordings.case import Noise
from modelgen.recordings.convert import is_time

Spread = tuple[float, float, float]
"""Noise of impedances: absolute, relative, and absolute noise of their inverse, as an ammeter's floor."""

BELIEVED = 1.3
"""A stated noise of an input is believed when the record itself holds up to this many times as much."""


@dataclass(frozen=True, eq=False)
class Series:
    """One recording ready for any model of the same signature.

    inputs: recorded and derived ones. data: (channels, n). measure: what the channels are ("complex",
    "modulus", "phase", "real"). rows: which of the model's real outputs the channels are. reference: (n,) the
    first output without its own noise, as far as known: what a relative noise is relative to, and the frame
    of complex residuals. spread: noise of impedances: absolute, relative, and absolute of the inverse.
    turning: whether smooth errors of complex values turn with their phase, as those of a factor do.
    """

    name: str
    role: str
    inputs: Mapping[str, Array]
    data: Array
    measure: str
    rows: tuple[int, ...]
    unit: str
    whitener: Whitener
    constants: Mapping[str, float] = field(default_factory=dict)
    stated: bool = True
    reference: Array = field(default_factory=lambda: np.zeros(0))
    spread: Spread = (0.0, 0.0, 0.0)
    turning: bool = True

    @property
    def n(self) -> int:
        return int(self.data.shape[1])

    @property
    def size(self) -> Array:
        """(n,) |first output|."""
        return np.abs(self.reference)

    def referred(self, reference: Array) -> Series:
        """An impedance with the noise and the frame of another reference (n,)."""
        whitener = replace(
            self.whitener, weight=_weight_of(reference, self.spread, self.measure, self.turning)
        )
        return replace(self, reference=reference, whitener=whitener)

    def unturned(self) -> Series:
        """A complex series whose smooth errors do not turn with its phase."""
        return replace(self, turning=False).referred(self.reference)

    def spread_by(self, spread: Spread) -> Series:
        """An impedance with another absolute, relative and inverse noise."""
        weight = _weight_of(self.reference, spread, self.measure, self.turning)
        root = self.whitener.root
        if root is not None:
            root = root.weighed(np.abs(weight) / np.abs(self.whitener.weight))
        return replace(self, spread=spread, whitener=replace(self.whitener, weight=weight, root=root))


def signature_of(model: Model) -> Signature:
    """What a recording of `model` holds. Raises InputError for a model without inputs: there is none."""
    if not model.inputs:
        raise InputError(
            f"model '{model.id}' has no input, so it can be evaluated, not fitted to a recording"
        )
    from modelgen.language.quantities import is_complex

    outputs = []
    for o in model.outputs:
        s = model[o.name]
        two_parts = hasattr(s, "expr") and is_complex(s.expr)  # a state is real
        if two_parts and is_time(model.inputs[0].unit):
            raise InputError(f"model '{model.id}': its output '{o.name}' is complex, and runs over time")
        outputs.append(Channel(o.name, s.unit, two_parts, o.measured_as))
    parameters = {p.name: p.unit for p in model.scalar_parameters}
    return Signature(
        model.id,
        tuple(Channel(i.name, i.unit) for i in model.inputs if i.derived is None),
        tuple(outputs),
        parameters,
        model.axis,
        {name: only for name, only in model.drops if name not in parameters},
    )


def make_series(model: Model, case: Case, recording: Recording) -> Series:
    """Complete one recording: derived inputs, channels, and the noise that is stated (or estimated) for it.

    Raises InputError when the recording holds none of the model's fitted outputs, a motion of nothing, or an
    output that never changes and of which no noise is stated.
    """
    from modelgen.codegen.inputs import complete_inputs

    _check_motion(model, case, recording)
    inputs, _ = complete_inputs(model, recording.inputs, input_noise(model, case, recording))
    found = _measured(model, recording)
    first, kind = found[0], recording.kinds[found[0]]
    y = recording.outputs[first]
    data, rows = _channels(model, recording, found)
    if kind in ("complex", "modulus"):
        spread, stated = _spread(case.noise_of(recording), first, kind, y)
        reference = _between_neighbours(y, spread)
        weight = _weight_of(reference, spread, kind)
    else:
        weight, stated = _weight(case, recording, found)
        reference, spread = np.abs(y), (0.0, 0.0, 0.0)
    if not stated and data.shape[1] > 1 and not np.any(np.ptp(data, axis=1)):
        raise InputError(
            f"recording '{recording.name}': '{first}' is {y[0]:g} throughout and its noise is not stated: "
            f"there is nothing to compare '{model.id}' with"
        )
    root = _calibration_root(model, case, recording, first, kind, weight, reference)
    return Series(
        recording.name, recording.role, inputs, np.ascontiguousarray(data), kind, rows, model[first].unit,
        Whitener(weight, root), recording.constants, stated, reference, spread,
    )  # fmt: skip


def _measured(model: Model, recording: Recording) -> list[str]:
    """The outputs that a fit compares, of those that are recorded. Raises InputError for none."""
    from modelgen.codegen.lower import primary_outputs

    outputs = primary_outputs(model)
    found = [o for o in outputs if o in recording.outputs]
    if not found:
        have = ", ".join(recording.outputs) or "nothing"
        raise InputError(
            f"recording '{recording.name}' holds {have}, "
            f"but a fit of '{model.id}' needs {' or '.join(outputs)}"
        )
    return found


def unfitted(model: Model, case: Case) -> tuple[str, ...]:
    """A note on outputs that are recorded and that no fit compares: beside a complex one it is alone."""
    from modelgen.codegen.lower import primary_outputs

    compared = primary_outputs(model)
    spare = [o.name for o in model.outputs if o.name not in compared]
    spare = [n for n in spare if any(n in r.outputs for r in case.fit)]
    if not spare:
        return ()
    return (
        f"{' and '.join(spare)} {'is' if len(spare) == 1 else 'are'} recorded, and not compared: "
        f"of a model with complex outputs the first is fitted alone, {compared[0]}",
    )


def _channels(model: Model, recording: Recording, found: Sequence[str]) -> tuple[Array, tuple[int, ...]]:
    """Data (channels, n) of the outputs `found`, real, and which of the model's real outputs they are.

    A complex output alone is both; of several real ones each is a channel.
    """
    from modelgen.codegen.lower import primary_outputs

    y, kind = recording.outputs[found[0]], recording.kinds[found[0]]
    if kind == "complex":
        return np.stack([y.real, y.imag]), (0, 1)
    if kind in ("modulus", "phase"):
        return y[None, :], (0,)
    outputs = primary_outputs(model)
    return np.stack([recording.outputs[o] for o in found]), tuple(outputs.index(o) for o in found)


def _check_motion(model: Model, case: Case, recording: Recording) -> None:
    """What a rate is taken of moves, in one of the recordings at least: it may be held in others."""
    if model.is_time_model and recording.n < 2:
        raise InputError(f"recording '{recording.name}': one sample only, wanted a record over time")
    for of in {i.derived[1] for i in model.inputs if i.derived and i.derived[0] == "rate"}:
        recorded = [r.inputs[of] for r in (recording, *case.fit) if of in r.inputs and r.inputs[of].size]
        if recorded and not any(np.ptp(x) for x in recorded):
            raise InputError(
                f"recording '{recording.name}': '{of}' is {recorded[0][0]:g} throughout, wanted a motion"
            )


def input_noise(model: Model, case: Case, recording: Recording) -> dict[str, float | None]:
    """Standard deviations of recorded inputs; None where it has to be estimated from the record: it is not
    stated,
    or high differences of the record hold more than BELIEVED times what is."""
    from modelgen.recordings.noise import noise_std

    sigma = case.noise_of(recording).sigma
    found = {i.name: sigma.get(i.name) for i in model.inputs if i.derived is None}
    for name in {i.derived[1] for i in model.inputs if i.derived}:
        told = found.get(name)
        if told and noise_std(recording.inputs[model.axis], recording.inputs[name]) > BELIEVED * told:
            found[name] = None
    return found


def _spread(noise: Noise, name: str, kind: str, y: Array) -> tuple[Spread, bool]:
    """The noise of an impedance, and whether it is stated: if not, it is taken to be relative, and the
    scatter between neighbours."""
    from modelgen.fit.scatter import local_scatter

    absolute, relative = noise.sigma.get(name), noise.relative.get(name)
    if absolute is None and relative is None:
        return (0.0, local_scatter(np.log(y) if kind == "modulus" else _unwrapped_log(y)), 0.0), False
    return (absolute or 0.0, relative or 0.0, 0.0), True


def sizes_of(spread: Spread, size: Array) -> Array:
    """(n,) σ of impedances of a `size` (n,): σ² = a² + (r |Z|)² + (b |Z|²)²."""
    return np.hypot(np.hypot(spread[0], spread[1] * size), spread[2] * size**2)


def _weight_of(reference: Array, spread: Spread, kind: str, turning: bool = True) -> Array:
    """1/σ of each sample; of complex ones in the reference's frame, where errors turn with it."""
    sigma = sizes_of(spread, np.abs(reference))
    if kind == "complex" and not turning:
        return np.asarray(1.0 / sigma, dtype=complex)
    if kind == "complex":
        return np.asarray(np.conj(reference) / np.abs(reference) / sigma)
    return np.asarray(1.0 / sigma[None, :])


ALIKE = 4.0
"""Times the noise that a sample and its neighbours may differ: farther off, it is its own reference."""


def _between_neighbours(y: Array, noise: Spread) -> Array:
    """y (n,) at each sample as a cubic through its four neighbours has it, where these agree.

    A weight must not hold its own sample's noise: weights 1/y would favour whatever makes the model smaller,
    by N σ² for a smooth error of size σ over N samples.
    """
    smooth = np.array(y)
    smooth[2:-2] = (4 * (y[1:-3] + y[3:-1]) - (y[:-4] + y[4:])) / 6
    parts = 2 if np.iscomplexobj(y) else 1
    sigma = sizes_of(noise, np.abs(y)) * np.sqrt(2 * parts)
    return np.where((np.abs(smooth - y) < ALIKE * sigma) & (smooth != 0), smooth, y)


SMALL = 0.03
"""Of a record's rms: below that a relative noise grows no smaller, as no instrument is exact where it reads
zero."""


def _weight(case: Case, recording: Recording, found: list[str]) -> tuple[Array, bool]:
    """1/σ of each sample of real outputs, and whether σ is stated: if not, it is the scatter between
    neighbours, but no less than the rounding: what happens to stay on one tread does not scatter."""
    from modelgen.fit.scatter import local_scatter, rounding

    noise = case.noise_of(recording)
    rows, stated = [], True
    for o in found:
        x = recording.outputs[o]
        a, r = noise.sigma.get(o), noise.relative.get(o)
        stated = stated and (a is not None or r is not None)
        if a is None and r is None:
            level: float | Array = max(local_scatter(x), rounding(x))
        else:
            size = np.hypot(x, SMALL * np.sqrt(np.mean(x**2)))
            level = np.maximum(np.hypot(a or 0.0, (r or 0.0) * size), rounding(x) if a is None else 0.0)
        rows.append(1.0 / np.broadcast_to(level, x.shape))
    return np.stack(rows), stated


def _unwrapped_log(z: Array) -> Array:
    return np.log(np.abs(z)) + 1j * np.unwrap(np.angle(z))


def _calibration_root(
    model: Model, case: Case, recording: Recording, output: str, kind: str, weight: Array, reference: Array
) -> Together | None:
    """Whitens a smooth relative instrument error, correlated over a length in ln f, and independent noise
    1/|`weight`|, relative to `reference` (n,), too."""
    noise = case.noise_of(recording)
    stated = noise.calibration.get(output)
    if stated is None or kind not in ("complex", "modulus"):
        return None
    # one instrument may err alike in all m sweeps: errors √m as large leave their mean as uncertain as that
    own = 1 / (np.abs(np.atleast_2d(weight)[0]) * np.abs(reference))
    rms, length = stated[0] * float(np.sqrt(len(case.fit))), stated[1]
    lnf = np.log(np.asarray(recording.inputs[model.axis]))
    return Together.of((rms / own)[:, None] * smooth_modes([lnf], length)[0])
