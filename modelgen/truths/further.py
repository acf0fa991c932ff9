"""The recording that a diagnosis proposes, made with the concealed device: it reads the sentence, as one
would.

Understood are sweeps over another band, with another mass, blocked, at another amplitude, or averaged, and
motions that are faster, slower, larger, smaller, about another mean, repeated, or a step that is held.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from .drive import Motion
from .secret import Secret

Entry = dict[str, Any]
PREFIX = {"": 1.0, "k": 1e3, "M": 1e6}
NUMBER = r"([-+0-9.eE]+)"


def further(secret: Secret, sentence: str) -> Secret | None:
    """The secret with one more recording to fit, or None where the sentence proposes none that is
    understood."""
    key = "records" if secret.domain == "force" else "sweeps"
    entries = [e for e in secret.setup[key] if e["role"] == "fit"]
    longest = max(
        entries, key=lambda e: e["n"] if key == "sweeps" else len(_motion(e).recorded(_motion(e).t))
    )
    proposed = sentence.split(" would separate ")[0]
    made = (_motions if key == "records" else _sweeps)(secret, longest, proposed)
    if made is None or " would separate " not in sentence:
        return None
    return replace(secret, setup={**secret.setup, "further": [made]})


def entries(setup: Mapping[str, Any]) -> list[Entry]:
    """All recordings of a setup: those that it was drawn with, then further ones."""
    return [*setup.get("sweeps", setup.get("records")), *setup.get("further", [])]


def _motion(e: Entry) -> Motion:
    return Motion(e["motion"], e["rate"], e["seconds"], e["pre"])


def _sweeps(secret: Secret, sweep: Entry, says: str) -> Entry | None:
    count = int(np.clip(sweep["n"], 100, 400))
    if m := re.match(rf"a sweep from {NUMBER} ([kM]?)Hz to {NUMBER} ([kM]?)Hz", says):
        lo, hi = float(m[1]) * PREFIX[m[2]], float(m[3]) * PREFIX[m[4]]
        return {**sweep, "lo": lo, "hi": hi, "n": count, "linear": False, "down": False}
    if m := re.match(rf"a second sweep with .* more mass \((\w+) = {NUMBER} kg\)", says):
        return {**sweep, "known": {**sweep["known"], m[1]: float(m[2])}}
    if says == "the same sweep with the moving side blocked":
        name = "M_m" if "M_m" in secret.base else "M_t"
        return {**sweep, "known": {**sweep["known"], name: 1e6 * secret.base[name]}}
    if m := re.match(rf"the same sweep at (\w+) = {NUMBER} mm", says):
        return {**sweep, "known": {**sweep["known"], m[1]: float(m[2])}}
    if says == "the same sweep averaged 16 times":  # as many points tell as much
        return {**sweep, "n": 16 * sweep["n"]}
    return None


def _motions(secret: Secret, record: Entry, says: str) -> Entry | None:
    motion = record["motion"]

    def faster(by: float) -> Entry:
        quick = {k: motion[k] * by for k in ("from", "to") if k in motion}
        quick |= {k: [x * by for x in motion[k]] for k in ("steps", "lines") if k in motion}
        quick |= {"seconds": motion["seconds"] / by} if "seconds" in motion else {}
        times = {"rate": record["rate"] * by, "seconds": record["seconds"] / by, "pre": record["pre"] / by}
        return {**record, **times, "motion": motion | quick}

    def changed(**parts: Any) -> Entry:
        return {**record, "motion": {**motion, **parts}}

    z = _motion(record).zva[0]
    middle, half = 0.5 * float(z.max() + z.min()), 0.5 * float(np.ptp(z))
    made: list[tuple[str, Callable[[re.Match[str]], Entry]]] = [
        (rf"the same motion {NUMBER} times as fast", lambda m: faster(float(m[1]))),
        (rf"the same motion {NUMBER} times as slow", lambda m: faster(1 / float(m[1]))),
        ("the same motion at twice the amplitude", lambda m: changed(amplitude=2 * motion["amplitude"])),
        ("the same motion at a third of the amplitude", lambda m: changed(amplitude=motion["amplitude"] / 3)),
        (rf"the same motion about a mean that is higher by {NUMBER} mm", lambda m: changed(mean=float(m[1]))),
        ("a step from end to end of the stroke", lambda m: _step(record, middle, half)),
        ("the same motion three times over", lambda m: _thrice(record)),
    ]
    for pattern, make in made:
        if m := re.match(pattern, says):
            return make(m)
    return None


def _step(record: Entry, middle: float, half: float) -> Entry:
    length = record["seconds"]
    motion = {
        "type": "hold",
        "amplitude": half,
        "mean": middle,
        "start": 0.05 * length,
        "rise": 0.03 * length,
    }
    return {**record, "motion": motion, "pre": 0.0}


def _thrice(record: Entry) -> Entry:
    """Forth, back, and forth again."""
    once = record["pre"] + record["seconds"]
    return {**record, "motion": {**record["motion"], "fold": once}, "seconds": record["seconds"] + 2 * once}
