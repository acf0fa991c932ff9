"""Hum in the channel of a displacement: a line far above the motion that the outputs do not follow.

Differentiated, a hum of a thousandth of the stroke may be a tenth of the speed, in a direction of its own.
What moves in truth shows in the force of any spring and dashpot; a line in the channel alone shows in none.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modelgen.fit.series import Array
from modelgen.language import Model
from modelgen.recordings import Case, Recording

FEWEST = 500
"""Samples in which a line is looked for."""
EVEN = 1e-2
"""Steps of time that differ by less, relative, are even."""
MOTION, ABOVE = 1e-3, 3.0
"""Share of the power that is no motion's, and how many times as fast as that a hum is, at least."""
STANDS, AROUND = 40.0, 40
"""Times the median of the spectrum so many lines around it that a hum's power is: noise has that in one of
10^12 lines."""
FOLLOWED = 0.3
"""Share of what a spring and a dashpot would make of it up to which the outputs do not follow."""
MOST = 5
"""Lines of one hum."""
PARTS = 20
"""Of the distance between two lines of the spectrum, to which a frequency is told."""


def without_hum(model: Model, case: Case) -> tuple[Case, tuple[str, ...]]:
    """The case with hum taken out of recorded displacements, and a note for each recording that has some."""
    moved = {i.derived[1] for i in model.inputs if i.derived and i.derived[0] in ("rate", "turning")}
    records, notes = [], []
    for r in case.recordings:
        for name in sorted(moved & set(r.inputs)):
            z, lines = _quiet(r, model.axis, name)
            if lines:
                unit = next(i.unit for i in model.inputs if i.name == name)
                said = " and ".join(f"{size:.2g} {unit} at {f:.4g} Hz" for f, size in lines)
                names = " and ".join(sorted(r.outputs))
                notes.append(
                    f"{name} hums in '{r.name}', {said}, which {names} does not follow: taken out of {name}"
                )
                r = replace(r, inputs={**r.inputs, name: z})
        records.append(r)
    return (replace(case, recordings=tuple(records)), tuple(notes)) if notes else (case, ())


def _quiet(r: Recording, axis: str, name: str) -> tuple[Array, list[tuple[float, float]]]:
    """A displacement without its hum, and frequency and amplitude of each line of that."""
    t, z = r.inputs[axis], np.asarray(r.inputs[name], dtype=float)
    outputs = [y for y in r.outputs.values() if not np.iscomplexobj(y)]
    steps = np.diff(t)
    if len(t) < FEWEST or np.ptp(steps) > EVEN * np.mean(steps) or not np.ptp(z) > 0:
        return z, []
    lines: list[tuple[float, float]] = []
    for _ in range(MOST):
        f = _line(t, z)
        if f is None or any(_follows(t, z, y, f) for y in outputs):
            break
        wave = _at(t, z, f)
        lines.append((f, abs(wave)))
        z = z - (wave * np.exp(2j * np.pi * f * t)).real
    return z, lines


def _line(t: Array, z: Array) -> float | None:
    """The frequency of the strongest line far above the motion; None without one."""
    span = float(t[-1] - t[0]) * len(t) / (len(t) - 1)
    power = np.abs(np.fft.rfft(np.hanning(len(z)) * (z - np.mean(z)))) ** 2
    above = np.cumsum(power[::-1])[::-1] < MOTION * float(np.sum(power))
    first = max(int(ABOVE * np.argmax(above)), AROUND)
    if not above[-1] or first + AROUND >= len(power):
        return None
    wide = np.lib.stride_tricks.sliding_window_view(power, 2 * AROUND + 1)[first - AROUND :]
    over = power[first : first + len(wide)] / np.maximum(np.median(wide, axis=1), 1e-300)
    k = int(np.argmax(over))
    if over[k] < STANDS:
        return None
    near = (first + k + np.linspace(-1, 1, 2 * PARTS + 1)) / span
    return float(near[int(np.argmax([abs(_at(t, z, float(f))) for f in near]))])


def _at(t: Array, x: Array, f: float) -> complex:
    """Complex amplitude of x at the frequency f."""
    window = np.hanning(len(x))
    return complex(2 * np.sum(window * (x - np.mean(x)) * np.exp(-2j * np.pi * f * t)) / np.sum(window))


def _follows(t: Array, z: Array, y: Array, f: float) -> bool:
    """Whether an output has as much at the frequency f as the spring and the dashpot that are nearest to it
    in the motion would make of what z has."""
    wave = _at(t, z, f)
    rate = np.gradient(z - (wave * np.exp(2j * np.pi * f * t)).real, t)
    terms = np.column_stack([z, rate, np.ones(len(z))])
    stiffness, damping, _ = np.linalg.lstsq(terms, y, rcond=None)[0]
    made = abs(stiffness + 2j * np.pi * f * damping) * abs(wave)
    return abs(_at(t, np.asarray(y, dtype=float), f)) > FOLLOWED * made
