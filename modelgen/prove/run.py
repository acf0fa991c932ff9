"""The trials: drawn, sealed, diagnosed elsewhere, revealed, and written down one by one."""

from __future__ import annotations

import json
import os
import queue
import shutil
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from modelgen.errors import InputError
from modelgen.files import write_atomically
from modelgen.prove.diagnoser import ONE_THREAD, Answer, Diagnoser
from modelgen.prove.followup import follow_up
from modelgen.prove.keeper import Row, Sealed, conceal, reveal
from modelgen.prove.own import Own
from modelgen.prove.plan import Task

TRIALS, SEALS, CASES, MEASURED = "trials.jsonl", "sealed.txt", "cases", "measured.jsonl"
Show = Callable[[Row], None]


@dataclass(frozen=True)
class Room:
    """Where a run keeps its rows (`trials.jsonl`), its digests (`sealed.txt`), what it found in measured
    recordings, and the cases that it missed or whose secret is withheld."""

    folder: Path

    def rows(self) -> dict[int, Row]:
        """Trials that are done, by index; a line that was cut off is done again."""
        return {row["index"]: row for row in self._lines(TRIALS, "index")}

    def settings(self) -> dict[str, Any]:
        """What its trials were made with; {} where there are none, or nothing that can be read."""
        try:
            return dict(json.loads((self.folder / "settings.json").read_text(encoding="utf-8")))
        except (OSError, ValueError, TypeError):
            return {}

    def measured(self) -> dict[str, Row]:
        """What was found in measured recordings, by name."""
        return {row["name"]: row for row in self._lines(MEASURED, "name")}

    def case(self, index: int) -> Path:
        """Where a trial's folder is kept."""
        return self.folder / CASES / f"{index:05d}"

    def _lines(self, name: str, key: str) -> Iterator[Row]:
        """Rows that have a `key`; what a line that was cut off left of one is passed over."""
        path = self.folder / name
        text = path.read_text(encoding="utf-8", errors="replace") if path.exists() else ""
        for line in text.split("\n"):  # and not where a text within a row has a line separator
            try:
                row = json.loads(line)
            except json.JSONDecodeError:
                continue
            if isinstance(row, dict) and key in row:
                yield row

    def open(self, settings: Mapping[str, Any]) -> None:
        """Make the folder, or see that what is in it was run with the same settings.

        Raises InputError if it wasn't, or where no folder can be made; ToolError where no file can.
        """
        path, text = self.folder / "settings.json", json.dumps(settings)
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as why:
            raise InputError(f"--keep {self.folder}: no folder to write in: {why.strerror}") from None
        if path.exists() and _read_settings(path) != json.loads(text):
            raise InputError(
                f"{self.folder}: holds trials of another seed, noise or version; "
                "give another --keep, or remove it (--trials 0 shows what it holds)"
            )
        write_atomically(path, text)

    def add(self, name: str, line: str) -> None:
        """Append a line; it begins anew where the last one was cut off."""
        with open(self.folder / name, "a+b") as file:
            if file.seek(0, os.SEEK_END):
                file.seek(-1, os.SEEK_END)
                line = line if file.read(1) == b"\n" else "\n" + line
            file.write(line.encode() + b"\n")


def _read_settings(path: Path) -> Any:
    """What the trials of a folder were made with. Raises InputError where that can't be read."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as why:
        raise InputError(
            f"{path}: cannot be read ({why}), the settings of the trials beside it are wanted; "
            "give another --keep, or remove the folder (--trials 0 shows what it holds)"
        ) from None


def pending(task: Task | Own, row: Row | None) -> bool:
    """Whether a trial is to be made, or one that was withheld can be scored now."""
    return row is None or bool(row.get("withheld") and isinstance(task, Own) and task.text)


def run(
    tasks: Sequence[Task | Own], room: Room, jobs: int, limit: float, sealed: Show, done: Show
) -> list[Row]:
    """All rows, those that are in the room already among them, in the order of the tasks.

    sealed(row) is called with index and digest before the diagnosis begins, done(row) with the scored trial.
    """
    rows = room.rows()
    todo: queue.SimpleQueue[Task | Own] = queue.SimpleQueue()
    for task in tasks:
        if pending(task, rows.get(task.index)):
            todo.put(task)
    finished: queue.SimpleQueue[tuple[str, Any]] = queue.SimpleQueue()
    count = todo.qsize()
    lanes = max(1, min(jobs, count))
    with ExitStack() as stack:
        stop = threading.Event()
        pool = stack.enter_context(_keepers(lanes))
        stack.callback(lambda: pool.shutdown(wait=False, cancel_futures=True))
        diagnosers = [stack.enter_context(Diagnoser(limit)) for _ in range(lanes if count else 0)]
        stack.callback(stop.set)  # the first to be called: what a killed diagnoser says is no verdict
        for diagnoser in diagnosers:
            lane = Lane(todo, finished, pool, diagnoser, room, rows.copy(), stop)
            threading.Thread(target=lane.work, daemon=True).start()
        for kind, row in _until_done(finished, count):
            if kind == "sealed":
                room.add(SEALS, f"{row['index']:05d} {row['sha256']}")
                sealed(row)
                row["go"].set()
            else:
                room.add(TRIALS, json.dumps(row, ensure_ascii=False))
                rows[row["index"]] = row
                done(row)
    return [rows[t.index] for t in tasks]


def _until_done(finished: queue.SimpleQueue[tuple[str, Any]], count: int) -> Iterator[tuple[str, Any]]:
    while count:
        kind, row = finished.get()
        if kind == "defect":
            raise row
        count -= kind == "done"
        yield kind, row


def _keepers(count: int) -> ProcessPoolExecutor:
    """Processes that draw and score; a clean start, so that no thread's lock is copied."""
    return ProcessPoolExecutor(count, mp_context=get_context("spawn"), initializer=_quiet)


def _quiet() -> None:
    """One thread each, and Ctrl-C is the parent's to handle."""
    import os
    import signal

    os.environ.update(ONE_THREAD)
    signal.signal(signal.SIGINT, signal.SIG_IGN)


class Stopped(Exception):
    """The run is at its end, and what a lane still has in hand is to be left as it is."""


@dataclass(frozen=True)
class Lane:
    """One trial after another: a keeper draws, the diagnoser sees a fresh folder, a keeper scores."""

    todo: queue.SimpleQueue[Task | Own]
    finished: queue.SimpleQueue[tuple[str, Any]]
    pool: ProcessPoolExecutor
    diagnoser: Diagnoser
    room: Room
    before: Mapping[int, Row]
    stop: threading.Event

    def work(self) -> None:
        try:
            while not self.stop.is_set():
                self.finished.put(("done", self._trial(self.todo.get_nowait())))
        except queue.Empty:
            return
        except Exception as error:
            if not self.stop.is_set():
                self.finished.put(("defect", error))

    def _trial(self, task: Task | Own) -> Row:
        name = {"name": task.name} if isinstance(task, Own) else {}
        if isinstance(task, Own) and task.index in self.before:
            return self._later(task, self.before[task.index]) | name
        with tempfile.TemporaryDirectory(prefix="case-") as scratch:
            folder = Path(scratch) / "case"
            sealed = self.pool.submit(conceal, task, folder).result()
            if sealed.hidden:
                return {"index": task.index, "hidden": sealed.hidden, "error": ""}
            go = threading.Event()
            self.finished.put(("sealed", name | {"index": task.index, "sha256": sealed.sha256, "go": go}))
            go.wait()  # the digest is out before the diagnosis begins
            answer = self.diagnoser.diagnose(folder / "case.toml")
            self._go_on()
            row = name | self.pool.submit(reveal, task.index, sealed, folder, answer).result()
            row |= follow_up(row, folder, self.pool, self.diagnoser)
            self._go_on()
            if row.get("withheld") or missed(row):
                self._keep(row, folder)
            return row

    def _go_on(self) -> None:
        """Raises Stopped once the run is at its end: no secret is revealed that has got no verdict."""
        if self.stop.is_set():
            raise Stopped

    def _later(self, task: Own, row: Row) -> Row:
        """Score a verdict that was given while the secret was withheld."""
        answer = Answer(row["error"], row["wall"], row["cpu"], row["foreign"])
        sealed = Sealed(task.text, task.sha256)
        scored = self.pool.submit(reveal, task.index, sealed, self.room.case(task.index), answer).result()
        return dict(scored) | {"followed": None}

    def _keep(self, row: Row, folder: Path) -> None:
        """A case that was missed or is withheld, with its verdict, and the secret if it is known."""
        kept = self.room.case(row["index"])
        shutil.rmtree(kept, ignore_errors=True)
        shutil.copytree(folder, kept, ignore=shutil.ignore_patterns("diagnosis"))
        if row["secret"]:
            (kept / "secret.json").write_text(row["secret"] + "\n", encoding="utf-8")


def missed(row: Mapping[str, Any]) -> bool:
    """Whether a trial's first answer is wrong."""
    if row["error"] or row.get("alarm") or row.get("misnamed"):
        return True
    return row.get("family") is False or row.get("unknown") is False or row.get("both") is False
