"""An optimiser, or a chain of them, from the text of an option."""

from __future__ import annotations

import re
from collections.abc import Callable

from modelgen.errors import InputError, did_you_mean
from modelgen.fit import IPOPT, PSO, GaussNewton, MultiStart
from modelgen.fit.method import Method
from modelgen.fit.recipe import Recipe

METHODS: dict[str, Callable[..., Method]] = {
    "gauss-newton": lambda: GaussNewton(),
    "ipopt": lambda: IPOPT(),
    "pso": lambda particles=40: PSO(particles),
    "pso-paper": lambda iterations=300: PSO.paper(iterations),
    "multistart": lambda starts=20: MultiStart(starts=starts),
}
_LINK = re.compile(r"\s*([A-Za-z_-]+)\s*(?:\(\s*(\d*)\s*\))?\s*")


RECIPES = tuple(f"gmm-{k}{paper}" for paper in ("", "-paper") for k in (1, 2, 3))


def read_method(text: str) -> Method | Recipe | None:
    """The method that `text` names, e.g. "pso(40) >> ipopt" or "gmm-3"; None for "". Raises InputError."""
    if text.strip() in RECIPES:
        from modelgen.papers.gmm import methods

        _, number, *paper = text.strip().split("-")
        recipe: Recipe = getattr(methods, f"METHOD_{number}{'_PAPER' if paper else ''}")
        return recipe
    whole: Method | None = None
    for link in text.split(">>") if text.strip() else ():
        found = _LINK.fullmatch(link)
        name = _spelled(found[1]) if found else ""
        if not found or name not in METHODS:
            hint = did_you_mean(link, METHODS) or f"; it is one of {', '.join((*METHODS, *RECIPES))}"
            raise InputError(f"--method: unknown method '{link.strip()}'{hint}")
        if found[2] and name in ("gauss-newton", "ipopt"):
            raise InputError(f"--method: {name} takes no number, found {link.strip()}")
        made = METHODS[name](*([int(found[2])] if found[2] else []))
        whole = made if whole is None else whole >> made
    return whole


def _spelled(name: str) -> str:
    """However it is written: GaussNewton, gauss_newton, MultiStart."""
    plain = re.sub(r"[^a-z]", "", name.lower())
    return next((m for m in METHODS if m.replace("-", "") == plain), name)
