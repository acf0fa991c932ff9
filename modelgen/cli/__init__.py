"""The command line, and its exit statuses: 0 done, 2 the user's input is wrong, 130 interrupted."""

from __future__ import annotations

import errno
import logging
import os
import sys
from collections.abc import Sequence
from typing import Any

from modelgen.errors import ModelgenError

FULL = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT, errno.EROFS)
"""What the system says when there is no more room, which may strike wherever a file is written."""
INTERRUPTED = 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status. What is wrong with the input becomes one line on stderr."""
    from typer.main import get_command

    from modelgen.cli.app import app

    # that it makes its cache of fonts, or can't write it, is not for stderr
    logging.getLogger("matplotlib.font_manager").setLevel(logging.ERROR)
    try:
        status = get_command(app).main(args=_words(arguments), prog_name="modelgen", standalone_mode=False)
        sys.stdout.flush()
        if status == INTERRUPTED:  # as Typer says it
            return _say("interrupted", INTERRUPTED)
        return status if isinstance(status, int) else 0
    except ModelgenError as why:
        return _say(str(why), 2)
    except (BrokenPipeError, SystemExit) as why:  # the reader of a pipe has gone, as `| head` does
        # Rich and Click know it, too, and make an exit with status 1 of it
        if isinstance(why, SystemExit) and not isinstance(why.__context__, BrokenPipeError):
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as why:
        if why.errno not in FULL:
            raise
        return _say(f"cannot write {why.filename or 'a file'}: {why.strerror}", 2)
    except Exception as why:
        # Typer's own exceptions: their classes stand in other modules from one version to the next
        if type(why).__name__ == "Abort":
            return _say("interrupted", INTERRUPTED)
        if not hasattr(why, "format_message"):
            raise
        command = getattr(getattr(why, "ctx", None), "command_path", "modelgen")
        return _say(f"{why.format_message()}{_page(why)} ('{command} --help' shows what there is)", 2)
    except KeyboardInterrupt:
        return _say("interrupted", INTERRUPTED)


def _page(why: Any) -> str:
    """Where an option is unknown by which another command writes its page: what it is called here."""
    here = {"--html": "--report", "--report": "--html"}.get(getattr(why, "option_name", ""))
    known = [name for p in why.ctx.command.params for name in p.opts] if here else []
    return f": the page is {here} here" if here in known else ""


def _words(arguments: Sequence[str] | None) -> list[str]:
    words = list(sys.argv[1:] if arguments is None else arguments)
    return words or ["--help"]


def _say(message: str, status: int) -> int:
    print("modelgen:", " ".join(message.split()), file=sys.stderr)
    return status
