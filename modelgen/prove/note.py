"""The scores as Markdown: `PROOF.md`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from modelgen.prove import scores
from modelgen.prove.page import percent, tables
from modelgen.prove.pictures import METHODS
from modelgen.prove.scores import Row, Share


def note(
    rows: Sequence[Row], real: Sequence[Row], left: Sequence[Mapping[str, Any]], facts: Mapping[str, Any]
) -> str:
    """The note as text."""
    good = scores.usable(rows)
    parts = [
        "# Proof: physics concealed in recordings, and found",
        f"Written by `{facts['command']} --markdown PROOF.md`. {len(good)} trials, seed {facts['seed']}, "
        + ", ".join(f"{n} {v}" for n, v in facts["versions"].items())
        + f", code {facts['code']}, {facts['machine']}. "
        f"A diagnosis took {scores.seconds(good):.1f} s of one core (median).",
        "Each secret was drawn, sealed (its SHA-256 printed), and revealed after a process that was told "
        "nothing but the case's folder had given its verdict. Recordings are made by `modelgen.truths`, "
        "which shares no code with the models, effects and kernels. Intervals are exact 95 % ones.",
        "## Scoreboard",
        _board(good),
        _aside(good),
        *(f"## By {t['title']}\n\n{_table(t['rows'])}" for t in tables(good)),
        "## Simpler methods on the same recordings",
        _baselines(good),
        "## What was taken for what",
        _confused(good),
    ]
    if left:
        parts += ["## The MRE paper's Tab. 3, a frequency left out at a time", _left(left)]
    if real:
        parts += ["## Measured recordings", _real(real)]
    return "\n\n".join(p for p in parts if p) + "\n"


def _grid(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(r) + " |" for r in rows)])


def _interval(s: Share) -> str:
    return f"{100 * s.low:.0f}–{100 * s.high:.0f} %"


def _board(good: Sequence[Row]) -> str:
    rows = [
        (
            line["goal"].says,
            f"{100 * s.value:.1f} %",
            _interval(s),
            f"{s.hits} / {s.n}",
            line["goal"].wanted,
            "met" if line["met"] else "**missed**",
        )
        for line in scores.board(good)
        if (s := line["share"]).n
    ]
    return _grid(("", "share", "95 % interval", "of", "goal", ""), rows)


def _aside(good: Sequence[Row]) -> str:
    cover, bins = scores.coverage(good), scores.calibration(good)
    told = "; ".join(f"{100 * b['stated']:.0f} %: {percent(b['right'])} of {b['right'].n}" for b in bins)
    return (
        f"95 % intervals of base parameters hold the true value in {percent(cover)} of {cover.n} (where the "
        f"law was "
        f"found). Stated probability of the first name and how often it was right: {told}."
    )


def _table(rows: Sequence[Mapping[str, Any]]) -> str:
    head = ("", "trials", *(title for title, _ in scores.COLUMNS), "seconds")
    lines = []
    for r in rows:
        shares = [
            f"{percent(s)} ({100 * s.low:.0f}–{100 * s.high:.0f})" if s.n else "" for _, s in r["shares"]
        ]
        lines.append((r["name"], str(r["n"]), *shares, f"{r['seconds']:.1f}"))
    return _grid(head, lines)


def _baselines(good: Sequence[Row]) -> str:
    found = scores.baselines(good)
    marks = list(found["modelgen"])
    rows = [
        (METHODS[n], *(f"{percent(m[k])} ({_interval(m[k])})" if m[k].n else "–" for k in marks))
        for n, m in found.items()
    ]
    return _grid(("", *marks), rows)


def _confused(good: Sequence[Row]) -> str:
    """What was taken for what at least twice, most often first."""
    wrong = [(n, t, w) for (t, w), n in scores.confusion(good).items() if t != w]
    wrong = [x for x in wrong if not (x[1].startswith("novel:") and x[2] == "unknown")]
    lines = [f"- {n} × {t} → {w}" for n, t, w in sorted(wrong, reverse=True) if n > 1]
    return "\n".join([*lines, f"- once each: {sum(1 for x in wrong if x[0] == 1)} other confusions"])


def _left(left: Sequence[Mapping[str, Any]]) -> str:
    rows = [
        (t["name"], f"{100 * t['before']:.1f} %", f"{100 * t['after']:.2f} %", f"{t['exponent']:.3f}")
        for t in left
    ]
    return _grid(("sample", "spring and dashpot", "springpot", "its exponent"), rows)


def _real(real: Sequence[Row]) -> str:
    rows = []
    for r in real:
        found = "; ".join(
            e["id"] + (f" (or {', '.join(e['equivalents'])})" if e["equivalents"] else "")
            for e in r["effects"]
        )
        fit = r["fit"] or {"before": {}, "after": {}}
        rms = [fit[k].get("fit_rms_over_noise") or float("nan") for k in ("before", "after")]
        rows.append(
            (r["title"], r["error"] or found or "nothing", f"{rms[0]:.3g} → {rms[1]:.3g}", r["literature"],
             r["agrees"], f"{r['seconds']:.1f}")
        )  # fmt: skip
    return _grid(("device", "found", "rms over noise", "literature", "of which found", "seconds"), rows)
