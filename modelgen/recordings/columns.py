"""From the columns of a table to the channels of a signature, in the signature's units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import InputError, did_you_mean
from modelgen.recordings.convert import affine, is_frequency, is_time
from modelgen.recordings.lost_rows import lost_rows
from modelgen.recordings.signature import Channel, Signature
from modelgen.recordings.table import HUGE, Column, Table, fail, show

Array = NDArray[np.float64] | NDArray[np.complex128]


@dataclass(frozen=True)
class Part:
    """What one column can hold: a channel's value, or one part of a complex channel."""

    channel: str
    what: str  # "value", "re", "im", "modulus", "phase"
    unit: str


@dataclass(frozen=True)
class Channels:
    """All channels of one table: arrays of shape (n,) in the units of the signature."""

    inputs: dict[str, NDArray[np.float64]]
    outputs: dict[str, Array]
    kinds: dict[str, str]
    warnings: tuple[str, ...]


def read_channels(table: Table, signature: Signature) -> Channels:
    """Pick, convert and check the columns of a model's inputs and outputs.

    Raises InputError, with file, line and column, for what is missing, double, unordered or of a wrong unit.
    """
    picked, notes = _pick(table, signature)
    scales = {part: _scale(table, column, part.unit) for part, column in picked.items()}
    raw = table.numbers(tuple(picked.values()))
    values = {}
    for (part, column), numbers in zip(picked.items(), raw, strict=True):
        a, b = scales[part]
        values[part] = numbers * a + b if b else numbers * a
        _check_range(table, column, part, values[part], numbers, part.channel == signature.axis)
        if part.what == "phase" and column.unit == "rad":
            notes += _rather_degrees(table.at(column), numbers)
    order, note = _order(table, picked, values, signature)
    if order is not None:
        values = {part: v[order] for part, v in values.items()}
    named = {(part.channel, part.what): v for part, v in values.items()}
    inputs = {c.name: named[c.name, "value"] for c in signature.inputs}
    outputs: dict[str, Array] = {}
    kinds: dict[str, str] = {}
    for channel in signature.outputs:
        found = _combine(channel, named)
        if found is not None:
            kinds[channel.name], outputs[channel.name] = found
            _check_measured(table, channel, found[1], order)
    return _without_lost(Channels(inputs, outputs, kinds, (*notes, *note)), table, signature.axis)


def _without_lost(found: Channels, table: Table, axis: str) -> Channels:
    """The channels without rows that were lost, and a warning of these."""
    columns = [x for k, x in (*found.inputs.items(), *found.outputs.items()) if k != axis]
    lost = lost_rows(columns) if axis else np.zeros(0, dtype=bool)
    if not lost.any():
        return found
    inputs = {k: x[~lost] for k, x in found.inputs.items()}
    outputs = {k: x[~lost] for k, x in found.outputs.items()}
    what = f"{lost.sum()} rows hold the same values in all columns and then jump: left out as lost"
    return Channels(inputs, outputs, found.kinds, (*found.warnings, f"{table.path}: {what}"))


def _rather_degrees(place: str, numbers: NDArray[np.float64]) -> tuple[str, ...]:
    """A warning where a phase in radian is wrapped as one in degrees, or goes on for turns."""
    most = np.abs(numbers).max()
    wraps = most <= TURN and np.abs(np.diff(numbers, prepend=numbers[0])).max() > 300
    says = "jumps as a phase in degrees does, and is read as radian"
    says = says if wraps else f"phases up to {most:.3g} rad: degrees?"
    return (f"{place}: {says}",) if most > TURNS else ()


TURN, TURNS = 361.0, 4 * np.pi  # of a phase in degrees, and of one in radian that needs no second look


def _check_measured(table: Table, channel: Channel, values: Array, order: NDArray[np.intp] | None) -> None:
    """Something was measured, and what is complex has a phase everywhere."""
    if not np.any(np.abs(values) >= 1 / HUGE):
        raise fail(f"{table.at()}: '{channel.name}' is zero in all {values.size} rows: nothing was measured")
    zero = np.abs(values) == 0
    if np.iscomplexobj(values) and zero.any():
        row = int(np.argmax(zero))
        row = row if order is None else int(order[row])
        raise fail(f"{table.at(row=row)}: '{channel.name}' is zero there, which has no phase")


def _parts(signature: Signature) -> dict[str, Part]:
    """Every column name that a table of this signature may have, and what it means."""
    parts: dict[str, Part] = {}
    for channel in (*signature.inputs, *signature.outputs):
        if not channel.complex:
            parts |= {name: Part(channel.name, "value", channel.unit) for name in channel.names}
    complex_ones = [c for c in signature.outputs if c.complex]
    for channel in complex_ones:  # a bare "phase" beside no modulus is that of what is measured, the first
        parts |= dict(_complex_parts(channel, bare_phase=channel is complex_ones[0]))
    return parts


def _complex_parts(channel: Channel, bare_phase: bool) -> Iterator[tuple[str, Part]]:
    for x in channel.names:
        yield f"Re {x}", Part(channel.name, "re", channel.unit)
        yield f"Im {x}", Part(channel.name, "im", channel.unit)
        for name in (f"|{x}|", f"abs_{x}", f"abs {x}"):
            yield name, Part(channel.name, "modulus", channel.unit)
        for name in (f"phase {x}", f"phase_{x}", *(["phase"] if bare_phase else [])):
            yield name, Part(channel.name, "phase", "deg")


def _other_words(channel: Channel) -> list[tuple[str, str]]:
    """Further names of the real and the imaginary part of a complex quantity."""
    return [p for x in channel.names for p in ((f"Re({x})", f"Im({x})"), (f"{x}_re", f"{x}_im"))]


def _in_other_words(table: Table, signature: Signature, parts: Mapping[str, Part]) -> dict[str, Part]:
    """Columns Re(Z) and Im(Z), or Z_re and Z_im, of complex quantities that the table has in no other way."""
    there = {c.name for c in table.columns}
    seen = {parts[n].channel for n in there & set(parts)}
    found: dict[str, Part] = {}
    for channel in (c for c in signature.outputs if c.complex and c.name not in seen):
        for re, im in [p for p in _other_words(channel) if set(p) <= there - set(parts)][:1]:
            found[re] = Part(channel.name, "re", channel.unit)
            found[im] = Part(channel.name, "im", channel.unit)
    return found


def _part(table: Table, column: Column, parts: Mapping[str, Part]) -> Part | None:
    """What a column holds; a bare "phase" is that of the modulus before it, or else behind it."""
    part = parts.get(column.name)
    if part is None or (column.name, part.what) != ("phase", "phase"):
        return part
    beside = (parts.get(c.name) for c in table.columns if abs(c.index - column.index) == 1)
    return next((replace(part, channel=p.channel) for p in beside if p and p.what == "modulus"), part)


def _pick(table: Table, signature: Signature) -> tuple[dict[Part, Column], list[str]]:
    """The column of each part that the table has, and what to warn of."""
    parts = _parts(signature)
    parts |= _in_other_words(table, signature, parts)
    picked: dict[Part, Column] = {}
    others: list[Column] = []
    for column in table.columns:
        part = _part(table, column, parts)
        if part is None:
            others.append(column)
        elif part in picked:
            raise fail(f"{table.at(column)}: the same quantity as column {show(picked[part].title)}")
        else:
            picked[part] = column
    _check_complete(table, signature, picked, others)
    ignored = f"not a quantity of {signature.model}, ignored"
    notes = [f"{table.at(c)}: {ignored}{did_you_mean(c.name, parts)}" for c in others]
    if table.mark == ",":
        notes.append(f"{table.path}: commas are read as decimal marks")
    for channel in signature.outputs:  # an analyser may export Re, Im, |Z| and phase side by side
        if any(p.channel == channel.name and p.what == "re" for p in picked):
            for part in [p for p in picked if p.channel == channel.name and p.what in ("modulus", "phase")]:
                column = picked.pop(part)
                notes.append(f"{table.at(column)}: ignored, {channel.name} is read from its Re and Im")
    return picked, notes


def _check_complete(
    table: Table, signature: Signature, picked: dict[Part, Column], others: list[Column]
) -> None:
    """Every input, at least one output, and no real part without the imaginary one."""
    have = {(p.channel, p.what) for p in picked}
    spare = [c.name for c in others]
    for channel in signature.inputs:
        if (channel.name, "value") not in have:
            wanted = f"'{channel.name} [{channel.unit}]'"
            hint = next((h for x in channel.names if (h := did_you_mean(x, spare))), _listing(table))
            raise fail(f"{table.at()}: no column {wanted}, which {signature.model} needs{hint}")
    names = {c.name for c in signature.outputs}
    if not any(p.channel in names for p in picked):
        titles = [x for x, p in _parts(signature).items() if p.channel in names]
        pairs = [p for c in signature.outputs if c.complex for p in _other_words(c)]
        lone = [(n, twin) for re, im in pairs for n, twin in ((re, im), (im, re)) if n in spare]
        hint = next((h for x in titles if (h := did_you_mean(x, spare))), _listing(table))
        hint = f", found '{lone[0][0]}' without '{lone[0][1]}'" if lone else hint
        raise fail(f"{table.at()}: no output column, wanted {' or '.join(map(repr, titles[:4]))}{hint}")
    for part, column in picked.items():
        twin = {"re": "im", "im": "re"}.get(part.what)
        if twin and (part.channel, twin) not in have:
            hint = did_you_mean(f"{twin.title()} {part.channel}", spare)
            raise fail(f"{table.at(column)}: '{twin.title()} {part.channel}' is missing beside it{hint}")
    for channel in signature.outputs:
        if {what for name, what in have if name == channel.name} == {"phase"}:
            _check_no_modulus(table, channel, others)


def _check_no_modulus(table: Table, channel: Channel, others: Sequence[Column]) -> None:
    """No column that is left looks like the modulus of what is measured by its phase alone."""
    for column in others:
        try:
            affine(column.unit or "", channel.unit)
        except InputError:
            continue
        wanted = f"'|{channel.name}| [{channel.unit}]'"
        raise fail(f"{table.at(column)}: is it the modulus beside the phase? Wanted {wanted}")


def _listing(table: Table) -> str:
    return "; found " + show(", ".join(c.title for c in table.columns))


def _scale(table: Table, column: Column, wanted: str) -> tuple[float, float]:
    if column.unit is None:
        raise fail(f"{table.at(column)}: no unit, wanted '{column.name} [{wanted}]'")
    try:
        return affine(column.unit, wanted)
    except InputError as why:
        raise fail(f"{table.at(column)}: {why}") from why


def _check_range(
    table: Table,
    column: Column,
    part: Part,
    values: NDArray[np.float64],
    found: NDArray[np.float64],
    axis: bool,
) -> None:
    """Frequencies of a sweep and moduli are above zero (a speed of rotation may not be), and squares of
    squares do not overflow in the model's unit."""
    for wrong, says in (
        (~(np.abs(values) <= HUGE), f"is too large in '{part.unit}'"),
        ((values <= 0) & (axis and is_frequency(part.unit)), "is not a frequency above zero"),
        ((values < 0) & (part.what == "modulus"), "is negative, but a modulus can't be"),
        ((values == 0) & (part.what == "modulus"), "is no modulus that has a phase or a relative error"),
    ):
        if wrong.any():
            row = int(np.argmax(wrong))
            raise fail(f"{table.at(column, row)}: {found[row]:g} {says}")


def _order(
    table: Table, picked: dict[Part, Column], values: dict[Part, NDArray[np.float64]], signature: Signature
) -> tuple[NDArray[np.intp] | None, tuple[str, ...]]:
    """The permutation that sorts the axis, None where it is sorted, and the warning that goes with it.

    Frequencies can be sorted without harm; samples of time can't, since they may come from two records.
    """
    part = next((p for p in picked if p.channel == signature.axis), None)
    if part is None:
        return None, ()
    axis, column = values[part], picked[part]
    order = np.argsort(axis, kind="stable")
    twice = np.flatnonzero(np.diff(axis[order]) == 0)
    back = np.flatnonzero(np.diff(axis) < 0)
    if back.size and is_time(part.unit):
        row = int(back[0]) + 1
        before, after = (f"{axis[n]:.12g} {part.unit}" for n in (row - 1, row))
        raise fail(f"{table.at(column, row)}: time goes back, from {before} to {after}")
    if twice.size:
        first, second = (int(table.lines[order[n]]) for n in (twice[0], twice[0] + 1))
        value = axis[order[twice[0]]]
        raise fail(
            f"{table.path}, lines {first} and {second}, column {show(column.title)}: "
            f"{value:.12g} {part.unit} occurs twice, wanted each once (two sweeps or runs are two "
            "recordings; repeats of a point are averaged first)"
        )
    if not back.size:
        return None, ()
    row = int(back[0]) + 1
    if back.size == axis.size - 1:  # a sweep downwards: kept in the order of recording, which a drift follows
        return None, ()
    return order, (f"{table.at(column, row)}: not in ascending order, the rows were sorted",)


def _combine(channel: Channel, named: dict[tuple[str, str], NDArray[np.float64]]) -> tuple[str, Array] | None:
    """(kind, array) of one output from the parts that the table has, None when it has none."""
    value, re, im, modulus, phase = (
        named.get((channel.name, what)) for what in ("value", "re", "im", "modulus", "phase")
    )
    if value is not None:
        return "real", value
    if re is not None and im is not None:
        return "complex", re + 1j * im
    if modulus is not None and phase is not None:
        return "complex", modulus * np.exp(1j * np.deg2rad(phase))
    if modulus is not None:
        return "modulus", modulus
    return None if phase is None else ("phase", phase)
