"""The scores of a trial as tables of text."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from scipy.stats import beta

Row = dict[str, Any]
MARKS = ("adequate", "alarm", "named", "family", "in_set", "port", "both", "unknown", "misnamed")
DEPTHS = (30.0, 60.0, 300.0, 1500.0, 1e9)


def report(rows: Sequence[Row]) -> str:
    """Tables by kind, domain, noise, depth and effect; the confusions; calibration; the failures."""
    scored = [r for r in rows if not r["error"]]
    parts = [f"{len(scored)} of {len(rows)} cases scored"]
    if scored:
        for title, key in (
            ("kind", _kind),
            ("domain", lambda r: r["domain"]),
            ("noise", lambda r: r["noise"]),
            ("d²", _depth),
            ("effect", _effect),
        ):
            parts.append(table(title, scored, key))
        parts += [confusions(scored), calibration(scored), overall(scored)]
    failures = [f"  case {r['case']} (seed {r['seed']}): {r['error']}" for r in rows if r["error"]]
    if failures:
        parts.append("\n".join(["failed:", *failures]))
    return "\n\n".join(p for p in parts if p)


def _kind(r: Row) -> str:
    return str(r["kind"])


def _effect(r: Row) -> str:
    return " + ".join(r["effects"]) + (f" ({r['variant']})" if r["variant"] else "") or "nothing"


def _depth(r: Row) -> str:
    d2 = min([v for k, v in r["d2"].items() if k != "all"], default=0.0)
    if not d2:
        return "nothing"
    return next(f"{a:g} - {b:g}" for a, b in zip((0.0, *DEPTHS), DEPTHS, strict=False) if d2 < b)


def mean(rows: Iterable[Row], mark: str) -> str:
    """Share of the rows where a mark is true, with how many it applies to."""
    hits = [float(r[mark]) for r in rows if r.get(mark) is not None]
    return f"{np.mean(hits):.2f}" if hits else "-"


def interval(hits: int, n: int) -> tuple[float, float]:
    """Clopper-Pearson 95 % interval of a share."""
    lo = float(beta.ppf(0.025, hits, n - hits + 1)) if hits else 0.0
    hi = float(beta.ppf(0.975, hits + 1, n - hits)) if hits < n else 1.0
    return lo, hi


def table(title: str, rows: Sequence[Row], key: Callable[[Row], str]) -> str:
    """One row a group: its size, the mean of each mark, median seconds."""
    groups: dict[str, list[Row]] = {}
    for r in rows:
        groups.setdefault(key(r), []).append(r)
    width = max(len(title), *(len(g) for g in groups))
    lines = [f"{title:<{width}} {'n':>4} " + " ".join(f"{m:>8}" for m in MARKS) + f" {'seconds':>8}"]
    for name in sorted(groups):
        cells = " ".join(f"{mean(groups[name], m):>8}" for m in MARKS)
        wall = float(np.median([r["wall"] for r in groups[name]]))
        lines.append(f"{name:<{width}} {len(groups[name]):>4} {cells} {wall:>8.2f}")
    return "\n".join(lines)


def confusions(rows: Sequence[Row]) -> str:
    """true -> named, where the first name isn't right."""
    wrong = [r for r in rows if r.get("named") is False or r.get("alarm") or r.get("misnamed")]
    pairs = Counter((_effect(r), r["first"] or "nothing") for r in wrong)
    lines = [f"  {n:>3}  {true} -> {named}" for (true, named), n in pairs.most_common()]
    return "\n".join(["true -> named:", *lines]) if lines else ""


def calibration(rows: Sequence[Row]) -> str:
    """How often claims of a stated probability are right."""
    claims = [(r["claimed"], r["named"]) for r in rows if r.get("claimed") is not None]
    lines = []
    for a, b in ((0.0, 0.5), (0.5, 0.8), (0.8, 0.95), (0.95, 1.01)):
        inside = [(p, ok) for p, ok in claims if a <= p < b]
        if inside:
            lo, hi = interval(sum(ok for _, ok in inside), len(inside))
            stated, right = np.mean([p for p, _ in inside]), np.mean([ok for _, ok in inside])
            lines.append(f"  stated {stated:.2f}: right {right:.2f} ({lo:.2f} - {hi:.2f}) of {len(inside)}")
    return "\n".join(["calibration:", *lines]) if lines else ""


def overall(rows: Sequence[Row]) -> str:
    """Marks over all cases with 95 % intervals; hold-out, coverage, size of the sets, time."""
    lines = ["overall:"]
    for mark in (*MARKS, "both_in_sets"):
        hits = [bool(r[mark]) for r in rows if r.get(mark) is not None]
        if hits:
            lo, hi = interval(sum(hits), len(hits))
            lines.append(f"  {mark:<13} {np.mean(hits):.3f} ({lo:.3f} - {hi:.3f}) of {len(hits)}")
    chi2 = [r["holdout_chi2"] for r in rows if r.get("holdout_chi2") is not None]
    if chi2:
        good = np.mean(np.array(chi2) <= 1.1)
        lines.append(f"  hold-out χ²/N after: median {np.median(chi2):.3f}, <= 1.1 in {good:.2f}")
    for mark, text in (
        ("covered", "95 % intervals hold the true parameter"),
        ("set_size", "size of the set"),
    ):
        values = [float(r[mark]) for r in rows if r.get(mark) is not None]
        if values:
            lines.append(f"  {text}: {np.mean(values):.2f}")
    wall = [r["wall"] for r in rows]
    lines.append(f"  seconds a case: median {np.median(wall):.2f}, longest {max(wall):.2f}")
    return "\n".join(lines)
