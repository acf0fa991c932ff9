"""The trials: drawn, sealed, diagnosed elsewhere, revealed, and written down one by one."""

from __future__ import annotations

import json
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
from modelgen.prove.diagnoser import ONE_THREAD, Diagnoser
from modelgen.prove.followup import follow_up
from modelgen.prove.keeper import Row, conceal, reveal
from modelgen.prove.plan import Task

TRIALS, SEALS, CASES = "trials.jsonl", "sealed.txt", "cases"
Show = Callable[[Row], None]


@dataclass(frozen=True)
class Room:
    """Where a run keeps its rows (`trials.jsonl`), its digests (`sealed.txt`) and the cases that it
    missed."""

    folder: Path

    def rows(self) -> dict[int, Row]:
        """Trials that are done, by index; a line that was cut off is done again."""
        found: dict[int, Row] = {}
        path = self.folder / TRIALS
        for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
            try:
                row = json.loads(line)
            except json.JSONDecodeError:
                continue
            found[row["index"]] = row
        return found

    def open(self, settings: Mapping[str, Any]) -> None:
        """Make the folder, or see that what is in it was run with the same settings.

        Raises InputError if it wasn't.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        path, text = self.folder / "settings.json", json.dumps(settings)
        if path.exists() and json.loads(path.read_text(encoding="utf-8")) != json.loads(text):
            raise InputError(
                f"{self.folder}: holds trials of another seed, noise or version; "
                "give another --keep, or remove it"
            )
        path.write_text(text, encoding="utf-8")

    def add(self, name: str, line: str) -> None:
        with open(self.folder / name, "a", encoding="utf-8") as file:
            file.write(line + "\n")


def run(tasks: Sequence[Task], room: Room, jobs: int, limit: float, sealed: Show, done: Show) -> list[Row]:
    """All rows, those that are in the room already among them, in the order of the tasks.

    sealed(row) is called with index and digest before the diagnosis begins, done(row) with the scored trial.
    """
    rows = room.rows()
    todo: queue.SimpleQueue[Task] = queue.SimpleQueue()
    for task in tasks:
        if task.index not in rows:
            todo.put(task)
    finished: queue.SimpleQueue[tuple[str, Any]] = queue.SimpleQueue()
    count = todo.qsize()
    lanes = max(1, min(jobs, count))
    with ExitStack() as stack:
        stop = threading.Event()
        stack.callback(stop.set)
        pool = stack.enter_context(_keepers(lanes))
        stack.callback(lambda: pool.shutdown(wait=False, cancel_futures=True))
        for _ in range(lanes if count else 0):
            diagnoser = stack.enter_context(Diagnoser(limit))
            lane = Lane(todo, finished, pool, diagnoser, room, stop)
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


@dataclass(frozen=True)
class Lane:
    """One trial after another: a keeper draws, the diagnoser sees a fresh folder, a keeper scores."""

    todo: queue.SimpleQueue[Task]
    finished: queue.SimpleQueue[tuple[str, Any]]
    pool: ProcessPoolExecutor
    diagnoser: Diagnoser
    room: Room
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

    def _trial(self, task: Task) -> Row:
        with tempfile.TemporaryDirectory(prefix="case-") as scratch:
            folder = Path(scratch) / "case"
            text, digest = self.pool.submit(conceal, task, folder).result()
            if not text:
                return {"index": task.index, "hidden": digest, "error": ""}
            go = threading.Event()
            self.finished.put(("sealed", {"index": task.index, "sha256": digest, "go": go}))
            go.wait()  # the digest is out before the diagnosis begins
            answer = self.diagnoser.diagnose(folder / "case.toml")
            row = self.pool.submit(reveal, task.index, text, digest, folder, answer).result()
            row = row | follow_up(row, folder, self.pool, self.diagnoser)
            if missed(row):
                self._keep(row, text, folder)
            return row

    def _keep(self, row: Row, text: str, folder: Path) -> None:
        """A case that was missed, with its verdict and secret, for whoever wants to look."""
        kept = self.room.folder / CASES / f"{row['index']:05d}"
        shutil.rmtree(kept, ignore_errors=True)
        shutil.copytree(folder, kept, ignore=shutil.ignore_patterns("diagnosis"))
        (kept / "secret.json").write_text(text + "\n", encoding="utf-8")


def missed(row: Mapping[str, Any]) -> bool:
    """Whether a trial's first answer is wrong."""
    if row["error"] or row.get("alarm") or row.get("misnamed"):
        return True
    return row.get("family") is False or row.get("unknown") is False or row.get("both") is False
