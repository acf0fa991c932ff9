"""A diagnosing process from outside: start it, hand it one folder at a time, replace it when it hangs."""

from __future__ import annotations

import json
import os
import selectors
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


@dataclass(frozen=True)
class Answer:
    """What went wrong, or "" and a verdict is in the folder; seconds that passed, and of processor time;
    files that the process read outside the folder."""

    error: str
    seconds: float
    cpu: float = 0.0
    foreign: Sequence[str] = ()


class Diagnoser:
    """One `modelgen.prove.worker` at a time. Use as a context manager; not for several threads at once."""

    def __init__(self, limit: float = 300.0) -> None:
        """limit: seconds after which a diagnosis has failed."""
        self.limit = limit
        self._process: subprocess.Popen[str] | None = None

    def __enter__(self) -> Diagnoser:
        self._start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop()

    def diagnose(self, case: Path) -> Answer:
        """Have a case diagnosed."""
        process = self._process or self._start()
        assert process.stdin is not None and process.stdout is not None
        begun = time.perf_counter()
        try:
            process.stdin.write(f"{case}\n")
            process.stdin.flush()
            line = self._line(process)
        except (BrokenPipeError, TimeoutError):
            line = ""
        seconds = time.perf_counter() - begun
        if line:
            return Answer(**json.loads(line), seconds=seconds)
        self._stop()
        late = seconds >= self.limit
        return Answer(
            f"no verdict within {self.limit:g} s" if late else "the diagnosing process ended", seconds
        )

    def _line(self, process: subprocess.Popen[str]) -> str:
        """The line that it answers. Raises TimeoutError."""
        assert process.stdout is not None
        with selectors.DefaultSelector() as ready:
            ready.register(process.stdout, selectors.EVENT_READ)
            if not ready.select(self.limit):
                raise TimeoutError
        return process.stdout.readline()

    def _start(self) -> subprocess.Popen[str]:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "modelgen.prove.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env={**os.environ, **ONE_THREAD, "PYTHONPATH": os.pathsep.join(sys.path)},
            start_new_session=True,  # Ctrl-C is the parent's to handle
        )
        return self._process

    def _stop(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
