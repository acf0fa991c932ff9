"""`modelgen reproduce`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from modelgen.cli.console import check_output, console, progress_bar
from modelgen.papers import papers


def reproduce_papers(wanted: Sequence[str], json: Path | None, html: Path | None) -> None:
    """Compute, print, and write what was asked for."""
    from modelgen.papers.run import reproduce
    from modelgen.papers.show import print_reproduction

    check_output(json)
    check_output(html)
    chosen = papers(wanted)
    with progress_bar("reproducing") as show:
        found = reproduce(chosen, show)
    if json is not None:
        found.write_json(json)
    if html is not None:
        from modelgen.papers.page import write_page

        with progress_bar("drawing") as show:
            write_page(found, html, show)
    print_reproduction(found, console())
