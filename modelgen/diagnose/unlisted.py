"""Physics that no catalogue holds, as rivals of the named effects: resonances of other places and orders.

A cable's trap, a row of modes or a standing wave is fitted, at some price, by a listed resonance or by two
effects in one: that is for the evidence to say. Each of these is a description with an id `unknown_<port>`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from modelgen.diagnose.hypothesis import Addition, make_hypotheses
from modelgen.diagnose.refit import Fit
from modelgen.diagnose.scales import record_scales
from modelgen.diagnose.screen import Tangent, score
from modelgen.diagnose.setting import ALARM, Outcome, Setting
from modelgen.effects import Effect, Shape, Strength, search_range
from modelgen.effects.effect import add
from modelgen.language import Model, Port, j

RARE = 0.1
"""How common such physics is beside that of the catalogue."""
MODES = 8
"""Members of a row of resonances."""
WAYS: dict[str, tuple[bool, ...]] = {
    "electrical_impedance": (False,), "terminals": (True,), "mechanical_impedance": (False, True),
    "stiffness": (False, True),
}  # fmt: skip
"""Whether a resonance stands beside what is there, by the kind of port."""
SOURCE = "a description, no law"


def with_rivals(setting: Setting, outcome: Outcome) -> Outcome:
    """The outcome with sweeps described by one resonance, or one row of them, among what was tried.

    As it was in time, and where nothing is claimed.
    """
    base, judge = outcome.base, outcome.judge
    if setting.model.is_time_model or not outcome.best.hypothesis.added:
        return outcome
    known = record_scales(setting.model, setting.series)
    found = [
        Addition(e, port, {q.name: search_range(q, known) for q in e.shapes})
        for e, port in _places(setting.model)
    ]
    tangent = Tangent.of(*judge.tangent(base))
    fits = []
    for h in make_hypotheses(setting.model, setting.case, setting.series, [(a,) for a in found]):
        x = score(h, base.hypothesis, base.theta, tangent, judge.whiteners, keep=4)
        if x.starts:
            fits.append(judge.fit(h, [h.place(base.hypothesis, base.theta, v) for _, v in x.starts]))
    return replace(outcome, tried=(*outcome.tried, *fits))


def cheaper(outcome: Outcome) -> tuple[Fit, float] | None:
    """What no catalogue holds, where it explains more than the best hypothesis, and by how much.

    By BIC, and for each effect what it must gain to be claimed.
    """
    rivals = [f for f in outcome.tried if is_unlisted(f)]
    if not rivals:
        return None
    first = min(rivals, key=lambda f: f.bic)
    more = outcome.best.bic - first.bic + ALARM * (len(outcome.best.ids) - 1)
    return (first, more) if more > 0 else None


def is_unlisted(fit: Fit) -> bool:
    """Whether it is one of the descriptions made here."""
    return any(a.effect.source == SOURCE for a in fit.hypothesis.added)


def _places(model: Model) -> Iterator[tuple[Effect, Port]]:
    """Each kind of resonance at each port that can have one: in series with what is there, or beside it."""
    kinds = {p.kind for p in model.ports}
    for port in model.ports:
        ways = WAYS.get(port.kind, ())
        if "omega" not in dict(port.variables) or (port.kind == "stiffness" and "mechanical_impedance" in kinds):
            continue
        for beside in ways:
            if beside or port.kind in ("electrical_impedance", "terminals"):  # else it is a second_mode
                yield _resonance(port, 1, beside), port
            yield _resonance(port, MODES, beside), port


def _resonance(port: Port, modes: int, beside: bool) -> Effect:
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
            Shape("omega_1", "rad/s", "omega", 0.7 if modes == 1 else 0.2, 1.5, 120, text="the first"),
            Shape("Q", "1", "1", 2.0, 500.0, 4, text="quality factor"),
        ),
        needs=("omega",),
        common=RARE,
    )
