"""An optimiser, or a chain of them, from the text of an option."""

from __future__ import annotations

import re
from collections.abc import Callable
from inspect import signature

from modelgen.errors import InputError, did_you_mean
from modelgen.fit import IPOPT, PSO, GaussNewton, MultiStart
from modelgen.fit.method import Method
from modelgen.fit.random import RandomChanges, RandomSets
from modelgen.fit.recipe import Recipe

METHODS: dict[str, Callable[..., Method]] = {
    "gauss-newton": lambda: GaussNewton(),
    "ipopt": lambda *, shooting=0: IPOPT(shooting=shooting),
    "pso": lambda particles=40: PSO(particles),
    "pso-paper": lambda iterations=300: PSO.paper(iterations),
    "multistart": lambda starts=20: MultiStart(starts=starts),
    "random-sets": lambda sets=100: RandomSets(sets),
    "random-changes": lambda changes=100_000: RandomChanges(changes),
    "mre-stages": lambda changes=100_000: RandomSets() >> RandomChanges(changes) >> GaussNewton(),
}
_LINK = re.compile(r"\s*([A-Za-z_-]+)\s*(?:\(\s*(?:(\w+)\s*=\s*)?(\d*)\s*\))?\s*")


RECIPES = tuple(f"gmm-{k}{paper}" for paper in ("", "-paper") for k in (1, 2, 3))


def read_method(text: str | None) -> Method | Recipe | None:
    """The method that `text` names, e.g. "pso(40) >> ipopt(shooting=20)" or "gmm-3"; None for None.

    Raises InputError.
    """
    if text is None:
        return None
    if not text.strip():
        raise InputError(f"--method: found '{text}', wanted one of {', '.join((*METHODS, *RECIPES))}")
    if text.strip() in RECIPES:
        from modelgen.papers.gmm import methods

        _, number, *paper = text.strip().split("-")
        recipe: Recipe = getattr(methods, f"METHOD_{number}{'_PAPER' if paper else ''}")
        return recipe
    whole: Method | None = None
    for link in text.split(">>"):
        if not link.strip():
            raise InputError(f"--method: unknown method '' in '{text}', wanted one before and after each >>")
        if ">" in link:
            raise InputError(f"--method: found a lone > in '{text}', wanted >> between methods: pso >> ipopt")
        found = _LINK.fullmatch(link)
        name = _spelled(link.partition("(")[0])
        if not found and name in METHODS:
            raise InputError(f"--method: {link.strip()}: wanted {_forms(name)}")
        if not found or name not in METHODS:
            hint = did_you_mean(link, METHODS) or f"; it is one of {', '.join((*METHODS, *RECIPES))}"
            raise InputError(f"--method: unknown method '{link.strip()}'{hint}")
        made = _made(name, found[2], found[3], link.strip())
        whole = made if whole is None else whole >> made
    return whole


def _forms(name: str) -> str:
    """How the method called `name` may be written."""
    known = signature(METHODS[name]).parameters.values()
    forms = [f"{name}({'' if p.kind is p.POSITIONAL_OR_KEYWORD else f'{p.name}='}N)" for p in known]
    return " or ".join((name, *forms)) + (", N a whole number from 0" if forms else "")


def _made(name: str, setting: str | None, number: str | None, link: str) -> Method:
    """The method called `name` with a number in its brackets, which a setting's name may stand before."""
    make = METHODS[name]
    known = signature(make).parameters
    if setting and setting not in known:
        hint = did_you_mean(setting, known) or (f"; it has {', '.join(known)}" if known else "; it has none")
        raise InputError(f"--method: {name} has no setting '{setting}'{hint}")
    if setting and not number:
        raise InputError(f"--method: {link}: a whole number is wanted for {setting}")
    if setting:
        return make(**{setting: int(number or 0)})
    if number and not any(p.kind is p.POSITIONAL_OR_KEYWORD for p in known.values()):
        more = "".join(f", but {name}({p}={number})" for p in known)
        raise InputError(f"--method: {name} takes no number{more}, found {link}")
    return make(*([int(number)] if number else []))


def _spelled(name: str) -> str:
    """However it is written: GaussNewton, gauss_newton, MultiStart."""
    plain = re.sub(r"[^a-z]", "", name.lower())
    return next((m for m in METHODS if m.replace("-", "") == plain), name)
