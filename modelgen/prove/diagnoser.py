"""A diagnosing process from outside: start it, hand it one folder at a time, replace it when it hangs."""

from __future__ import annotations

import json
import os
import selectors
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


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

    def diagnose(self, case: Path) -> tuple[float, str]:
        """Seconds that it took, and what went wrong or "". The verdict is in the case's folder then."""
        process = self._process or self._start()
        assert process.stdin is not None and process.stdout is not None
        begun = time.perf_counter()
        try:
            process.stdin.write(f"{case}\n")
            process.stdin.flush()
            error = self._answer(process)
        except BrokenPipeError:
            error = "the diagnosing process ended"
        if error.startswith("the diagnosing process"):
            self._stop()
        return time.perf_counter() - begun, error

    def _answer(self, process: subprocess.Popen[str]) -> str:
        assert process.stdout is not None
        with selectors.DefaultSelector() as ready:
            ready.register(process.stdout, selectors.EVENT_READ)
            if not ready.select(self.limit):
                return f"the diagnosing process gave no verdict within {self.limit:g} s"
        line = process.stdout.readline()
        return str(json.loads(line)["error"]) if line else "the diagnosing process ended"

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
