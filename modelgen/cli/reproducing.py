"""`modelgen reproduce`."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from modelgen.cli.console import check_outputs, check_page, console, progress_bar
from modelgen.papers import papers


def reproduce_papers(wanted: Sequence[str], json: Path | None, html: Path | None) -> int:
    """Compute, print, and write what was asked for, also of a part that was interrupted; the exit status."""
    from modelgen.papers.run import reproduce
    from modelgen.papers.show import print_reproduction

    check_outputs(json, html)
    check_page(html, "--html")
    chosen = papers(wanted)
    with progress_bar("reproducing") as show, counted_interrupts() as stop:
        found = reproduce(chosen, show, stop)
    if json is not None:
        found.write_json(json)
    if html is not None:
        from modelgen.papers.page import write_page

        with progress_bar("drawing") as show:
            write_page(found, html, show)
    print_reproduction(found, console())
    return 130 if found.left_out else 0


@contextmanager
def counted_interrupts() -> Iterator[Callable[[], int]]:
    """Inside, a first Ctrl-C is only counted, a second one interrupts. Yields how many there were."""
    asked = 0

    def count(number: int, frame: FrameType | None) -> None:
        nonlocal asked
        asked += 1
        if asked > 1:
            raise KeyboardInterrupt
        print("stopping after what is being computed; Ctrl-C again to stop at once", file=sys.stderr)

    if threading.current_thread() is not threading.main_thread():  # signals reach the main thread alone
        yield lambda: 0
        return
    before = signal.signal(signal.SIGINT, count)
    try:
        yield lambda: asked
    finally:
        signal.signal(signal.SIGINT, before)
