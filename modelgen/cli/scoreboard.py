"""What `modelgen prove` shows in the terminal: seals, revealed secrets, the scoreboard."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from modelgen.prove import scores
from modelgen.prove.run import CASES, TRIALS, Room, missed
from modelgen.report.table import table

if TYPE_CHECKING:
    from rich.console import Console

Row = dict[str, Any]


def marks(row: Row) -> str:
    """How a verdict scores, in words."""
    names = ("alarm", "named", "family", "in_set", "port", "both", "unknown", "misnamed")
    return (
        ", ".join(f"{n}: {'yes' if row[n] else 'no'}" for n in names if row.get(n) is not None)
        or "no verdict"
    )


@contextmanager
def progress(
    to: Console, total: int, ready: int
) -> Iterator[tuple[Callable[[Row], None], Callable[[Row], None]]]:
    """sealed(row) prints a digest before the diagnosis, done(row) the secret after it; a bar on a
    terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    err = Console(stderr=True, markup=False)
    columns = (TextColumn("proving"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(),
               TextColumn("{task.fields[right]} right of those"))  # fmt: skip
    with Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as bar:
        task = bar.add_task("", total=total, completed=min(ready, total), right=0)
        out = bar.console.print if err.is_terminal else to.print
        right = 0

        def sealed(row: Row) -> None:
            out(f"{_name(row)} sealed   {row['sha256']}", highlight=False, soft_wrap=True)

        def done(row: Row) -> None:
            nonlocal right
            out(f"{_name(row)} {_told(row)}", highlight=False, soft_wrap=True)
            right += "hidden" not in row and "withheld" not in row and not missed(row)
            bar.update(task, advance=1, right=right)

        yield sealed, done


def _name(row: Row) -> str:
    return str(row.get("name") or f"{row['index']:5d}")


def _told(row: Row) -> str:
    """One line on a trial."""
    if "hidden" in row:
        return f"nothing: the base would hide it whatever its strength ({row['hidden']})"
    first = row["error"] or " + ".join(e["id"] for e in row["verdict"]["effects"]) or "nothing"
    if "withheld" in row:
        return f"diagnosed {first}; the secret is withheld"
    law = f" ({row['variant']})" if row["variant"] else ""
    secret = (" + ".join(row["effects"]) or "nothing") + law
    mark = "✗" if missed(row) else "✓"
    where = "" if "name" in row else f"{row['domain']}, {row['noise']}, rms {row['ratio']:.2f} × noise, "
    return f"revealed {mark} {secret} → {first}   {where}{row['wall']:.1f} s"


def show_board(rows: Sequence[Row], to: Console, room: Room) -> None:
    """The scoreboard in the terminal."""
    good = scores.usable(rows)
    shown = table(f"{len(good)} concealed trials", "share", "95 % interval", "of", "goal", "")
    for line in scores.board(good):
        s = line["share"]
        if s.n:
            cells = (f"{100 * s.value:.1f} %", f"{100 * s.low:.0f}–{100 * s.high:.0f} %", str(s.n))
            shown.add_row(line["goal"].says, *cells, line["goal"].wanted, "✓" if line["met"] else "✗")
    to.print()
    to.print(shown)
    cover = scores.coverage(good)
    if cover.n:
        to.print(
            f"95 % intervals of parameters hold the true value in {100 * cover.value:.0f} % of {cover.n}"
        )
    if good:
        took = f"{scores.seconds(good):.1f} s of one core, {scores.seconds(good, 'wall'):.1f} s passed"
        to.print(f"a diagnosis took {took} (medians)")
    failed, hidden = sum(bool(r["error"]) for r in rows), sum("hidden" in r for r in rows)
    if failed or hidden:
        to.print(f"{failed} without a verdict, {hidden} not drawn, as the base absorbs them")
    if withheld := sum("withheld" in r for r in rows):
        to.print(f"{withheld} diagnosed, to be scored when secret.json is laid beside the case")
    to.print(f"trials are in {room.folder}/{TRIALS}, missed cases in {room.folder}/{CASES}", soft_wrap=True)
