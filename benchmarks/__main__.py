"""`python -m benchmarks [--only WORK] [--json FILE] [--plot FILE]`: everything on one core, in one run."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks import dahl, fits, point, transducer, whole
from benchmarks.timing import OURS, Entry, race
from modelgen.files import write_atomically

Makers = Mapping[str, Callable[..., Any]]


def given(makers: Makers, *args: Any) -> dict[str, Callable[[], Any]]:
    return {who: (lambda m=make: m(*args)) for who, make in makers.items()}


def works() -> dict[str, Callable[[], list[Entry]]]:
    """What there is to race at: name, and the race."""
    points, sets = 401, 1000
    many, one, motion = transducer.setting(points, sets), transducer.setting(points, 1), dahl.motion()
    return {
        "batch": lambda: race("M1 objective, 1000 sets x 401", given(transducer.BATCH, many), points * sets),
        "jacobian": lambda: race("M1 value and Jacobian", given(point.JACOBIAN, one), points),
        "normal": lambda: race("M1 normal equations", given(point.FUSED, one), points),
        "swarm": lambda: race("M1 swarm, 100 x 500", given(fits.SWARMS), check=False, patience=0.2),
        "descent": lambda: race("M1 descent from a random start", given(fits.DESCENTS), check=False),
        "simulation": lambda: race("M2 simulation, 40 000 samples", given(dahl.SIMULATE, motion)),
        "sensitivity": lambda: race("M2 normal equations, 40 000 samples", given(dahl.NORMAL, motion)),
    }


def shown(entries: list[Entry]) -> str:
    """A table: median, ratio to ours, largest difference from our answer."""
    ours = next(e.seconds for e in entries if e.who == OURS)
    assert ours is not None
    per_point = entries[0].per > 1
    lines = [
        f"\n{entries[0].work}",
        f"  {'':30}{'ns a point' if per_point else 'ms':>12}{'ratio':>9}  difference",
    ]
    for e in sorted(entries, key=lambda e: e.seconds or float("inf")):
        if e.seconds is None:
            lines.append(f"  {e.who:30}{e.note}")
            continue
        cost = e.seconds * 1e9 / e.per if per_point else e.seconds * 1e3
        apart = "" if e.difference is None else f"{e.difference:.0e}"
        lines.append(f"  {e.who:30}{cost:12.4g}{e.seconds / ours:9.2f}  {apart}")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--only", action="append", metavar="WORK", help="one of the races, or 'whole'")
    parser.add_argument("--json", type=Path, help="write all numbers")
    parser.add_argument("--plot", type=Path, help="draw cost against points, sets and parameters")
    args = parser.parse_args()
    entries: list[Entry] = []
    figures: dict[str, Any] = {}
    if not args.only or "whole" in args.only:
        figures = whole.shared()  # before anything is bound to one core
    with whole.on(whole.CORES[-1:]):
        for name, run in works().items():
            if not args.only or name in args.only:
                found = run()
                print(shown(found), flush=True)
                entries += found
        if not args.only or "whole" in args.only:
            figures |= whole.alone()
            print("\n" + json.dumps(figures, indent=1))
        if args.plot:
            from benchmarks.plot import draw

            draw(args.plot)
    if args.json:
        answer = {"schema": "modelgen.benchmarks/1", "races": [asdict(e) for e in entries], "whole": figures}
        write_atomically(args.json, json.dumps(answer, indent=1) + "\n")


if __name__ == "__main__":
    main()
