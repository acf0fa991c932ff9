"""A hypothesis: the base with none, one or several effects at its ports, ready to be screened and fitted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import inf

import numpy as np

from modelgen.codegen.build import build_many
from modelgen.diagnose.hypotheses.addition import Addition
from modelgen.errors import InputError
from modelgen.fit.experiment import Experiment, Layout, initial_parameters, make_layout
from modelgen.fit.series import Array, Series
from modelgen.language import Model, Parameter
from modelgen.recordings import Case


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """Base plus `added` effects as an experiment on the fit recordings."""

    added: tuple[Addition, ...]
    experiment: Experiment

    @property
    def ids(self) -> tuple[str, ...]:
        return tuple(a.id for a in self.added)

    @property
    def shapes(self) -> frozenset[str]:
        """Names of the shapes of what is added."""
        return frozenset(f"{a.id}_{q.name}" for a in self.added for q in a.effect.shapes)

    @cached_property
    def pasts(self) -> frozenset[str]:
        """Names of what the effects' states were before the records: in their initial values alone."""
        if not self.added or not self.experiment.model.is_time_model:
            return frozenset()
        starts = tuple(f"{a.id}_" for a in self.added)
        return frozenset(n for n in initial_parameters(self.experiment.model) if n.startswith(starts))

    @property
    def log_common(self) -> float:
        """Logarithm of how common the added physics is."""
        return float(sum(np.log(a.effect.common) for a in self.added))

    @property
    def key(self) -> frozenset[tuple[str, str, int]]:
        return frozenset(a.key for a in self.added)

    @property
    def names(self) -> tuple[str, ...]:
        return self.experiment.layout.names

    def values_of(self, theta: Array, other: Hypothesis) -> Array:
        """θ of `other`, all of whose parameters this one has, from θ of this one."""
        return theta[[self.names.index(n) for n in other.names]]

    def place(self, base: Hypothesis, theta: Array, values: Mapping[str, float]) -> Array:
        """θ of this hypothesis from θ of a smaller one and values by name; strengths start at null."""
        known = self._defaults | dict(zip(base.names, theta.tolist(), strict=True)) | dict(values)
        return np.array([known[n] for n in self.names], dtype=float)

    def places(self, base: Hypothesis, theta: Array, points: Sequence[Mapping[str, float]]) -> Array:
        """`place` with the values of each of `points`, (len(points), p)."""
        found = np.tile(self.place(base, theta, {}), (len(points), 1))
        for k, n in enumerate(self.names):
            if n in points[0]:
                found[:, k] = [values[n] for values in points]
        return found

    @cached_property
    def _defaults(self) -> dict[str, float]:
        known = zip(self.names, self.experiment.layout.parameters, strict=True)
        return {n: p.default if p.default is not None else centre(p) for n, p in known}


def centre(p: Parameter) -> float:
    """The middle of a parameter's bounds, by the logarithm where they are positive."""
    low, high = p.bounds
    if low > 0 and high < inf:
        return float(np.sqrt(low * high))
    if low > -inf and high < inf:
        return 0.5 * (low + high)
    return max(low, 0.0) if low > -inf else min(high, 0.0)


@lru_cache(maxsize=1024)
def _extended(model: Model, added: tuple[Addition, ...]) -> Model:
    """`model` with the effects, one after another: sets begin alike, and a search comes back to them."""
    return added[-1].extend(_extended(model, added[:-1])) if added else model


def unbuilt(model: Model, added: Sequence[Addition]) -> tuple[str, ...]:
    """A note for each effect of which no law can be built at a port, with why."""
    failed: dict[tuple[str, str], str] = {}
    built = set()
    for a in added:
        try:
            _extended(model, (a,))
            built.add((a.id, a.port.name))
        except InputError as why:
            failed.setdefault((a.id, a.port.name), str(why))
    return tuple(
        f"{id} could not be tried at the {port} port: {why}"
        for (id, port), why in failed.items()
        if (id, port) not in built
    )


def _chained(added: tuple[Addition, ...]) -> tuple[Addition, ...]:
    """The effects in the order in which they act, however a search has come by them; what the recording chain
    does acts on all else."""

    def turn(a: Addition) -> tuple[bool, int, str]:
        return "sensor" in a.effect.kinds, a.effect.acts, a.id

    return tuple(sorted(added, key=turn))


def make_hypotheses(
    model: Model, case: Case, series: Sequence[Series], sets: Sequence[tuple[Addition, ...]]
) -> list[Hypothesis]:
    """Extend, compile (all at once) and prepare. What can't be built, has more numbers than data, or holds an
    effect beside one that it is `instead` of, is left out."""
    made: list[tuple[tuple[Addition, ...], Model, Layout, tuple[Series, ...]]] = []
    count = sum(s.data.size for s in series)
    for added in sets:
        if any(a.id in b.effect.instead for a in added for b in added):
            continue
        try:
            extended = _extended(model, _chained(added))
            own_case, own_series = _of_their_own(added, case, series)
            layout = make_layout(extended, own_case, own_series)
        except InputError:
            continue
        if len(layout.names) <= count:
            made.append((added, extended, layout, own_series))
    measures = sorted({s.measure for s in series})
    # a base is searched for from afar; elsewhere the time to lower and compile is dear
    kernels = ("values", "jacobian", "sumsq", "normal") if sets == [()] else ("jacobian",)
    models = [(m, layout.wrt) for _, m, layout, _ in made]
    functions = build_many(models, kernels, measures, brief=sets != [()])
    constants = dict(case.constants)
    return [
        Hypothesis(added, Experiment(m, f, layout, own, constants))
        for (added, m, layout, own), f in zip(made, functions, strict=True)
    ]


def _of_their_own(
    added: Sequence[Addition], case: Case, series: Sequence[Series]
) -> tuple[Case, tuple[Series, ...]]:
    """Case and series in which strengths that each repeat has for itself are so, and null in the first where
    they are in relation to that."""
    owned = [a for a in added if a.repeats]
    if not owned:
        return case, tuple(series)
    own = replace(case, per_recording=(*case.per_recording, *(n for a in owned for n in a.shared)))
    null = {
        n: q.null
        for a in owned
        if not a.effect.first
        for n, q in zip(a.shared, a.effect.strengths, strict=True)
    }
    first = replace(series[0], constants={**series[0].constants, **null})
    return own, (first, *series[1:])
