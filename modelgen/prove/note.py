"""The scores as Markdown: `PROOF.md`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from modelgen.prove import scores, studies
from modelgen.prove.page import percent, tables
from modelgen.prove.pictures import METHODS
from modelgen.prove.scores import Row, Share


def note(
    rows: Sequence[Row], real: Sequence[Row], left: Sequence[Mapping[str, Any]], facts: Mapping[str, Any]
) -> str:
    """The note as text."""
    good = scores.usable(rows)
    deep = any(map(scores.has_depth, good))
    parts = [
        "# Proof: physics concealed in recordings, and found",
        f"Written by `{facts['command']} --markdown PROOF.md`. {len(good)} trials, {facts['drawn']}, "
        + ", ".join(f"{n} {v}" for n, v in facts["versions"].items())
        + f", code {facts['code']}, {facts['machine']}. "
        f"A diagnosis took {scores.seconds(good):.1f} s of one core (median).",
        "Each secret was sealed (its SHA-256 printed), and revealed after a process that was told nothing "
        f"but the case's folder had given its verdict. {_made(facts)} Intervals are exact 95 % ones. "
        + _unfinished(rows, facts),
        "## Scoreboard",
        _board(good),
        _aside(good),
        *(f"## By {t['title']}\n\n{_table(t['rows'])}" for t in tables(good)),
        "## Simpler methods on the same recordings",
        _baselines(good),
        *(("## Power: who notices that something is missing", _power(good)) if deep else ()),
        "## What was taken for what",
        _confused(good),
    ]
    if left:
        parts += ["## The MRE paper's Tab. 3, a frequency left out at a time", _left(left)]
    if real:
        parts += ["## Measured recordings", _real(real)]
    return "\n\n".join(p for p in parts if p) + "\n"


def _made(facts: Mapping[str, Any]) -> str:
    if facts["own"]:
        return "Recordings and secrets are somebody's own."
    return "Recordings are made by `modelgen.truths`, which shares no code with models, effects and kernels."


def _unfinished(rows: Sequence[Row], facts: Mapping[str, Any]) -> str:
    """What of the run is not in the scores."""
    parts = (
        (facts["wanted"] - len(rows), "not made yet"),
        (sum("hidden" in r for r in rows), "not drawn, as the base absorbs such an effect at any strength"),
        (sum("withheld" in r for r in rows), "whose secret is withheld"),
    )
    told = [f"{n} {words}" for n, words in parts if n > 0]
    foreign, failed = sum(bool(r.get("foreign")) for r in rows), sum(bool(r["error"]) for r in rows)
    watched = f"{foreign} of the diagnoses opened a file that was not theirs."
    watched += f" {failed} trials gave no verdict, which counts as a wrong one." if failed else ""
    return watched + (f" Not counted: {'; '.join(told)}." if told else "")


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
    cover, bins = scores.coverage(good), studies.calibration(good)
    made, settled = studies.proposals(good)
    told = "; ".join(f"{100 * b['stated']:.0f} %: {percent(b['right'])} of {b['right'].n}" for b in bins)
    proposed = (
        f" Where that name had equivalents, a further recording was proposed in {percent(made)} of {made.n}; "
        f"simulated and added, it resolved {percent(settled)} of {settled.n}."
    )
    return (
        f"95 % intervals of base parameters hold the true value in {percent(cover)} of {cover.n} (where the "
        f"law was found). Stated probability of the first name and how often it was right: {told}."
        + (proposed if made.n else "")
        + _missed(good)
        + _strangers(good)
        + _faint(good)
    )


def _missed(good: Sequence[Row]) -> str:
    missed, foreseen = studies.missed(good)
    if not missed:
        return ""
    return (
        f" Of {missed} hold-outs missed by χ² > {scores.HOLDOUT}, {foreseen} lie within twice the excess "
        "that the verdict had foreseen from what is uncertain of its parameters."
    )


def _strangers(good: Sequence[Row]) -> str:
    old, new, tied = studies.strangers(good)
    if not old.n + new.n:
        return ""
    return (
        f" Of {old.n + new.n} laws that no catalogue holds, {old.n} are of kinds that were in mind when the "
        f"diagnosis was written, or looked at since, and {old.hits} of these were called unknown; "
        f"{new.n} are of kinds that nobody had in mind, and {new.hits} of these. {tied} got a listed "
        "name that predicts the held-out recording as well as the true law does; they count as misses all "
        "the same."
    )


def _faint(good: Sequence[Row]) -> str:
    few = [r for r in good if r not in scores.weighed(good)]
    noticed = scores.share(map(scores.detected, few))
    if not noticed.n:
        return ""
    return f" Of {noticed.n} effects fainter than d² = 30, which no goal counts, {noticed.hits} were noticed."


def _table(rows: Sequence[Mapping[str, Any]]) -> str:
    head = ("", "trials", *(title for title, _ in scores.COLUMNS), "hold-out rms", "covered", "seconds")
    lines = []
    for r in rows:
        shares = [
            f"{percent(s)} ({100 * s.low:.0f}–{100 * s.high:.0f})" if s.n else "" for _, s in r["shares"]
        ]
        rms = f"{r['rms'][0]:.3g} → {r['rms'][1]:.3g}" if r["rms"] else ""
        cover = percent(r["covered"]) if r["covered"].n else ""
        lines.append((r["name"], str(r["n"]), *shares, rms, cover, f"{r['seconds']:.1f}"))
    return _grid(head, lines)


def _baselines(good: Sequence[Row]) -> str:
    found = studies.baselines(good)
    marks = list(found["modelgen"])
    rows = [
        (METHODS[n], *(f"{percent(m[k])} ({_interval(m[k])})" if m[k].n else "–" for k in marks))
        for n, m in found.items()
    ]
    return _grid(("", *marks), rows)


def _power(good: Sequence[Row]) -> str:
    curves = studies.power(good)
    head = ("d², about", "trials", *(METHODS[n] for n in curves))
    rows = [
        (f"{points[0]['d2']:.0f}", str(points[0]["found"].n), *(percent(p["found"]) for p in points))
        for points in zip(*curves.values(), strict=True)
    ]
    return _grid(head, rows)


def _confused(good: Sequence[Row]) -> str:
    """What was taken for what, most often first, and whether the verdict itself said that it can't tell."""
    found = studies.mixed_up(good)
    rows = [
        (c["concealed"], c["named"], str(c["n"]), str(c["said"]),
         _between(*c["d2"]) if c["d2"][1] else "",  # of somebody's own it isn't known
         ", ".join(c["noise"]), ", ".join(map(str, c["indices"])))
        for c in found
    ]  # fmt: skip
    tied = sum(c["said"] for c in found)
    says = (
        f"{sum(c['n'] for c in found)} first names were wrong; in {tied} of these the verdict named the "
        "right one as its equivalent: there these recordings tie, and a further one is proposed. The others "
        "are the diagnosis's own errors. The same command draws the same trials again."
    )
    head = ("concealed", "named first", "trials", "said to be a tie", "d²", "noise", "trial")
    return says + "\n\n" + _grid(head, rows) if rows else "Nothing was taken for anything else."


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


def _between(low: float, high: float) -> str:
    """A range, or the one number that it is."""
    return f"{low:.0f}" if round(low) == round(high) else f"{low:.0f}–{high:.0f}"
