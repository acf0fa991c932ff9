"""A pool of threads that share work."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from modelgen.files import write_atomically
from modelgen.fit.pool import POOL, cores, share


def test_parts_come_back_in_order_on_any_number_of_threads() -> None:
    squares = [k * k for k in range(50)]
    assert all(share(lambda k: k * k, range(50), threads) == squares for threads in (1, 2, 7, None))


def test_work_that_shares_its_own_work_ends() -> None:
    """Its threads would wait for each other for ever, if each waited for a thread."""

    def row(k: int) -> tuple[list[int], bool]:
        inner = share(lambda m: (k * m, threading.current_thread().name), range(8))
        return [x for x, _ in inner], len({name for _, name in inner}) == 1

    parts = range(4 * cores())
    done: list[object] = []
    outer = threading.Thread(target=lambda: done.extend(share(row, parts, 4)), daemon=True)
    outer.start()
    outer.join(30)
    assert done == [([k * m for m in range(8)], True) for k in parts]
    assert not outer.name.startswith(POOL)


def test_threads_may_write_one_file_at_once(tmp_path: Path) -> None:
    path, texts = tmp_path / "facts.json", [f"{k}" * 5000 for k in range(8)]
    with ThreadPoolExecutor(8) as threads:
        for _ in range(40):
            list(threads.map(lambda text: write_atomically(path, text, lasting=False), texts))
            assert path.read_text() in texts
    assert list(tmp_path.iterdir()) == [path]
