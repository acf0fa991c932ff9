"""Commands whose options are given once: of two, Typer would drop the first without a word."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import typer
from typer.core import TyperCommand

from modelgen.errors import InputError


class Once(TyperCommand):
    """A command that refuses a second value of an option that has one."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        found: list[Any] = self.make_parser(ctx).parse_args(args=list(args))[2]
        for p in found:
            if found.count(p) > 1 and not (p.multiple or p.is_flag):
                raise InputError(f"{p.opts[0]} is given twice, wanted once")
        return super().parse_args(ctx, args)


class App(typer.Typer):
    """Commands of this kind."""

    def command(self, name: str | None = None, **more: Any) -> Callable[[Any], Any]:
        return super().command(name, cls=Once, **more)
