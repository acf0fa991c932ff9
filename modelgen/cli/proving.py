"""`modelgen prove`."""

from __future__ import annotations

import json as jsons
import os
import signal
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any

from modelgen.cli.console import check_output, check_outputs, check_page, console, spare
from modelgen.cli.scoreboard import Row, marks, progress, show_board
from modelgen.errors import InputError
from modelgen.prove import about, studies
from modelgen.prove.own import Own, own_trials
from modelgen.prove.plan import Task, plan
from modelgen.prove.run import MEASURED, TRIALS, Room, run
from modelgen.truths.secret import DOMAINS, NOISES

if TYPE_CHECKING:
    from rich.console import Console

QUICK = 12


@dataclass(frozen=True)
class Wish:
    """What was asked for on the command line. No trials: what the folder `keep` holds."""

    trials: int
    seed: int
    jobs: int
    noises: tuple[str, ...]
    domains: tuple[str, ...]
    keep: Path
    limit: float
    real: Path | None
    secret: Path | None
    html: Path | None
    json: Path | None
    markdown: Path | None

    @property
    def command(self) -> str:
        """The command that gives the same trials."""
        if self.secret is not None:
            return f"modelgen prove --secret {self.secret}"
        words = ["modelgen prove", f"--trials {self.trials}", f"--seed {self.seed}"]
        words += [f"--noise {','.join(self.noises)}"] if self.noises != NOISES else []
        words += [f"--domain {','.join(self.domains)}"] if self.domains != DOMAINS else []
        return " ".join(words)

    def like(self, room: Room) -> Wish:
        """The wish that the trials of a room were made by."""
        told, count = room.settings(), max(room.rows(), default=-1) + 1
        if "seed" not in told:
            return replace(self, secret=Path("FOLDER"))
        noises, domains = tuple(told["noise"]), tuple(told["domain"])
        return replace(self, trials=count, seed=told["seed"], noises=noises, domains=domains)

    @property
    def settings(self) -> dict[str, Any]:
        """What trials in one folder have in common."""
        drawn = {"seed": self.seed, "noise": self.noises, "domain": self.domains}
        return ({"secret": "own"} if self.secret else drawn) | {"code": about.fingerprint()}


MEASURED_CASES = Path("../shared/data")
"""Where measured cases are looked for that nobody names."""


def prove_command(
    trials: int, seed: int, jobs: int, html: Path | None, json: Path | None, markdown: Path | None,
    secret: Path | None, noise: str, domain: str, keep: Path, real: Path | None, quick: bool, limit: float,
) -> int:  # fmt: skip
    """The command's options as a wish. Returns the exit status."""
    if trials < 0 or jobs < 0:
        raise InputError(f"--trials {trials}, --jobs {jobs}: no negative number is wanted")
    if not limit > 0:
        raise InputError(f"--limit {limit:g}: a positive number of seconds is wanted")
    given = _given()
    if secret is not None:
        _check_useful(secret, given)
        if not secret.is_dir():
            return prove_secret(secret, json, limit)
    if real is not None and not real.is_dir():
        raise InputError(f"--real {real}: no such folder, wanted one with a folder for each measured case")
    measured = None if secret is not None else real or (None if quick else MEASURED_CASES)
    trials = QUICK if quick and "trials" not in given else trials
    wish = Wish(
        trials, seed, jobs or os.cpu_count() or 1, _listed(noise) or NOISES,
        _listed(domain) or DOMAINS, keep if secret is None else keep / "own", limit, measured, secret,
        html, json, markdown,
    )  # fmt: skip
    return prove(wish)


FOR_DRAWN = ("trials", "seed", "noise", "domain", "real", "quick")
"""Options that say which secrets are drawn, and nothing of those that are given."""
FOR_MANY = ("html", "markdown", "keep", "jobs")
"""Options that say nothing of one secret's file."""


def _check_useful(secret: Path, given: set[str]) -> None:
    """Raises InputError where an option that was `given` would do nothing."""
    kind = "folder" if secret.is_dir() else "file"
    options = FOR_DRAWN if secret.is_dir() else (*FOR_MANY, *FOR_DRAWN)
    if useless := [f"--{name}" for name in options if name in given]:
        why, how = "whose cases are diagnosed and scored as they are", "leave the option out"
        if kind == "file":
            why = "whose one case is diagnosed and shown"
            how = "lay it into a folder, or leave the option out"
        raise InputError(f"--secret {secret} {' '.join(useless)}: of no effect with a {kind}, {why}; {how}")


def _given() -> set[str]:
    """Names of the options that stand on the command line."""
    from typer import Context

    # Typer brings a Click of its own from some version on
    home = Context.__mro__[1].__module__.rpartition(".")[0]
    context = import_module(f"{home}.globals").get_current_context(silent=True)
    sources = {n: context.get_parameter_source(n) for n in context.params} if context else {}
    return {n for n, source in sources.items() if source is not None and source.name == "COMMANDLINE"}


def _listed(text: str) -> tuple[str, ...]:
    return tuple(w.strip() for w in text.split(",") if w.strip())


def prove(wish: Wish) -> int:
    """Run the trials, print the scoreboard, write what was asked for. Returns the exit status."""
    check_outputs(wish.html, wish.json, wish.markdown)
    check_page(wish.html, "--html")
    tasks: Sequence[Task | Own]
    tasks = (
        plan(wish.trials, wish.seed, wish.noises, wish.domains)
        if not wish.secret
        else own_trials(wish.secret)
    )
    room, to = Room(wish.keep), console(lasting=True)
    if tasks:
        room.open(wish.settings)
    elif not room.rows():
        raise InputError(f"--trials 0 shows what --keep holds, and {room.folder}/{TRIALS} holds no trial")
    else:
        wish = wish.like(room)
    status = _work(wish, tasks, room, to)
    by_index = room.rows()
    rows = [by_index[t.index] for t in tasks if t.index in by_index] or list(by_index.values())
    real = list(room.measured().values()) if wish.real is not None else []
    show_board(rows, to, room)
    _write(wish, rows, real, room)
    return status or int(any(r["error"] for r in rows))


def _work(wish: Wish, tasks: Sequence[Task | Own], room: Room, to: Console) -> int:
    """Diagnose the measured recordings, then make the trials; 130 where that was interrupted."""
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)  # to be ended is to be interrupted
    ready = room.rows()
    done_of = sum(t.index in ready for t in tasks)
    try:
        if tasks and wish.real is not None:
            _measure(wish.real, room, wish.jobs, wish.limit, to)
        with progress(to, len(tasks), done_of) as (sealed, done):
            run(tasks, room, wish.jobs, wish.limit, sealed, done)
    except KeyboardInterrupt:
        to.print(
            f"interrupted; what is done is in {room.folder}/{TRIALS}, the same command goes on from there"
        )
        return 130
    finally:
        signal.signal(signal.SIGTERM, before)
    return 0


def prove_secret(path: Path, json: Path | None, limit: float) -> int:
    """One case with a secret of somebody's own."""
    from modelgen.files import write_atomically

    check_output(json)
    spare((path,), json)
    to = console(lasting=True)
    with tempfile.TemporaryDirectory(prefix="own-") as scratch:
        (row,) = run(
            own_trials(path), Room(Path(scratch)), 1, limit,
            lambda row: to.print(f"sealed    {row['sha256']}", soft_wrap=True), lambda row: None,
        )  # fmt: skip
    to.print("diagnosed " + (row["error"] or row["verdict"]["summary"]), soft_wrap=True)
    if "withheld" not in row:
        to.print("revealed  " + (" + ".join(row["effects"]) or "nothing is missing"))
        to.print("scored    " + marks(row))
    if json is not None:
        write_atomically(json, jsons.dumps(row, indent=1, ensure_ascii=False) + "\n")
    return int(bool(row["error"]))


def _measure(data: Path, room: Room, jobs: int, limit: float, to: Console) -> None:
    """Diagnose the measured recordings, `jobs` at a time, but those that are done."""
    from modelgen.prove import real
    from modelgen.prove.diagnoser import Diagnoser

    there, missing = real.folders(data)
    done = room.measured()
    todo = [folder for folder in there if folder.name not in done]
    with ExitStack() as stack:
        free: SimpleQueue[Diagnoser] = SimpleQueue()
        for _ in range(min(jobs, len(todo))):
            free.put(stack.enter_context(Diagnoser(limit)))

        def diagnosed(folder: Path) -> Row:
            diagnoser = free.get()
            try:
                return real.diagnose_real(folder, diagnoser)
            finally:
                free.put(diagnoser)

        pool = ThreadPoolExecutor(jobs)
        stack.callback(lambda: pool.shutdown(wait=False, cancel_futures=True))
        for row in pool.map(diagnosed, todo):
            room.add(MEASURED, jsons.dumps(row, ensure_ascii=False))
            ids = " + ".join(e["id"] for e in row["effects"]) or row["error"] or "nothing missing"
            to.print(
                f"measured  {row['name']}: {ids}   ({row['seconds']:.1f} s)", highlight=False, soft_wrap=True
            )
    if missing:
        to.print(f"skipped, not in {data}: {', '.join(missing)}", soft_wrap=True)


def _write(wish: Wish, rows: Sequence[Row], real: Sequence[Row], room: Room) -> None:
    """The page, the scores and the note, of whatever is done."""
    from modelgen.files import write_atomically
    from modelgen.prove.leave_out import leave_one_out
    from modelgen.prove.real import EXAMPLE

    if not (wish.html or wish.json or wish.markdown):
        return
    own = wish.secret is not None
    facts = about.facts() | {
        "command": wish.command,
        "seed": wish.seed,
        "drawn": "cases of somebody's own" if own else f"seed {wish.seed}",
        "wanted": len(rows) if own else wish.trials,
        "own": own,
        "code": room.settings().get("code", ""),
    }
    left = [vars(x) for x in leave_one_out(EXAMPLE)] if wish.real is not None else []
    if wish.json:
        whole = studies.to_json(rows, facts) | {"measured": list(real), "leave_one_out": left}
        write_atomically(wish.json, jsons.dumps(whole, indent=1, ensure_ascii=False) + "\n")
    if wish.html:
        from modelgen.prove.page import page

        write_atomically(wish.html, page(rows, real, left, facts))
    if wish.markdown:
        from modelgen.prove.note import note

        write_atomically(wish.markdown, note(rows, real, left, facts))
