"""Which secrets are drawn: shuffled decks, so that each kind, effect, noise and depth has its share."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import TypeVar

import numpy as np

from modelgen.errors import InputError, one_of
from modelgen.truths import drawing
from modelgen.truths.secret import DOMAINS, NOISES, NOISES_OF, family

T = TypeVar("T")
KIND_DECK = ("none",) * 4 + ("single",) * 8 + ("variant",) * 2 + ("pair",) * 3 + ("novel",) * 3
Depth = tuple[float | None, tuple[float, float]]
D2, FAINT = (30.0, 1e4), (5.0, 30.0)
DEPTHS: tuple[Depth, ...] = tuple((ratio, D2) for ratio in (None, 1.5, 3.0, 6.0, 20.0))
"""Rms ratios wanted; None is a concealment in the noise itself, by d² whatever the ratio."""
FAINTER: tuple[Depth, ...] = (*DEPTHS, (None, FAINT))
"""Some single effects are fainter than any goal asks for, so that the curve of power has its foot."""


@dataclass(frozen=True)
class Task:
    """A secret to be drawn. `effects` holds the law's name for a variant, two ids for a pair."""

    index: int
    seed: int
    kind: str
    domain: str
    effects: tuple[str, ...]
    noise: str
    ratio: float | None
    d2: tuple[float, float] = D2


def plan(
    trials: int, seed: int, noises: Sequence[str] = NOISES, domains: Sequence[str] = DOMAINS
) -> tuple[Task, ...]:
    """The first `trials` tasks of a seed; more trials begin with the same ones.

    Raises InputError for a kind of noise or a domain that doesn't exist, or where none has any of the noises.
    """
    for option, names, all_of in (("--noise", noises, NOISES), ("--domain", domains, DOMAINS)):
        for name in names:
            if name not in all_of:
                raise InputError(f"{option}: no '{name}'{one_of(name, all_of)}")
    fitting = {d: [n for n in noises if n in NOISES_OF[d]] for d in domains}
    if not any(fitting.values()):
        raise InputError(f"--noise: {', '.join(domains)} has no noise of kind {', '.join(noises)}")
    return tuple(islice(_tasks(seed, fitting), trials))


def _tasks(seed: int, fitting: Mapping[str, Sequence[str]]) -> Iterator[Task]:
    rng = np.random.default_rng([seed, 5])
    domains = [d for d in fitting if fitting[d]]
    kinds = _deck(rng, KIND_DECK)
    depths = {
        k: _deck(rng, FAINTER if k == "single" else DEPTHS) for k in dict.fromkeys(KIND_DECK) if k != "none"
    }
    noise = {(k, d): _deck(rng, fitting[d]) for k in dict.fromkeys(KIND_DECK) for d in domains}
    places = {k: _deck(rng, _entries(k, domains)) for k in dict.fromkeys(KIND_DECK)}
    index = 0
    while True:
        kind = next(kinds)
        domain, effects = next(places[kind])
        if kind == "pair":
            effects = _pair(rng, domain)
        depth = next(depths[kind]) if kind in depths else (None, D2)
        yield Task(index, seed * 100_000 + index, kind, domain, effects, next(noise[kind, domain]), *depth)
        index += 1


def _entries(kind: str, domains: Sequence[str]) -> list[tuple[str, tuple[str, ...]]]:
    """(domain, effects) of a kind, each of which is drawn once before one is drawn again."""
    if kind in ("none", "pair"):
        return [(d, ()) for d in domains]
    if kind == "variant":
        return [(d, (law,)) for d in domains for law in drawing.variants(d)]
    novel = kind == "novel"
    return [(d, (e,)) for d in domains for e in drawing.catalogue(d) if e.startswith("novel:") == novel]


def _pair(rng: np.random.Generator, domain: str) -> tuple[str, ...]:
    """Two effects of different families."""
    listed = [e for e in drawing.catalogue(domain) if not e.startswith("novel:")]
    first = str(rng.choice(listed))
    return first, str(rng.choice([e for e in listed if family(e) != family(first)]))


def _deck(rng: np.random.Generator, items: Sequence[T]) -> Iterator[T]:
    """All items in random order, again and again."""
    while True:
        yield from (items[i] for i in rng.permutation(len(items)))
