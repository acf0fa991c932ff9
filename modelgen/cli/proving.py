"""`modelgen prove`."""

from __future__ import annotations

import json as jsons
import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from modelgen.cli.console import check_output, console, table
from modelgen.errors import InputError
from modelgen.prove import about, scores
from modelgen.prove.plan import plan
from modelgen.prove.run import CASES, TRIALS, Room, run
from modelgen.truths.secret import DOMAINS, NOISES

if TYPE_CHECKING:
    from rich.console import Console

Row = dict[str, Any]
QUICK = 12


@dataclass(frozen=True)
class Wish:
    """What was asked for on the command line."""

    trials: int
    seed: int
    jobs: int
    noises: tuple[str, ...]
    domains: tuple[str, ...]
    keep: Path
    limit: float
    real: Path | None
    html: Path | None
    json: Path | None
    markdown: Path | None

    @property
    def command(self) -> str:
        """The command that gives the same trials."""
        words = ["modelgen prove", f"--trials {self.trials}", f"--seed {self.seed}"]
        words += [f"--noise {','.join(self.noises)}"] if self.noises != NOISES else []
        words += [f"--domain {','.join(self.domains)}"] if self.domains != DOMAINS else []
        return " ".join(words)


def prove_command(
    trials: int, seed: int, jobs: int, html: Path | None, json: Path | None, markdown: Path | None,
    secret: Path | None, noise: str, domain: str, keep: Path, real: Path, quick: bool, limit: float,
) -> int:  # fmt: skip
    """The command's options as a wish. Returns the exit status."""
    if secret is not None:
        return prove_secret(secret, json, limit)
    wish = Wish(
        QUICK if quick else trials, seed, jobs or os.cpu_count() or 1, _listed(noise) or NOISES,
        _listed(domain) or DOMAINS, keep, limit, None if quick else real, html, json, markdown,
    )  # fmt: skip
    return prove(wish)


def _listed(text: str) -> tuple[str, ...]:
    return tuple(w.strip() for w in text.split(",") if w.strip())


def prove(wish: Wish) -> int:
    """Run the trials, print the scoreboard, write what was asked for. Returns the exit status."""
    if wish.trials < 1 or wish.jobs < 1:
        raise InputError(f"--trials {wish.trials}, --jobs {wish.jobs}: at least 1 is wanted")
    for path in (wish.html, wish.json, wish.markdown):
        check_output(path)
    tasks = plan(wish.trials, wish.seed, wish.noises, wish.domains)
    room = Room(wish.keep)
    room.open({"seed": wish.seed, "noise": wish.noises, "domain": wish.domains, "code": about.fingerprint()})
    to = console()
    status = 0
    with _progress(to, len(tasks), len(room.rows())) as (sealed, done):
        try:
            run(tasks, room, wish.jobs, wish.limit, sealed, done)
        except KeyboardInterrupt:
            to.print(
                f"interrupted; what is done is in {room.folder}/{TRIALS}, the same command goes on from there"
            )
            status = 130
    by_index = room.rows()
    rows = [by_index[t.index] for t in tasks if t.index in by_index]
    real = [] if status or wish.real is None else _real(wish.real, wish.limit, to)
    _show(rows, to, room)
    _write(wish, rows, real)
    return status or int(any(r["error"] for r in rows))


def prove_secret(path: Path, json: Path | None, limit: float) -> int:
    """One case with a secret of somebody's own."""
    from modelgen.fit.result import write_atomically
    from modelgen.prove.own import prove_own

    check_output(json)
    to = console()
    with tempfile.TemporaryDirectory(prefix="case-") as scratch:
        row = prove_own(path, Path(scratch), limit, lambda digest: to.print(f"sealed    {digest}"))
    to.print("diagnosed " + (row["error"] or row["verdict"]["summary"]))
    to.print("revealed  " + (" + ".join(row["effects"]) or "nothing is missing"))
    to.print("scored    " + _marks(row))
    if json is not None:
        write_atomically(json, jsons.dumps(row, indent=1, ensure_ascii=False) + "\n")
    return int(bool(row["error"]))


def _marks(row: Row) -> str:
    names = ("alarm", "named", "family", "in_set", "port", "both", "unknown", "misnamed")
    return (
        ", ".join(f"{n}: {'yes' if row[n] else 'no'}" for n in names if row.get(n) is not None)
        or "no verdict"
    )


@contextmanager
def _progress(
    to: Console, total: int, ready: int
) -> Iterator[tuple[Callable[[Row], None], Callable[[Row], None]]]:
    """sealed(row) prints a digest before the diagnosis, done(row) the secret after it; a bar on a
    terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    err = Console(stderr=True)
    columns = (TextColumn("proving"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(),
               TextColumn("{task.fields[right]} right of those"))  # fmt: skip
    with Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as bar:
        task = bar.add_task("", total=total, completed=min(ready, total), right=0)
        out = bar.console.print if err.is_terminal else to.print
        right = 0

        def sealed(row: Row) -> None:
            out(f"{row['index']:5d} sealed   {row['sha256']}", highlight=False)

        def done(row: Row) -> None:
            nonlocal right
            out(f"{row['index']:5d} revealed {_told(row)}", highlight=False)
            right += not wrong(row)
            bar.update(task, advance=1, right=right)

        yield sealed, done


def wrong(row: Row) -> bool:
    from modelgen.prove.run import missed

    return "hidden" not in row and missed(row)


def _told(row: Row) -> str:
    """One line on a trial."""
    if "hidden" in row:
        return f"nothing: the base would hide it whatever its strength ({row['hidden']})"
    law = f" ({row['variant']})" if row["variant"] else ""
    secret = (" + ".join(row["effects"]) or "nothing") + law
    first = row["error"] or " + ".join(e["id"] for e in row["verdict"]["effects"]) or "nothing"
    mark = "✗" if wrong(row) else "✓"
    where = f"{row['domain']}, {row['noise']}, rms {row['ratio']:.2f} × noise"
    return f"{mark} {secret} → {first}   [dim]{where}, {row['wall']:.1f} s[/dim]"


def _show(rows: Sequence[Row], to: Console, room: Room) -> None:
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
    failed = [r for r in rows if r["error"]]
    hidden = [r for r in rows if "hidden" in r]
    if good:
        took = f"{scores.seconds(good):.1f} s of one core, {scores.seconds(good, 'wall'):.1f} s passed"
        to.print(f"a diagnosis took {took} (medians)")
    if failed or hidden:
        to.print(f"{len(failed)} without a verdict, {len(hidden)} not drawn, as the base absorbs them")
    to.print(f"trials are in {room.folder}/{TRIALS}, missed cases in {room.folder}/{CASES}")


def _real(data: Path, limit: float, to: Console) -> list[Row]:
    """The measured recordings, one after another."""
    from modelgen.prove import real
    from modelgen.prove.diagnoser import Diagnoser

    there, missing = real.folders(data)
    found = []
    with Diagnoser(limit) as diagnoser:
        for folder in there:
            found.append(real.diagnose_real(folder, diagnoser))
            ids = " + ".join(e["id"] for e in found[-1]["effects"]) or found[-1]["error"] or "nothing missing"
            to.print(f"measured  {folder.name}: {ids}   ({found[-1]['seconds']:.1f} s)", highlight=False)
    if missing:
        to.print(f"skipped, not in {data}: {', '.join(missing)}")
    return found


def _write(wish: Wish, rows: Sequence[Row], real: Sequence[Row]) -> None:
    from modelgen.fit.result import write_atomically
    from modelgen.prove.leave_out import leave_one_out
    from modelgen.prove.real import EXAMPLE

    if not (wish.html or wish.json or wish.markdown):
        return
    facts = {"command": wish.command, "seed": wish.seed, "code": about.fingerprint(),
             "versions": about.versions(), "machine": about.machine()}  # fmt: skip
    left = [vars(x) for x in leave_one_out(EXAMPLE)] if wish.real is not None else []
    if wish.json:
        whole = scores.to_json(rows, facts) | {"measured": list(real), "leave_one_out": left}
        write_atomically(wish.json, jsons.dumps(whole, indent=1, ensure_ascii=False) + "\n")
    if wish.html:
        from modelgen.prove.page import page

        write_atomically(wish.html, page(rows, real, left, facts))
    if wish.markdown:
        from modelgen.prove.note import note

        write_atomically(wish.markdown, note(rows, real, left, facts))
