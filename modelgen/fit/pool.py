"""A plain pool of threads: generated C releases Python's lock, so threads are all it takes."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cache
from itertools import pairwise
from threading import current_thread
from typing import TypeVar

POOL = "modelgen"
"""Beginning of the names of its threads."""
Part = TypeVar("Part")
Result = TypeVar("Result")


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix=POOL)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)  # a child has none of its parent's threads


def share(
    task: Callable[[Part], Result],
    parts: Sequence[Part],
    threads: int | None = None,
    stop: Callable[[], None] | None = None,
) -> list[Result]:
    """`task` of each part, in order, on `threads` cores (all by default), whose number changes no result.

    A task that shares its own work does it alone: the cores are taken. stop: makes tasks end soon; Ctrl-C
    calls it, and is raised when they have.
    """
    within = current_thread().name.startswith(POOL)
    threads = 1 if within else min(threads or cores(), len(parts))
    if within or (threads < 2 and stop is None):
        return [task(p) for p in parts]
    running = [_pool(threads).submit(task, p) for p in parts]
    try:
        return [x.result() for x in running]
    except KeyboardInterrupt:
        for x in running:
            x.cancel()
        if stop is not None:
            stop()
            wait(running)
        raise


def slices(count: int, parts: int) -> list[slice]:
    """`count` items in at most `parts` pieces of about the same length."""
    edges = [count * k // max(1, parts) for k in range(parts + 1)]
    return [slice(a, b) for a, b in pairwise(edges) if b > a]
