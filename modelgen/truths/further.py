"""The recording that a diagnosis proposes, made with the concealed device: it reads the sentence, as one
would.

Understood are sweeps over another band, in the other direction, with another mass, blocked or at another
amplitude; motions that are faster, slower, larger, smaller, about another mean, repeated, or a step that is
held; each of them made once, or many times and averaged.
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
PREFIX = {"": 1.0, "k": 1e3, "M": 1e6, "G": 1e9}
NUMBER = r"([-+0-9.eE]+)"
FREQUENCY = rf"{NUMBER} ([kMG]?)Hz"
BAND = rf"from {FREQUENCY} to {FREQUENCY}"
AVERAGED = r",? averaged (\d+) times$"


def further(secret: Secret, sentence: str) -> Secret | None:
    """The secret with one more recording to fit, or None where the sentence proposes none that is
    understood."""
    key = "records" if secret.domain == "force" else "sweeps"
    entries = [e for e in secret.setup[key] if e["role"] == "fit"]
    longest = max(
        entries, key=lambda e: e["n"] if key == "sweeps" else len(_motion(e).recorded(_motion(e).t))
    )
    proposed, separates, _ = sentence.partition(" would separate ")
    often = re.search(AVERAGED, proposed)
    once = proposed[: often.start()] if often else proposed
    made = (_motions if key == "records" else _sweeps)(secret, longest, once) if separates else None
    if made is None or (made == longest and not often):
        return None
    made = {**made, "averaged": int(often[1])} if often else made
    return replace(secret, setup={**secret.setup, "further": [made]})


def entries(setup: Mapping[str, Any]) -> list[Entry]:
    """All recordings of a setup: those that it was drawn with, then further ones."""
    return [*setup.get("sweeps", setup.get("records")), *setup.get("further", [])]


def _motion(e: Entry) -> Motion:
    return Motion(e["motion"], e["rate"], e["seconds"], e["pre"])


def _sweeps(secret: Secret, sweep: Entry, says: str) -> Entry | None:
    """One sweep; a band, a load and an amplitude may be given together."""
    if not re.match(r"(a|a second|the same) sweep\b", says):
        return None
    made = dict(sweep)
    if "in the other direction" in says:
        made["down"] = not sweep.get("down", False)
    if m := re.search(BAND, says):
        lo, hi = float(m[1]) * PREFIX[m[2]], float(m[3]) * PREFIX[m[4]]
        count = int(np.clip(sweep["n"], 100, 400))
        made |= {"lo": lo, "hi": hi, "n": count, "linear": False, "down": False}
    if m := re.search(rf"(?:more|less) mass \((\w+) = {NUMBER} kg\)", says):
        made["known"] = {**made["known"], m[1]: float(m[2])}
    if "with the moving side blocked" in says:
        name = "M_m" if "M_m" in secret.base else "M_t"
        made["known"] = {**made["known"], name: 1e6 * secret.base[name]}
    if m := re.search(rf"at (\w+) = {NUMBER} mm", says):
        made["known"] = {**made["known"], m[1]: float(m[2])}
    return made


def _motions(secret: Secret, record: Entry, says: str) -> Entry | None:
    """One motion; its rate and its amplitude may be changed together."""
    motion = record["motion"]
    z = _motion(record).zva[0]
    middle, half = 0.5 * float(z.max() + z.min()), 0.5 * float(np.ptp(z))
    if says.startswith("a step from end to end of the stroke"):
        return _step(record, middle, half)
    if not says.startswith("the same motion"):
        return None
    made = record

    def changed(**parts: Any) -> Entry:
        return {**made, "motion": {**made["motion"], **parts}}

    understood: list[tuple[str, Callable[[re.Match[str]], Entry]]] = [
        (rf"{NUMBER} times as fast", lambda m: _faster(made, float(m[1]))),
        (rf"{NUMBER} times as slow", lambda m: _faster(made, 1 / float(m[1]))),
        (
            rf"at {NUMBER} times the amplitude",
            lambda m: changed(amplitude=float(m[1]) * motion["amplitude"]),
        ),
        ("at a third of the amplitude", lambda m: changed(amplitude=motion["amplitude"] / 3)),
        (rf"about a mean that is higher by {NUMBER} mm", lambda m: changed(mean=float(m[1]))),
        ("three times over", lambda m: _thrice(made)),
    ]
    for pattern, make in understood:
        if m := re.search(pattern, says):
            made = make(m)
    return made


def _faster(record: Entry, by: float) -> Entry:
    motion = record["motion"]
    quick = {k: motion[k] * by for k in ("from", "to") if k in motion}
    quick |= {k: [x * by for x in motion[k]] for k in ("steps", "lines") if k in motion}
    quick |= {"seconds": motion["seconds"] / by} if "seconds" in motion else {}
    times = {"rate": record["rate"] * by, "seconds": record["seconds"] / by, "pre": record["pre"] / by}
    return {**record, **times, "motion": motion | quick}


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
