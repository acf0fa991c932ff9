"""What the trials tell beyond shares: are stated probabilities true, what is mixed up, who notices what."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from modelgen.prove.scores import (
    FAINT_BELOW,
    POWER_FROM,
    Mark,
    Row,
    Share,
    board,
    claim,
    coverage,
    depth,
    detected,
    effect_of,
    found_out,
    holdout,
    of_kinds,
    predicts,
    seconds,
    share,
    usable,
    weighed,
)

BINS = (0.0, 0.5, 0.7, 0.85, 0.95, 1.0001)
POWER_BINS = (0.0, 12.0, 20.0, FAINT_BELOW, 60.0, 150.0, 600.0, 3e3, 3e4, np.inf)


def calibration(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Stated probabilities of the first claim, in bins, against how often it was right."""
    claims = [c for c in map(claim, rows) if c]
    found = []
    for a, b in pairwise(BINS):
        inside = [(p, ok) for p, ok in claims if a <= p < b]
        if inside:
            stated = float(np.mean([p for p, _ in inside]))
            found.append({"stated": stated, "right": share(ok for _, ok in inside)})
    return found


def expected_error(bins: Sequence[Mapping[str, Any]]) -> float:
    """Mean distance of stated probability and share right, weighted by the number of claims."""
    n = sum(b["right"].n for b in bins)
    return sum(b["right"].n * abs(b["stated"] - b["right"].value) for b in bins) / n if n else float("nan")


def confusion(rows: Sequence[Row]) -> Counter[tuple[str, str]]:
    """(concealed, named first) -> trials; of a pair the effect that was named, if one was."""
    return Counter(taken(r) for r in weighed(rows))


def taken(row: Row) -> tuple[str, str]:
    """What was concealed, and what was named first."""
    first = "no verdict" if row["error"] else row["first"] or "nothing"
    first = "unknown" if first.startswith("unknown") else first
    return first if first in row["effects"] else effect_of(row), first


def mixed_up(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Each confusion, most often first: concealed, named, trials, in how many the verdict itself said that
    the data don't tell the two, smallest and largest d², kinds of noise."""
    wrong: dict[tuple[str, str], list[Row]] = {}
    for r in weighed(rows):
        pair = taken(r)
        unlisted = pair[0].startswith("novel:") and pair[1] == "unknown"
        if pair[0] != pair[1] and not unlisted and r.get("named") is not True:
            wrong.setdefault(pair, []).append(r)
    return [
        {
            "concealed": pair[0],
            "named": pair[1],
            "n": len(group),
            "said": sum(bool(r.get("in_set")) for r in group),
            "d2": (min(map(depth, group)), max(map(depth, group))),
            "noise": sorted({r["noise"] for r in group}),
            "indices": [r["index"] for r in group],
        }
        for pair, group in sorted(wrong.items(), key=lambda x: (-len(x[1]), x[0]))
    ]


def power(rows: Sequence[Row]) -> dict[str, list[dict[str, Any]]]:
    """Method -> bins of d² with their mean, and how often it notices that something is missing."""
    rows = [r for r in rows if r["effects"] and r["d2"]]
    methods: dict[str, Mark] = {"modelgen": detected}
    for n in sorted({n for r in rows for n in r["rivals"]} - {"diagnosis"}):
        methods[n] = partial(_noticed, n)
    bins = [[r for r in rows if a <= depth(r) < b] for a, b in pairwise(POWER_BINS)]
    return {
        name: [
            {
                "d2": float(np.exp(np.mean([np.log(depth(r)) for r in group]))),
                "found": share(map(mark, group)),
            }
            for group in bins
            if group
        ]
        for name, mark in methods.items()
    }


def strangers(rows: Sequence[Row]) -> tuple[Share, Share, int]:
    """Of physics that no catalogue holds: how often it is called unknown, of the kinds that were in mind and
    of the others; how often a wrong name predicts as well as the true law."""
    old, new = (share(map(of_kinds("unknown", x), rows)) for x in (True, False))
    return old, new, sum(bool(r.get("misnamed")) and predicts(r) for r in rows)


def missed(rows: Sequence[Row]) -> tuple[int, int]:
    """How many hold-outs the verdict's model misses by more than the true law does; and in how many of these
    the excess of χ² is within twice what the verdict had foreseen."""
    far = [r for r in rows if holdout(r) is False and not r["error"]]
    pairs = [(r["rivals"]["diagnosis"]["holdout"], r["verdict"].get("foreseen") or 1.0) for r in far]
    return len(far), sum(chi2 - 1 <= 2 * (f**2 - 1) for chi2, f in pairs)


def _noticed(method: str, row: Row) -> bool | None:
    return row["rivals"].get(method, {}).get("found")


def proposals(rows: Sequence[Row]) -> tuple[Share, Share]:
    """Of what was ambiguous: how often a further recording was proposed; how often that resolved it."""
    asked = [r["followed"] for r in weighed(rows) if r.get("followed")]
    return share(f["made"] for f in asked), share(f["resolved"] for f in asked if f["made"])


def baselines(rows: Sequence[Row]) -> dict[str, dict[str, Share]]:
    """The diagnosis beside simpler methods, mark by mark; no trials where a method has nothing to say."""
    rows = weighed(rows)
    names = sorted({n for r in rows for n in r["rivals"]} - {"diagnosis"})
    ours = {
        "false alarm": share(r.get("alarm") for r in rows),
        "found": share(map(found_out, rows)),
        "first name": share(r.get("named") for r in rows),
        "family": share(r.get("family") for r in rows),
        "hold-out": share(holdout(r) for r in rows),
    }
    return {"modelgen": ours} | {n: _baseline(rows, n) for n in names}


def _baseline(rows: Sequence[Row], name: str) -> dict[str, Share]:
    told = [(r, r["rivals"][name]) for r in rows if name in r["rivals"]]
    return {
        "false alarm": share(m["found"] if not r["effects"] else None for r, m in told),
        "found": share(m["found"] if depth(r) >= POWER_FROM else None for r, m in told),
        "first name": share(m["named"] for _, m in told),
        "family": share(m["family"] for _, m in told),
        "hold-out": share(holdout(r, name) for r, _ in told),
    }


def to_json(rows: Sequence[Row], about: Mapping[str, Any]) -> dict[str, Any]:
    """The scores as plain data: schema `modelgen.proof/1`."""
    good = usable(rows)

    def plain(s: Share) -> dict[str, Any]:
        return asdict(s) | {"value": s.value if s.n else None}

    return {
        "schema": "modelgen.proof/1",
        **about,
        "trials": len(good),
        "without_verdict": sum(bool(r["error"]) for r in good),
        "withheld": sum("withheld" in r for r in rows),
        "scores": {
            b["goal"].key: plain(b["share"]) | {"wanted": b["goal"].wanted, "met": b["met"]}
            for b in board(good)
        },
        "confused": mixed_up(good),
        "power": {n: [{"d2": p["d2"]} | plain(p["found"]) for p in ps] for n, ps in power(good).items()},
        "coverage": plain(coverage(good)),
        "calibration": [{"stated": c["stated"], "right": plain(c["right"])} for c in calibration(good)],
        "seconds": {c: seconds(good, c) if good else None for c in ("cpu", "wall")},
        "baselines": {n: {k: plain(v) for k, v in m.items()} for n, m in baselines(good).items()},
        "rows": list(rows),
    }
