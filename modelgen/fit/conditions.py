"""A model's conditions on its parameters as inequalities of a least-squares problem."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from modelgen.fit.problem import Inequality, Vector
from modelgen.language.quantities import Condition

if TYPE_CHECKING:
    from modelgen.fit.experiment import Experiment
    from modelgen.language import Model

ROUNDING = 1e-6  # share of a condition's terms by which it may be missed


def inequalities(ex: Experiment) -> tuple[Inequality, ...]:
    """The conditions of the experiment's model that its free parameters can break, for each recording."""
    found: dict[tuple[str, tuple[int, ...]], Inequality] = {}
    for k in range(len(ex.series)):
        held = held_values(ex, k)
        for condition in ex.model.conditions:
            free = [n for n in ex.layout.wrt if n in {s.name for s in condition.expr.free_symbols}]
            places = tuple(int(ex.layout.place[k][ex.layout.wrt.index(n)]) for n in free)
            if any(p >= 0 for p in places):
                found.setdefault((condition.says, places), _inequality(condition, free, places, held))
    return tuple(found.values())


def held_values(ex: Experiment, k: int) -> dict[str, float]:
    """Every parameter's value in recording k where θ does not say: defaults, then what is known."""
    known = {p.name: p.default for p in ex.model.scalar_parameters if p.default is not None}
    return known | dict(ex.constants) | dict(ex.series[k].constants)


def values_at(ex: Experiment, theta: Vector, k: int) -> dict[str, float]:
    """Every parameter's value in recording k at θ."""
    return held_values(ex, k) | dict(zip(ex.layout.wrt, ex.local(theta, k).tolist(), strict=True))


def broken(model: Model, values: Mapping[str, float], constrained: bool = False) -> tuple[str, ...]:
    """A sentence for each condition of `model` that `values`, by name, do not meet. constrained: they were
    to, so that this is no cure."""
    cure = "" if constrained else "; `--constrained` fits within it"
    said = []
    for condition in model.conditions:
        at = {s: values[s.name] for s in condition.expr.free_symbols}
        terms = [float(term.xreplace(at)) for term in condition.expr.as_ordered_terms()]
        if sum(terms) < -ROUNDING * max(map(abs, terms)):
            said.append(f"these values break a rule of passive devices, that {condition.says}{cure}")
    return tuple(said)


def broken_in(
    model: Model, recordings: Sequence[tuple[str, Mapping[str, float]]], constrained: bool = False
) -> tuple[str, ...]:
    """`broken` for the values of each recording, beside its name: each sentence once, with the recordings it
    is about where others keep the rule."""
    said: dict[str, list[str]] = {}
    for name, values in recordings:
        for sentence in broken(model, values, constrained):
            said.setdefault(sentence, []).append(f"'{name}'")
    return tuple(
        sentence if len(where) == len(recordings) else f"in {', '.join(where)} {sentence}"
        for sentence, where in said.items()
    )


def _inequality(
    condition: Condition, free: list[str], places: tuple[int, ...], held: Mapping[str, float]
) -> Inequality:
    import sympy as sp

    symbols = {s.name: s for s in condition.expr.free_symbols}
    moves = [(symbols[n], p) for n, p in zip(free, places, strict=True) if p >= 0]
    expr = condition.expr.xreplace({s: held[n] for n, s in symbols.items() if (s not in dict(moves))})
    value = sp.lambdify([s for s, _ in moves], expr)
    slopes = [(p, sp.lambdify([s for s, _ in moves], sp.diff(expr, x))) for x, p in moves]
    at = [p for _, p in moves]

    def gradient(theta: Vector) -> Vector:
        g = np.zeros(theta.size)
        for p, slope in slopes:
            g[p] += slope(*theta[at])
        return g

    return Inequality(condition.says, lambda theta: float(value(*theta[at])), gradient)
