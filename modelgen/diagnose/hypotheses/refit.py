"""Fits of hypotheses, all parameters free, from several starts; and the evidence that they give."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from modelgen.diagnose.hypotheses.bounds import at_ends, free, held_in, moving
from modelgen.diagnose.hypotheses.evidence import Level, Smooth, bic, effective
from modelgen.diagnose.hypotheses.hypothesis import Hypothesis, centre
from modelgen.diagnose.hypotheses.pasts import is_past, price, widths_of
from modelgen.errors import InputError
from modelgen.fit import GaussNewton
from modelgen.fit.whitener import Array, Whitener

SPRINT = 12
"""Steps after which descents from several starts are compared."""
HEAT, CROWD, SHARE = 3, 16, 5
"""Of more starts than CROWD, that many or every fifth (SHARE), whichever are more, go on after HEAT steps."""
LONG = 100
SETTLED, FINE = 1e-6, 1e-8
"""Relative decrease of r·r in a step at which descents end in records of thousands of samples; elsewhere, and
those of LONG steps or more."""
AHEAD = 1.2
"""Those within this factor of the best one's r·r go on."""
LOST = 2.0
"""χ² per sample, beyond which what descents have found may be far from the best there is."""
EASED = 6
"""Descents that go on as if all errors were independent."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted hypothesis: θ, whitened residuals (per recording) and BIC, all under one set of whiteners.

    BIC includes how common the physics is (twice its logarithm): between equals the commoner is named.
    """

    hypothesis: Hypothesis
    theta: Array
    white: tuple[Array, ...]
    bic: float
    parameters: int

    @property
    def chi2(self) -> float:
        with np.errstate(over="ignore"):  # inf, of a model that runs away
            return float(sum(np.sum(e**2) for e in self.white))

    @property
    def ids(self) -> tuple[str, ...]:
        return self.hypothesis.ids


FEW = 5
"""With fewer values to spare than this a fit without misfit says nothing."""


def spare_values(fit: Fit) -> int:
    """Data values beyond the number of fitted parameters."""
    return effective(fit.white) - fit.parameters


def enough(fit: Fit) -> bool:
    """Whether the data are enough for a fit without misfit to say something."""
    return spare_values(fit) >= FEW


def plain_white(fit: Fit) -> list[Array]:
    """Residuals of a fit, recording by recording, over the noise's level, colour left in."""
    e = fit.hypothesis.experiment
    return [replace(s.whitener, ar=None).apply(e.raw(fit.theta, k)) for k, s in enumerate(e.series)]


def mean_square(white: Sequence[Array]) -> float:
    """Mean square of residuals that weigh something; 1 where none does."""
    used = np.concatenate([e.ravel() for e in white])
    used = used[used != 0]
    with np.errstate(over="ignore"):  # a simulation that has run away
        return float(np.mean(used**2)) if used.size else 1.0


def misfit(fit: Fit) -> float:
    """Sum of squares of residuals over the noise's level, whatever the colour of what is left."""
    with np.errstate(over="ignore"):
        return float(sum(np.sum(e**2) for e in plain_white(fit)))


@dataclass(frozen=True)
class Judge:
    """What all hypotheses are fitted and compared under: whiteners and priors on the noise level.

    `temper` > 1 where even the best hypothesis leaves far more than noise: the correlation length of what is
    left, in samples, by which evidence is divided. Residuals of wrong models are no independent data.
    excess: BIC that a hypothesis (by its key) gains from errors of the motion alone; it is taken back. Less
    than 0 where they take it away.
    smooth: an instrument's error that nobody stated, which the whiteners count as noise.
    """

    whiteners: tuple[Whitener, ...]
    prior: tuple[Level, ...]
    temper: float = 1.0
    excess: Mapping[frozenset[tuple[str, str, int]], float] = field(default_factory=dict)
    smooth: Smooth | None = None

    def fit(
        self,
        h: Hypothesis,
        starts: Iterable[Array],
        iterations: int = 60,
        worth: float = np.inf,
        few: int = 1,
    ) -> Fit:
        """The best of local fits from `starts`; of several, those go on that a few steps have brought far (a
        `few` at any rate), and none that is not below `worth` (r·r) by then."""
        begun = [np.asarray(x) for x in starts]
        running = [x for x in begun if np.all(np.isfinite(x))]
        ends: list[tuple[float, Array]] = []
        if (len(running) > 1 or worth < np.inf) and iterations > SPRINT:
            ends = self._sprinted(h, running)
            if self._lost(h, ends):
                ends += self._descents(h, self._eased(h, running), SPRINT)
            running = [x for value, x in _leading(ends, few) if value <= worth]
        ends = self._descents(h, running, iterations) or ends
        return self.look(h, min(ends, key=lambda e: e[0])[1] if ends else begun[0])

    def revived(self, f: Fit, like: Fit) -> Fit:
        """A fit or, if that is better, one from where the parameters that descents have driven to a bound are
        as in the fit `like` it, without friction, how it slips has no slope that led back; or in the middle
        of their range, where kinks hold descents up and they say how a record began."""
        ends, pasts = held_in(f.hypothesis, f.theta), self._held(f)
        there = dict(zip(like.hypothesis.names, like.theta.tolist(), strict=True))
        there = {n: x for n, x in there.items() if n not in held_in(like.hypothesis, like.theta)} | pasts
        own = zip(f.hypothesis.names, f.theta.tolist(), strict=True)
        start = [there.get(n, x) if n in ends else x for n, x in own]
        if start == f.theta.tolist():
            return f
        return min(f, self.fit(f.hypothesis, [np.array(start)]), key=lambda f: f.bic)

    def _held(self, f: Fit) -> dict[str, float]:
        """The middle of the range of what the kinked effects of a fit were before the records."""
        h, layout = f.hypothesis, f.hypothesis.experiment.layout
        kinked = tuple(f"{a.id}_" for a in h.added if a.effect.secant)
        found = zip(h.names, layout.parameters, is_past(layout, h.pasts), strict=True)
        return {n: centre(p) for n, p, past in found if past and kinked and n.startswith(kinked)}

    def _sprinted(self, h: Hypothesis, starts: Sequence[Array]) -> list[tuple[float, Array]]:
        """(r·r, θ) where the first steps from `starts` lead, of a crowd those of the best after a few."""
        if len(starts) > CROWD:
            ends = sorted(self._descents(h, starts, HEAT), key=lambda e: e[0])
            starts = [x for _, x in ends[: max(CROWD, len(ends) // SHARE)]]
        return self._descents(h, starts, SPRINT)

    def _lost(self, h: Hypothesis, ends: Sequence[tuple[float, Array]]) -> bool:
        """Whether descents under a covariance ended far from noise."""
        least = LOST * sum(s.data.size for s in h.experiment.series)
        return any(w.root is not None for w in self.whiteners) and all(value > least for value, _ in ends)

    def _eased(self, h: Hypothesis, starts: Sequence[Array]) -> list[Array]:
        """Where descents lead as if all errors were independent: how far a start is wrong, a smooth error in
        the covariance hides, and a search gets lost."""
        plain = replace(self, whiteners=tuple(replace(w, root=None, ar=None) for w in self.whiteners))
        ends = _leading(plain._sprinted(h, starts), EASED)
        return [x for _, x in _leading(plain._descents(h, [x for _, x in ends], LONG), EASED)]

    def _descents(self, h: Hypothesis, starts: Sequence[Array], iterations: int) -> list[tuple[float, Array]]:
        """(r·r, θ) where descents from `starts` end; those that fail are left out."""
        loose = h.experiment.model.is_time_model and iterations < LONG
        local = GaussNewton(max_iter=iterations, tol=SETTLED if loose else FINE)
        if not starts:
            return []
        try:
            problem = h.experiment.problem(starts[0], self.whiteners)
        except InputError:
            return []
        ends = local.descents(problem, np.clip(np.array(starts), problem.lower, problem.upper))
        found = zip(ends.value.tolist(), ends.theta, strict=True)
        return [(value, theta) for value, theta in found if np.isfinite(value)]

    def look(self, h: Hypothesis, theta: Array) -> Fit:
        """Evidence of `h` at θ as it stands."""
        with np.errstate(all="ignore"):
            white = tuple(h.experiment.whitened(theta, self.whiteners))
        count = free(h.experiment.layout, theta, h.shapes, h.pasts)
        value = np.inf
        if all(np.all(np.isfinite(e)) for e in white):
            unknown, cost = self._pasts(h, theta, white) if h.pasts else (0, 0.0)
            value = bic(white, self.prior, count - unknown, temper=self.temper) + cost
            value += self.excess.get(h.key, 0.0) - 2 * h.log_common
        return Fit(h, theta, white, float(value), count)

    def _pasts(self, h: Hypothesis, theta: Array, white: Sequence[Array]) -> tuple[int, float]:
        """How many numbers say what the effects had been through before the records, and what they cost."""
        layout = h.experiment.layout
        moves = moving(layout, theta, h.shapes)
        past = is_past(layout, h.pasts) & moves
        if not past.any():
            return 0, 0.0
        count = int(past.sum())
        with np.errstate(all="ignore"):
            told = h.experiment.normal(theta, self.whiteners)[2]
        if not np.all(np.isfinite(told)):
            return 0, 0.0
        most = count * float(np.log(max(effective(white) / self.temper, 3.0)))
        widths = widths_of(layout, theta)
        return count, min(most, price(told, past, moves & ~past, widths, self.temper))

    def evidence(self, fit: Fit, gain: float) -> float:
        """What a fall of a fit's χ² by `gain` is in BIC: far from the data that is its logarithm."""
        left = max(fit.chi2 - gain, 1e-9 * fit.chi2)
        return effective(fit.white) / self.temper * float(np.log(fit.chi2 / left))

    def tangent(self, fit: Fit) -> tuple[Array, Array]:
        """Whitened residual and Jacobian over all recordings at the fit, null for what a bound holds against
        the residual's will: there an effect may do what the parameter must not."""
        e = fit.hypothesis.experiment
        r, J = e.linearised(fit.theta, self.whiteners)
        with np.errstate(all="ignore"):
            held = at_ends(e.layout, fit.theta) @ np.array([1, -1]) * (r @ J) > 0
        return r, np.where(held, 0.0, J)


@dataclass(frozen=True)
class Remembering(Judge):
    """A judge who does not fit again, in one and the same series, what has been fitted from the same starts.

    done: those fits, by the hypothesis' key and its starts.
    """

    done: dict[tuple[object, ...], Fit] = field(default_factory=dict)

    def fit(
        self,
        h: Hypothesis,
        starts: Iterable[Array],
        iterations: int = 60,
        worth: float = np.inf,
        few: int = 1,
    ) -> Fit:
        begun = [np.asarray(x) for x in starts]
        key = (h.key, iterations, few, *(x.tobytes() for x in begun))
        if key not in self.done:
            self.done[key] = super().fit(h, begun, iterations, worth, few)
        return self.done[key]


def _leading(ends: Sequence[tuple[float, Array]], few: int = 1) -> list[tuple[float, Array]]:
    """Those of `ends`, best first, that are near the best one or among the first few, without what is the
    same."""
    ends = sorted(ends, key=lambda e: e[0])
    apart = [e for k, e in enumerate(ends) if k == 0 or e[0] > (1 + 1e-6) * ends[k - 1][0]]
    return [e for k, e in enumerate(apart) if e[0] <= AHEAD * ends[0][0] or k < few]


def refine(judge: Judge, fits: Sequence[Fit]) -> list[Fit]:
    """Fits continued under another judge."""
    return [judge.fit(f.hypothesis, [f.theta]) for f in fits]
