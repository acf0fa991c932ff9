"""What the commands share: where they print, a progress bar, tables, a look at outputs beforehand."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from modelgen.errors import InputError, ToolError
from modelgen.files import destination, is_special

if TYPE_CHECKING:
    from rich.console import Console

NO_PAGE = (".pdf", ".png", ".svg", ".jpg", ".jpeg", ".md", ".docx", ".json", ".csv")
PLAIN_WIDTH = 120  # where there is no terminal, so that a table in a file or a pipe is whole


def console(plain: int = PLAIN_WIDTH, lasting: bool = False) -> Console:
    """Prints to standard output; as wide as `plain` where that is no terminal. lasting: and on to nowhere
    when its reader has gone, as `| head` does, where a run is for what it writes."""
    from rich.console import Console

    class Lasting(Console):
        def on_broken_pipe(self) -> None:
            self.quiet = True
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())

    kind = Lasting if lasting else Console
    found = kind(highlight=False, markup=False)
    return found if found.is_terminal else kind(highlight=False, markup=False, width=plain)


def note(texts: Iterable[str]) -> None:
    """Remarks for a reader, on stderr: what a command prints may be read by another."""
    for text in texts:
        print(f"modelgen: note: {text}", file=sys.stderr)


@contextmanager
def progress_bar(title: str) -> Iterator[Callable[[float, str], None]]:
    """A bar on stderr, gone when done; nothing where there is no terminal. Yields show(fraction, text)."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    err = Console(stderr=True, markup=False)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.fields[text]}"),
    )
    with Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as bar:
        task = bar.add_task(title, total=1.0, text="")
        yield lambda fraction, text: bar.update(task, completed=fraction, text=text)


def check_output(path: Path | None, *, folder: bool = False) -> None:
    """Raise InputError or ToolError now for an output that could not be written after minutes of work."""
    if path is None:
        return
    if folder:
        there = next(p for p in (path, *path.absolute().parents) if p.exists())
        if not there.is_dir():
            raise InputError(f"cannot write into {path}: {there} is a file, a folder is wanted")
    else:
        end = destination(path)
        there = end if is_special(end) else end.parent
        if path.is_dir():
            raise InputError(f"cannot write {path}: it is a folder, a file name is wanted")
        if not (there.is_dir() or is_special(end)):
            raise InputError(f"cannot write {path}: the folder {there} does not exist")
    if not os.access(there, os.W_OK):
        raise ToolError(f"cannot write {path}: no permission to write into {there}")


def check_outputs(*paths: Path | None) -> None:
    """`check_output` for each file. Raises InputError also where one would overwrite another."""
    given = [path for path in paths if path is not None]
    for k, path in enumerate(given):
        check_output(path)
        if any(path.absolute() == other.absolute() for other in given[:k]):
            raise InputError(f"cannot write {path} twice: two outputs have this name")


def check_page(path: Path | None, option: str) -> None:
    """Raise InputError for a page of another format than HTML."""
    if path is not None and path.suffix.lower() in NO_PAGE:
        raise InputError(f"{option} {path}: the page is HTML, a name that ends in .html is wanted")


def spare(inputs: Iterable[Path | None], *outputs: Path | None) -> None:
    """Raise InputError for an output that would overwrite a file that was read."""
    read = {path.resolve() for path in inputs if path is not None}
    for path in outputs:
        if path is not None and path.resolve() in read:
            raise InputError(f"cannot write {path}: it is an input, which would be lost")
