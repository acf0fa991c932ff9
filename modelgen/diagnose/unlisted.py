"""Physics that no catalogue holds, as rivals of the named effects: resonances of other places and orders.

A cable's trap, a row of modes or a standing wave is fitted, at some price, by a listed resonance or by two
effects in one: that is for the evidence to say. Each of these is a description with an id `unknown_<port>`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from modelgen.diagnose.describe import SOURCE
from modelgen.diagnose.hypothesis import Addition, make_hypotheses
from modelgen.diagnose.refit import Fit
from modelgen.diagnose.scales import record_scales
from modelgen.diagnose.screen import Tangent, score
from modelgen.diagnose.setting import ALARM, CLOSE, Outcome, Setting
from modelgen.effects import Effect, Shape, Strength, search_range
from modelgen.effects.effect import add
from modelgen.language import Model, Port, j

RARE = 0.3
"""How common such physics is beside that of the catalogue."""
MODES = 8
"""Members of a row of resonances."""
WAYS: dict[str, tuple[tuple[int, bool], ...]] = {
    "electrical_impedance": ((1, False), (MODES, False)),
    "terminals": ((1, True), (MODES, True)),
    "mechanical_impedance": ((MODES, False),),
    "stiffness": ((MODES, False), (MODES, True)),
}
"""How many resonances, and whether beside what is there, by the kind of port.

One in series at the mechanical side is a second_mode, and any beside it is one in the electrical impedance.
"""
KEEP = 8
"""Starts for each kind of resonance: rows have many local optima."""
STEP = 0.08
"""Between resonance frequencies that are tried first, in the logarithm."""


def with_rivals(setting: Setting, outcome: Outcome) -> Outcome:
    """The outcome with sweeps described by one resonance, or one row of them, among what was tried.

    As it was in time, and where it has them.
    """
    base, judge = outcome.base, outcome.judge
    if setting.model.is_time_model or any(is_unlisted(f) for f in outcome.tried):
        return outcome
    known = record_scales(setting.model, setting.series)
    points = 12 + int(np.log(known["omega"].max() / known["omega"].min()) / STEP)
    found = [
        Addition(e, port, {q.name: search_range(q, known) for q in e.shapes})
        for e, port in _places(setting.model, points)
    ]
    # the base is bent to what is missing; where the best hypothesis has it, that shows as it is
    unbent = outcome.best.hypothesis.values_of(outcome.best.theta, base.hypothesis)
    references = [judge.look(base.hypothesis, at) for at in (base.theta, unbent)]
    tangents = [Tangent.of(*judge.tangent(f)) for f in references]
    fits = []
    for h in make_hypotheses(setting.model, setting.case, setting.series, [(a,) for a in found]):
        starts = [
            h.place(f.hypothesis, f.theta, v)
            for f, tangent in zip(references, tangents, strict=True)
            for _, v in score(h, f.hypothesis, f.theta, tangent, judge.whiteners, keep=KEEP).starts
        ]
        if starts:
            fits.append(judge.fit(h, starts))
    return replace(outcome, tried=(*outcome.tried, *fits))


def best_unlisted(outcome: Outcome) -> Fit | None:
    """The best of the descriptions made here."""
    return min((f for f in outcome.tried if is_unlisted(f)), key=lambda f: f.bic, default=None)


def cheaper(outcome: Outcome) -> tuple[Fit, float] | None:
    """What no catalogue holds, where it clearly explains more than the best hypothesis, and by how much.

    By BIC, and for each effect what it must gain to be claimed.
    """
    first = best_unlisted(outcome)
    if first is None or not outcome.best.hypothesis.added:
        return None
    more = outcome.best.bic - first.bic + ALARM * (len(outcome.best.ids) - 1)
    return (first, more) if more > CLOSE else None


def is_unlisted(fit: Fit) -> bool:
    """Whether it is one of the descriptions made here."""
    return any(a.effect.source == SOURCE for a in fit.hypothesis.added)


def _places(model: Model, points: int) -> Iterator[tuple[Effect, Port]]:
    """Each kind of resonance at each port that can have one."""
    kinds = {p.kind for p in model.ports}
    for port in model.ports:
        twice = port.kind == "stiffness" and "mechanical_impedance" in kinds
        if not twice and "omega" in dict(port.variables):
            for modes, beside in WAYS.get(port.kind, ()):
                yield _resonance(port, modes, beside, points), port


def _resonance(port: Port, modes: int, beside: bool, points: int) -> Effect:
    """a Σ_n 1/(1 + jQ (ω/nω_1 − nω_1/ω)) added to the port's quantity, or `beside` it: to its inverse.

    A stiffness gets an impedance that resonates: jω/ω_1 times that.
    """

    def terms(at: Port, p: Any) -> Any:
        u = at["omega"] / p["omega_1"]
        total = p["a"] * sum(1 / (1 + j * p["Q"] * (u / n - n / u)) for n in range(1, modes + 1))
        return total * (j * u if at.kind == "stiffness" else 1)

    def parallel(model: Model, at: Port, p: Any) -> Model:
        return model.extend(at.equation, lambda Z: Z / (1 + Z * terms(at, p)))

    what = "a resonance" if modes == 1 else "a row of resonances, at multiples of the first,"
    return Effect(
        f"unknown_{port.name}",
        (port.kind,),
        f"{what} {'beside' if beside else 'in series with'} all that the {port.name} port has",
        SOURCE,
        (Strength("a", "1/({port})" if beside else "{port}", text="height of a resonance"),),
        parallel if beside else add(terms),
        (
            Shape("omega_1", "rad/s", "omega", 0.7 if modes == 1 else 0.2, 1.5, points, text="the first"),
            Shape("Q", "1", "1", *((2.0, 500.0) if modes == 1 else (3.0, 100.0)), 4, text="quality factor"),
        ),
        needs=("omega",),
        common=RARE,
    )
