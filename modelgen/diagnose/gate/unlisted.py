"""Physics that no catalogue holds, as rivals of the named effects: resonances of other places and orders.

A cable's trap, a row of modes or a standing wave is fitted, at some price, by a listed resonance or by two
effects in one: that is for the evidence to say. Each of these is a description with an id `unknown_<port>`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modelgen.diagnose.gate.describe import SOURCE
from modelgen.diagnose.gate.resonant import FACTORS, MANY, MODES, ONE, ROWS, kind, places, row
from modelgen.diagnose.hypotheses.addition import Addition
from modelgen.diagnose.hypotheses.evidence import deviance
from modelgen.diagnose.hypotheses.hypothesis import Hypothesis, make_hypotheses
from modelgen.diagnose.hypotheses.refit import LONG, Fit, Judge
from modelgen.diagnose.hypotheses.scales import record_scales
from modelgen.diagnose.hypotheses.setting import ALARM, Outcome, Setting
from modelgen.diagnose.search.screen import Tangent, score
from modelgen.effects import search_range
from modelgen.fit.whitener import Array, Whitener

FEW = 2
"""The best kinds of resonances, whose fits go on."""
LOOSE = 2.0
"""Those that after a few steps leave so many times the χ² of the best named effects do not."""
CREEPING = 5.0
"""Up to so many times that, one descent of each is given time: far from the data a base bends slowly."""
KEEP = 5
"""Starts for each kind of resonance and each state of the base: rows have many local optima."""
ALONE = 15.0
"""ΔBIC that they must gain to be claimed where no named effect is: more places and shapes are tried."""
TIED = 2.0
"""ΔBIC that is no evidence for the one of two descriptions (Kass & Raftery 1995)."""
QUALITIES = (4.0, 12.0, 36.0)
BROAD = (1.0, *QUALITIES)
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
        for e, port in places(setting.model)
    ]
    # the base is bent to what is missing; where the best hypothesis has it, that shows as it is
    unbent = outcome.best.hypothesis.values_of(outcome.best.theta, base.hypothesis)
    references = [judge.look(base.hypothesis, at) for at in (base.theta, unbent)]
    if not outcome.best.hypothesis.added:
        references.pop()
    tangents = [Tangent.of(*judge.tangent(f)) for f in references]
    worth = LOOSE * outcome.best.chi2

    def fitted(h: Hypothesis) -> list[Fit]:
        starts = _starts(h, references, tangents, judge.whiteners)
        return [judge.fit(h, starts, worth=worth)] if starts else []

    made = make_hypotheses(setting.model, setting.case, setting.series, [(a,) for a in found])
    fits = sorted((f for fits in setting.each(fitted, made) for f in fits), key=lambda f: f.bic)
    fits = [_settled(judge, f, worth) if k < FEW else f for k, f in enumerate(fits)]
    return replace(outcome, tried=(*outcome.tried, *fits))


def _settled(judge: Judge, f: Fit, worth: float) -> Fit:
    """A fit that has gone on and, where it is below `worth` then, also from where its resonances are broader
    or narrower: the base bends with them, and a descent creeps."""
    if worth <= f.chi2 < CREEPING * worth:
        f = min(f, judge.fit(f.hypothesis, [f.theta], LONG), key=lambda f: f.bic)
    if f.chi2 >= worth:
        return f
    names = f.hypothesis.experiment.layout.names
    Q = np.array([n in f.hypothesis.shapes and n.endswith("_Q") for n in names])
    starts = [np.where(Q, f.theta * x, f.theta) for x in (1.0, 0.5, 2.0)]
    return min(f, judge.fit(f.hypothesis, starts, LONG), key=lambda f: f.bic)


def _starts(
    h: Hypothesis, references: Sequence[Fit], tangents: Sequence[Tangent], whiteners: Sequence[Whitener]
) -> list[Array]:
    """Where a first order beside each of the references promises most, over a grid as fine as the resonances
    are narrow; and rows of which the most visible resonance is one or another member."""
    a = h.added[0]
    low, high = a.ranges["omega_1"]
    least, most = a.ranges["Q"]
    tried = [Q for Q in (QUALITIES if kind(a)[0] in ROWS else BROAD) if least <= Q <= most]
    grids = [(np.exp(np.arange(np.log(low), np.log(high), STEP / Q)), Q) for Q in tried]
    if any(s.measure != "complex" for s in h.experiment.series):
        points = [{f"{a.id}_omega_1": float(w), f"{a.id}_Q": Q} for first, Q in grids for w in first]
        return [
            h.place(f.hypothesis, f.theta, v)
            for f, tangent in zip(references, tangents, strict=True)
            for _, v in score(h, f.hypothesis, f.theta, tangent, whiteners, KEEP, points).starts
        ]
    seen = [_Seen.of(h, f, t, whiteners) for f, t in zip(references, tangents, strict=True)]
    names = [f"{a.id}_{n}" for n in ("omega_1", "Q", *(q.name for q in a.effect.strengths))]
    return [
        h.place(f.hypothesis, f.theta, dict(zip(names, values, strict=True)))
        for f, own in zip(references, _promising(h, seen, grids), strict=True)
        for _, *values in own
        if values[2]
    ]


def _promising(
    h: Hypothesis, seen: Sequence[_Seen | None], grids: Sequence[tuple[Array, float]]
) -> list[list[Tried]]:
    """Of each reference as it is `seen`, the best of what lies on the grids."""
    tries: list[list[Tried]] = [[] for _ in seen]
    for first, Q in grids:
        shapes = _shapes(h, first, Q)
        for own, eye in zip(tries, seen, strict=True):
            own += eye.tried(first, Q, shapes) if eye else []
    chosen = [_apart(own, KEEP) for own in tries]
    if kind(h.added[0])[0] == MANY:
        single = [(first, Q, _shapes(h, first, Q, ONE)) for first, Q in grids]
        for own, eye in zip(chosen, seen, strict=True):
            if eye:
                line = max(t for grid in single for t in eye.tried(*grid))
                first = line[1] / np.arange(1, MODES + 1)
                own += eye.tried(first, line[2], _shapes(h, first, line[2]))
    return chosen


def _shapes(h: Hypothesis, first: Array, Q: float, what: str = "") -> list[Array]:
    """(m, n) in each recording, resonances of height 1 at each of `first` (m,); `what`: of another kind."""
    own, moving = kind(h.added[0])
    omega = [2 * np.pi * s.inputs[h.experiment.model.axis] for s in h.experiment.series]
    return [row(w / first[:, None], Q, what or own, moving, 1j, np.exp) for w in omega]


Tried = tuple[float, ...]
"""χ² that a start promises to explain, ω_1, Q, and height; of errors of the chain its imaginary part, too."""


@dataclass(frozen=True, eq=False)
class _Seen:
    """How the output sees a change of what a port has. One derivative by the model tells those of all shapes:
    each is in proportion to its resonances."""

    tangent: Tangent
    whiteners: Sequence[Whitener]
    slopes: Sequence[Array]
    factor: bool

    @staticmethod
    def of(h: Hypothesis, f: Fit, tangent: Tangent, whiteners: Sequence[Whitener]) -> _Seen | None:
        a, e = h.added[0], h.experiment
        low, Q = a.ranges["omega_1"][0], QUALITIES[0]
        at = h.place(f.hypothesis, f.theta, {f"{a.id}_omega_1": low, f"{a.id}_Q": Q})
        index = e.layout.wrt.index(f"{a.id}_a")
        slopes = []
        for k, (s, (shape,)) in enumerate(zip(e.series, _shapes(h, np.array([low]), Q), strict=True)):
            jac = e.prepared[k].jacobian(e.local(at, k), s.measure)[1][:, index]
            slopes.append((jac[0] + 1j * jac[-1]) / shape)
        good = all(np.isfinite(x).all() for x in slopes)
        return _Seen(tangent, whiteners, slopes, kind(a)[0] in FACTORS) if good else None

    def tried(self, first: Array, Q: float, shapes: Sequence[Array]) -> list[Tried]:
        """What each of the shapes promises that physics allows."""
        among, toward, _ = self.tangent.products(self._columns(shapes))
        size, along = among[:, 0, 0] + 1e-300, -toward[:, 0]
        if not self.factor:
            step = np.maximum(along / size, 0.0)
            found = zip(step**2 * size, first, step, strict=True)
            return [(float(gain), float(w), Q, float(a)) for gain, w, a in found]
        mixed, across, rest_size = among[:, 0, 1], -toward[:, 1], among[:, 1, 1] + 1e-300
        det = np.maximum(size * rest_size - mixed**2, 1e-9 * size * rest_size)
        a, b = (along * rest_size - across * mixed) / det, (across * size - along * mixed) / det
        gain = a * along + b * across
        return [tuple(map(float, (g, w, Q, x, y))) for g, w, x, y in zip(gain, first, a, b, strict=True)]

    def _columns(self, shapes: Sequence[Array]) -> Array:
        """Whitened columns (m, N, k) of resonances of height 1, and j for a factor."""
        found = []
        for v, slope, shape in zip(self.whiteners, self.slopes, shapes, strict=True):
            z = slope * shape
            found.append(np.stack([_white(v, x) for x in ((z, 1j * z) if self.factor else (z,))], axis=1))
        return np.moveaxis(np.concatenate(found, axis=-1), 1, 2)


def _apart(tries: Sequence[Tried], count: int) -> list[Tried]:
    """The best `count`, the very best first, without neighbours."""
    chosen: list[Tried] = []
    for t in sorted(tries, reverse=True)[:200]:
        if len(chosen) == count:
            break
        if all(abs(np.log(t[1] / c[1])) > 1 / min(t[2], c[2]) for c in chosen):
            chosen.append(t)
    return chosen


def _white(w: Whitener, z: Array) -> Array:
    """Whitened complex changes z (m, n), as rows (m, 2n)."""
    return np.concatenate(w.apply(np.stack([z.real, z.imag])), axis=1)


def best_unlisted(outcome: Outcome) -> Fit | None:
    """The best of the descriptions made here; of those that the data do not tell from it the plainest: waves
    of which but one resonance is seen are a resonance."""
    found = [f for f in outcome.tried if is_unlisted(f)]
    least = min((f.bic for f in found), default=np.inf)
    tied = [f for f in found if f.bic - least < TIED]
    return min(tied, key=lambda f: (-_common(f), f.bic), default=None)


def _common(f: Fit) -> float:
    return float(np.prod([a.effect.common for a in f.hypothesis.added]))


def cheaper(outcome: Outcome) -> tuple[Fit, float] | None:
    """What no catalogue holds, where it explains more than the best hypothesis, and by how much.

    By BIC, and for each effect what it must gain to be claimed; how rare such physics is counts in it.
    """
    first = best_unlisted(outcome)
    if first is None:
        return None
    if not outcome.best.hypothesis.added:  # nor may a few samples that stand alone speak for it
        more = outcome.base.bic - first.bic - ALONE
        more -= max(0.0, _lone(outcome, outcome.base) - _lone(outcome, first))
        more = min(more, refused(outcome) - first.bic)
    else:
        more = outcome.best.bic - first.bic + ALARM * (len(outcome.best.ids) - 1)
    return (first, more) if more > 0 else None


def named_rather(outcome: Outcome) -> Outcome:
    """The outcome with one more named effect, where the best of these are too few, as what no catalogue holds
    does better, and one more does better still: what the search had doubted, a colour of the noise, is no
    account beside either."""
    rival, best = cheaper(outcome), outcome.best
    if rival is None or not best.ids:
        return outcome
    more = [f for f in outcome.tried if len(f.ids) == len(best.ids) + 1 and not is_unlisted(f)]
    first = min(more, key=lambda f: f.bic, default=best)
    sure = first.bic < min(rival[0].bic, best.bic - ALARM)
    return replace(outcome, best=first) if sure else outcome


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
