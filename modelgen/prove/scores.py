"""How often the verdicts were right: shares with exact (Clopper-Pearson) 95 % intervals, over groups of
trials."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from modelgen.truths.secret import FORESEEN

Row = Mapping[str, Any]
Mark = Callable[[Row], "bool | None"]
RATIOS = (
    (1.0, 1.2, "in the noise"),
    (1.2, 2.1, "1.5"),
    (2.1, 4.2, "3"),
    (4.2, 11.0, "6"),
    (11.0, np.inf, "20"),
)
FAINT = "d² < 30"
POWER_FROM = 40.0
HOLDOUT = 1.05
FAINT_BELOW = 29.5  # a drawn d² is met to 1 %


@dataclass(frozen=True)
class Share:
    """hits of n, and the 95 % interval of what the share would be of many."""

    hits: int
    n: int
    low: float
    high: float

    @property
    def value(self) -> float:
        return self.hits / self.n if self.n else float("nan")


def share(marks: Iterable[bool | None]) -> Share:
    """The share of true marks among those that apply."""
    from scipy.stats import binomtest

    found = [bool(m) for m in marks if m is not None]
    if not found:
        return Share(0, 0, 0.0, 1.0)
    interval = binomtest(sum(found), len(found)).proportion_ci(0.95, "exact")
    return Share(sum(found), len(found), float(interval.low), float(interval.high))


@dataclass(frozen=True)
class Goal:
    """One line of the scoreboard: `low` to `high` is what the share should lie in."""

    key: str
    says: str
    mark: Mark
    low: float = 0.0
    high: float = 1.0

    def met(self, s: Share) -> bool:
        return bool(s.n) and self.low <= s.value <= self.high

    @property
    def wanted(self) -> str:
        if self.low > 0 and self.high < 1:
            return f"{100 * self.low:.0f}–{100 * self.high:.0f} %"
        return f"≥ {100 * self.low:.0f} %" if self.low > 0 else f"≤ {100 * self.high:.0f} %"


def depth(row: Row) -> float:
    """The smallest d² that a concealed effect leaves (of a pair: the other one there, whatever its form)."""
    return min((v for k, v in row["d2"].items() if k != "all"), default=0.0)


def detected(row: Row) -> bool | None:
    """Whether something was found missing where something is."""
    return bool(row["first"]) if row["effects"] else None


def found_out(row: Row) -> bool | None:
    """Whether something was noticed that is deep enough for a goal."""
    return detected(row) if depth(row) >= POWER_FROM else None


def tells(row: Row) -> bool:
    """Whether the verdict says that the data tell the first effect from all others. No verdict is no
    excuse."""
    return bool(row["error"]) or row.get("set_size") == 1


def tells_all(row: Row) -> bool:
    """Whether the verdict says so of each effect that it names; likewise."""
    effects = row["verdict"]["effects"]
    return bool(row["error"] or effects) and not any(e["equivalents"] for e in effects)


def holdout(row: Row, method: str = "diagnosis") -> bool | None:
    """Whether the hold-out is met as the true law would; None where no catalogue holds that law."""
    if row["kind"] == "novel" or not has_depth(row):
        return None
    ratio = row["rivals"].get(method, {}).get("holdout")
    missing = False if row["error"] else None
    return missing if ratio is None else bool(ratio <= HOLDOUT)


def has_depth(row: Row) -> bool:
    """Whether the best base is known, as it is of all cases but somebody's own."""
    return row["ratio"] is not None


def in_mind(row: Row) -> bool:
    """Whether physics that no catalogue holds is of the kinds in mind, or looked at since."""
    return set(row["effects"]) <= set(FORESEEN)


def of_kinds(key: str, old: bool) -> Mark:
    """The mark of physics that no catalogue holds, of the kinds in mind or of the others. None is left out
    because the data might not tell: there is no measure of that but the verdict's own."""
    return lambda row: row.get(key) if in_mind(row) == old else None


def predicts(row: Row) -> bool:
    """Whether the verdict's model predicts a recording that no fit has seen as well as the true law does."""
    ratio = row["rivals"].get("diagnosis", {}).get("holdout")
    return ratio is not None and bool(ratio <= HOLDOUT)


def superfluous(row: Row) -> bool | None:
    """Whether a verdict on listed effects claims more of them than there are."""
    return row["extra"] > 0 if row.get("named") is not None and row["first"] else None


def resolved(row: Row) -> bool | None:
    followed = row.get("followed")
    return bool(followed["resolved"]) if followed else None


def claim(row: Row) -> tuple[float, bool] | None:
    """The stated probability of the first claim and whether that is right: a listed name, or "unknown" for
    what no catalogue holds; never where nothing is missing. None where nothing is claimed."""
    if row.get("claimed") is None:
        return None
    return row["claimed"], bool(row.get("unknown") if row.get("named") is None else row["named"])


def _nine_in_ten(row: Row) -> bool | None:
    stated = claim(row)
    return stated[1] if stated and 0.85 <= stated[0] < 0.95 else None


GOALS = (
    Goal("false alarm", "false alarm where nothing is missing", lambda r: r.get("alarm"), high=0.01),
    Goal("power", "something is missing: found out (d² ≥ 40)", found_out, low=0.95),
    Goal("port", "its port is right", lambda r: r.get("port"), low=0.95),
    Goal("named, told", "first name right, where the verdict says that the data tell",
         lambda r: r.get("named") if tells(r) else None, low=0.97),
    Goal("family", "family right at first try", lambda r: r.get("family"), low=0.95),
    Goal("in set", "right one within the stated equivalents", lambda r: r.get("in_set"), low=0.98),
    Goal("both", "both families of a pair named", lambda r: r.get("both"), low=0.88),
    Goal("both, told", "both families of a pair named, where the verdict says that the data tell both",
         lambda r: r["both"] if r.get("both") is not None and tells_all(r) else None, low=0.88),
    Goal("unknown", "physics that no catalogue holds, of kinds in mind, or looked at since: "
         "called unknown", of_kinds("unknown", True), low=0.90),
    Goal("misnamed", "… given a wrong name", of_kinds("misnamed", True), high=0.03),
    Goal("unknown, new", "physics that no catalogue holds, of kinds that nobody had in mind: called unknown",
         of_kinds("unknown", False), low=0.90),
    Goal("misnamed, new", "… given a wrong name", of_kinds("misnamed", False), high=0.03),
    Goal("experiment", "the one proposed experiment resolves what was ambiguous", resolved, low=0.80),
    Goal("nine in ten", "claims of 85 to 95 % are right", _nine_in_ten, low=0.85, high=0.95),
    Goal("seconds", "a diagnosis takes ≤ 3 s of one core (at least every other)",
         lambda r: not r["error"] and r["cpu"] <= 3.0, low=0.5),
    Goal("hold-out", f"hold-out χ² after, over the true law's, ≤ {HOLDOUT}", holdout, low=0.90),
)  # fmt: skip
COLUMNS: tuple[tuple[str, Mark], ...] = (
    ("false alarm", lambda r: r.get("alarm")),
    ("found", detected),
    ("first name", lambda r: r.get("named")),
    ("family", lambda r: r.get("family")),
    ("in set", lambda r: r.get("in_set")),
    ("port", lambda r: r.get("port")),
    ("both of pair", lambda r: r.get("both")),
    ("both in sets", lambda r: r.get("both_in_sets")),
    ("unknown", lambda r: r.get("unknown")),
    ("misnamed", lambda r: r.get("misnamed")),
    ("one too many", superfluous),
    ("hold-out", holdout),
)


def usable(rows: Iterable[Row]) -> list[Row]:
    """Trials that were drawn and are revealed. One without a verdict is wrong in all that applies to it."""
    return [_failed(r) if r["error"] else r for r in rows if "hidden" not in r and "withheld" not in r]


def _failed(row: Row) -> Row:
    """A trial without a verdict, with the marks of a wrong one; what was killed has taken all its time."""
    wrong: dict[str, Any] = {"alarm": True}
    if row["kind"] == "novel":
        wrong = {"unknown": False, "misnamed": True}
    elif row["effects"]:
        wrong = dict.fromkeys(("named", "family", "in_set", "port"), False)
        wrong |= {"both": False, "both_in_sets": False} if len(row["effects"]) > 1 else {}
    nothing = {"first": "", "extra": 0, "verdict": {"summary": row["error"], "effects": []}, "rivals": {}}
    return {**row, **nothing, **wrong, "cpu": max(row["cpu"], row["wall"])}


def weighed(rows: Iterable[Row]) -> list[Row]:
    """Those that a goal speaks of: what is concealed isn't fainter than d² = 30."""
    return [r for r in rows if not r["d2"] or not r["effects"] or depth(r) >= FAINT_BELOW]


def grouped(
    rows: Sequence[Row], key: Callable[[Row], str], order: Sequence[str] = ()
) -> dict[str, list[Row]]:
    """Rows by group, in the given order, then by name."""
    names = {key(r) for r in rows}
    ranked = [n for n in order if n in names] + sorted(names - set(order))
    return {name: [r for r in rows if key(r) == name] for name in ranked}


def by_depth(row: Row) -> str:
    """The rms ratio of a trial that has one, as the nearest of 1.5, 3, 6, 20, or "in the noise"."""
    if not row["effects"]:
        return "nothing missing"
    if row["d2"] and depth(row) < FAINT_BELOW:
        return FAINT
    return next(name for low, high, name in RATIOS if low <= row["ratio"] < high)


def effect_of(row: Row) -> str:
    """What is concealed, as one row of the confusion matrix."""
    return row["effects"][0] if row["effects"] else "nothing"


def coverage(rows: Sequence[Row]) -> Share:
    """95 % intervals of base parameters that hold the true value, where the law was found."""
    marks: list[bool] = []
    for r in rows:
        if r.get("covered") is not None and (r.get("named") or r.get("alarm") is False):
            hits = round(r["covered"] * r["parameters"])
            marks += [True] * hits + [False] * (r["parameters"] - hits)
    return share(marks)


def holdout_rms(rows: Sequence[Row]) -> tuple[float, float] | None:
    """Median rms of the hold-out over the true law's, of the fitted base and of the diagnosis' model."""
    told = [r["rivals"].get("diagnosis", {}) for r in rows]
    pairs = [(d["before"], d["holdout"]) for d in told if d.get("before") and d.get("holdout")]
    if not pairs:
        return None
    before, after = np.sqrt(np.median(np.array(pairs), axis=0))
    return float(before), float(after)


def board(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """The scoreboard: each goal with its share."""
    rows = weighed(rows)
    return [{"goal": g, "share": (s := share(map(g.mark, rows))), "met": g.met(s)} for g in GOALS]


def table(rows: Sequence[Row], key: Callable[[Row], str], order: Sequence[str] = ()) -> list[dict[str, Any]]:
    """One line a group: its trials, the share of each mark, median seconds, coverage, hold-out."""
    return [
        {"name": name, "n": len(group), "seconds": seconds(group)}
        | {"shares": [(title, share(map(mark, group))) for title, mark in COLUMNS]}
        | {"covered": coverage(group), "rms": holdout_rms(group)}
        for name, group in grouped(rows, key, order).items()
    ]


def seconds(rows: Sequence[Row], clock: str = "cpu") -> float:
    """Median seconds of a diagnosis, of one core's time or ("wall") that passed."""
    return float(np.median([r[clock] for r in rows])) if rows else float("nan")
