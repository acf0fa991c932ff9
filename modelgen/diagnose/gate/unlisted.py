"""Physics that no catalogue holds, as rivals of the named effects: resonances of other places and orders.

A cable's trap, a row of modes or a standing wave is fitted, at some price, by a listed resonance or by two
effects in one: that is for the evidence to say. Each of these is a description with an id `unknown_<port>`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from modelgen.diagnose.gate.describe import SOURCE
from modelgen.diagnose.hypotheses.evidence import deviance
from modelgen.diagnose.hypotheses.hypothesis import Addition, Hypothesis, make_hypotheses
from modelgen.diagnose.hypotheses.refit import LONG, Fit, Judge
from modelgen.diagnose.hypotheses.scales import record_scales
from modelgen.diagnose.hypotheses.setting import ALARM, Outcome, Setting
from modelgen.diagnose.search.screen import Tangent, score
from modelgen.effects import Effect, Shape, Strength, search_range
from modelgen.effects.effect import add
from modelgen.fit.series import Array, Whitener
from modelgen.language import Model, Port, exp, j

RARE = 0.3
"""How common such physics is beside that of the catalogue; waves as much less beside a resonance or a row."""
MODES = 8
"""Members of a row of resonances."""
ONE, MANY = "a resonance", "a row of resonances, at multiples of the first,"
CLOSED = "waves between ends that are alike, with resonances at multiples of the first,"
OPEN = "waves between ends that are unlike, with resonances at odd multiples of the first,"
"""What is described. Waves on a line or in a pipe lose in proportion to frequency: −j cot kl, which is a
spring or a capacitor at low frequency, or j tan kl (L. E. Kinsler et al., Fundamentals of
Acoustics (2000), ch. 10).
"""
ROWS = (MANY, CLOSED, OPEN)
WAYS: dict[str, tuple[tuple[str, bool], ...]] = {
    "electrical_impedance": tuple((what, False) for what in (ONE, *ROWS)),
    "terminals": tuple((what, True) for what in (ONE, *ROWS)),
    "mechanical_impedance": tuple((what, False) for what in ROWS),
    "stiffness": ((MANY, False), (MANY, True)),
}
"""What is tried by the kind of port, and whether beside all that is there.

One in series at the mechanical side is a second_mode, and any beside it is one in the electrical impedance.
"""
FEW = 2
"""The best kinds of resonances, whose fits go on."""
LOOSE = 2.0
"""Those that after a few steps leave so many times the χ² of the best named effects do not."""
KEEP = 5
"""Starts for each kind of resonance and each state of the base: rows have many local optima."""
QUALITIES = (4.0, 12.0, 36.0)
STEP = 0.7
"""Quality factors that are tried first, and the step between frequencies in widths of such a resonance."""


def with_rivals(setting: Setting, outcome: Outcome) -> Outcome:
    """The outcome with sweeps described by one resonance, or one row of them, among what was tried.

    As it was in time, and where it has them.
    """
    base, judge = outcome.base, outcome.judge
    if setting.model.is_time_model or any(is_unlisted(f) for f in outcome.tried):
        return outcome
    known = record_scales(setting.model, setting.series)
    found = [
        Addition(e, port, {q.name: search_range(q, known) for q in e.shapes})
        for e, port in _places(setting.model)
    ]
    # the base is bent to what is missing; where the best hypothesis has it, that shows as it is
    unbent = outcome.best.hypothesis.values_of(outcome.best.theta, base.hypothesis)
    references = [judge.look(base.hypothesis, at) for at in (base.theta, unbent)]
    if not outcome.best.hypothesis.added:
        references.pop()
    tangents = [Tangent.of(*judge.tangent(f)) for f in references]
    fits, worth = [], LOOSE * outcome.best.chi2
    for h in make_hypotheses(setting.model, setting.case, setting.series, [(a,) for a in found]):
        starts = [
            x
            for f, tangent in zip(references, tangents, strict=True)
            for x in _starts(h, f, tangent, judge.whiteners)
        ]
        if starts:
            fits.append(judge.fit(h, starts, worth=worth))
    fits.sort(key=lambda f: f.bic)
    fits = [_settled(judge, f) if k < FEW and f.chi2 < worth else f for k, f in enumerate(fits)]
    return replace(outcome, tried=(*outcome.tried, *fits))


def _settled(judge: Judge, f: Fit) -> Fit:
    """A fit that has gone on, also from where its resonances are broader or narrower: the base bends with
    them, and a descent creeps."""
    names = f.hypothesis.experiment.layout.names
    Q = np.array([n in f.hypothesis.shapes and n.endswith("_Q") for n in names])
    starts = [np.where(Q, f.theta * x, f.theta) for x in (1.0, 0.5, 2.0)]
    return min(f, judge.fit(f.hypothesis, starts, LONG), key=lambda f: f.bic)


def _starts(h: Hypothesis, f: Fit, tangent: Tangent, whiteners: Sequence[Whitener]) -> list[Array]:
    """Where a first order promises most, over a grid as fine as the resonances are narrow; and rows of which
    the most visible resonance is one or another member."""
    a = h.added[0]
    low, high = a.ranges["omega_1"]
    grids = [(np.exp(np.arange(np.log(low), np.log(high), STEP / Q)), Q) for Q in QUALITIES]
    if any(s.measure != "complex" for s in h.experiment.series):
        points = [{f"{a.id}_omega_1": float(w), f"{a.id}_Q": Q} for first, Q in grids for w in first]
        best = score(h, f.hypothesis, f.theta, tangent, whiteners, KEEP, points).starts
        return [h.place(f.hypothesis, f.theta, v) for _, v in best]
    seen = _Seen.of(h, f, tangent, whiteners)
    if seen is None:
        return []
    what, _ = _kind(a)
    chosen = _apart([t for first, Q in grids for t in seen.tried(first, Q, what)])[:KEEP]
    if what == MANY:
        line = max(t for first, Q in grids for t in seen.tried(first, Q, ONE))
        chosen += seen.tried(line[1] / np.arange(1, MODES + 1), line[2], what)
    names = [f"{a.id}_{n}" for n in ("omega_1", "Q", "a")]
    return [
        h.place(f.hypothesis, f.theta, dict(zip(names, values, strict=True)))
        for _, *values in chosen
        if values[-1]
    ]


Tried = tuple[float, float, float, float]
"""χ² that a start promises to explain, ω_1, Q, and height."""


@dataclass(frozen=True, eq=False)
class _Seen:
    """How the output sees a change of what a port has. One derivative by the model tells those of all shapes:
    each is in proportion to its resonances."""

    tangent: Tangent
    whiteners: Sequence[Whitener]
    omega: Sequence[Array]
    slopes: Sequence[Array]
    moving: bool

    @staticmethod
    def of(h: Hypothesis, f: Fit, tangent: Tangent, whiteners: Sequence[Whitener]) -> _Seen | None:
        a, e = h.added[0], h.experiment
        low, Q = a.ranges["omega_1"][0], QUALITIES[0]
        at = h.place(f.hypothesis, f.theta, {f"{a.id}_omega_1": low, f"{a.id}_Q": Q})
        what, moving = _kind(a)
        index = e.layout.wrt.index(f"{a.id}_a")
        omega = [2 * np.pi * s.inputs[e.model.axis] for s in e.series]
        slopes = []
        for k, (s, w) in enumerate(zip(e.series, omega, strict=True)):
            jac = e.prepared[k].jacobian(e.local(at, k), s.measure)[1][:, index]
            slopes.append((jac[0] + 1j * jac[-1]) / _row(w / low, Q, what, moving, 1j, np.exp))
        good = all(np.isfinite(x).all() for x in slopes)
        return _Seen(tangent, whiteners, omega, slopes, moving) if good else None

    def tried(self, first: Array, Q: float, what: str) -> list[Tried]:
        """What each of the shapes promises that physics allows."""
        columns = np.concatenate(
            [
                _white(v, x[:, None] * _row(w[:, None] / first, Q, what, self.moving, 1j, np.exp))
                for v, x, w in zip(self.whiteners, self.slopes, self.omega, strict=True)
            ]
        )
        rest = self.tangent.off(columns)
        size = np.sum(rest**2, axis=0) + 1e-300
        step = np.maximum(-(rest.T @ self.tangent.r) / size, 0.0)
        return [(float(d**2 * s), float(w), Q, float(d)) for d, s, w in zip(step, size, first, strict=True)]


def _apart(tries: Sequence[Tried]) -> list[Tried]:
    """The best first, without neighbours."""
    chosen: list[Tried] = []
    for t in sorted(tries, reverse=True)[:200]:
        if all(abs(np.log(t[1] / c[1])) > 1 / min(t[2], c[2]) for c in chosen):
            chosen.append(t)
    return chosen


def _white(w: Whitener, z: Array) -> Array:
    """Whitened columns (2n, k) of complex changes z (n, k)."""
    white = w.apply(np.stack([z.real.T, z.imag.T]))
    return np.asarray(white.transpose(0, 2, 1).reshape(-1, z.shape[1]))


def _row(u: Any, Q: Any, what: str, moving: bool, j: Any, exp: Any) -> Any:
    """Σ_n 1/(1 + jQ(u/n − n/u)), u = ω/ω_1, or waves; times ju where a stiffness moves.

    Waves: E = e^(−2jkl) is what a wave keeps on its way there and back, with kl = πu(1 − j/2Q) where ends are
    alike, −j cot kl = (1 + E)/(1 − E), and half of it where not, j tan kl = (1 − E)/(1 + E).
    """
    if what in (CLOSED, OPEN):
        path = (2 if what == CLOSED else 1) * np.pi * u
        E = exp(-path * (j + 1 / (2 * Q)))
        total = (1 + E) / (1 - E) if what == CLOSED else (1 - E) / (1 + E)
        total *= np.pi / ((2 if what == CLOSED else 4) * Q)
    else:
        total = sum(1 / (1 + j * Q * (u / n - n / u)) for n in range(1, 2 if what == ONE else MODES + 1))
    return total * (j * u if moving else 1)


def best_unlisted(outcome: Outcome) -> Fit | None:
    """The best of the descriptions made here."""
    return min((f for f in outcome.tried if is_unlisted(f)), key=lambda f: f.bic, default=None)


def cheaper(outcome: Outcome) -> tuple[Fit, float] | None:
    """What no catalogue holds, where it explains more than the best hypothesis, and by how much.

    By BIC, and for each effect what it must gain to be claimed; how rare such physics is counts in it.
    """
    first = best_unlisted(outcome)
    if first is None:
        return None
    if not outcome.best.hypothesis.added:  # nor may a few samples that stand alone speak for it
        more = outcome.base.bic - first.bic - ALARM
        more -= max(0.0, _lone(outcome, outcome.base) - _lone(outcome, first))
        more = min(more, refused(outcome) - first.bic)
    else:
        more = outcome.best.bic - first.bic + ALARM * (len(outcome.best.ids) - 1)
    return (first, more) if more > 0 else None


def refused(outcome: Outcome) -> float:
    """BIC of the best single named effect. Where the search would not claim it, as a colour or a smooth error
    may be all of it, what no catalogue holds has to do better."""
    return min((f.bic for f in outcome.tried if len(f.ids) == 1 and not is_unlisted(f)), default=np.inf)


def _lone(outcome: Outcome, f: Fit) -> float:
    """The part of −2 ln of a fit's likelihood that lone samples have."""
    prior = outcome.judge.prior
    whole, robust = (deviance(f.white, prior, robust=r) for r in (False, True))
    return (whole - robust) / outcome.judge.temper


def is_unlisted(fit: Fit) -> bool:
    """Whether it is one of the descriptions made here."""
    return any(a.effect.source == SOURCE for a in fit.hypothesis.added)


def _kind(a: Addition) -> tuple[str, bool]:
    """What is described, and whether of a stiffness."""
    return next(x for x in (*ROWS, ONE) if a.effect.says.startswith(x)), a.port.kind == "stiffness"


def _places(model: Model) -> Iterator[tuple[Effect, Port]]:
    """Each kind of resonance at each port that can have one."""
    kinds = {p.kind for p in model.ports}
    for port in model.ports:
        twice = port.kind == "stiffness" and "mechanical_impedance" in kinds
        if not twice and "omega" in dict(port.variables):
            for what, beside in WAYS.get(port.kind, ()):
                yield _resonance(port, what, beside), port


def _resonance(port: Port, what: str, beside: bool) -> Effect:
    """a Σ_n 1/(1 + jQ (ω/nω_1 − nω_1/ω)), or waves, added to the port's quantity, or `beside` it: to its
    inverse.

    A stiffness gets an impedance that resonates: jω/ω_1 times that.
    """

    def terms(at: Port, p: Any) -> Any:
        return p["a"] * _row(at["omega"] / p["omega_1"], p["Q"], what, at.kind == "stiffness", j, exp)

    def parallel(model: Model, at: Port, p: Any) -> Model:
        return model.extend(at.equation, lambda Z: Z / (1 + Z * terms(at, p)))

    return Effect(
        f"unknown_{port.name}",
        (port.kind,),
        f"{what} {'beside' if beside else 'in series with'} all that the {port.name} port has",
        SOURCE,
        (Strength("a", "1/({port})" if beside else "{port}", text="height of a resonance"),),
        parallel if beside else add(terms),
        (
            Shape("omega_1", "rad/s", "omega", 0.7 if what == ONE else 0.2, 1.5, text="the first"),
            Shape("Q", "1", "1", *((2.0, 500.0) if what == ONE else (3.0, 100.0)), 4, text="quality factor"),
        ),
        needs=("omega",),
        common=RARE if what in (ONE, MANY) else RARE**2,
    )
