"""What all optimisers share: how a run is started, watched, interrupted and chained, and what comes out."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from numbers import Integral, Real

import numpy as np
from numpy.typing import ArrayLike

from modelgen.errors import InputError
from modelgen.fit.problem import Matrix, Normal, Problem, Vector

Progress = Callable[[float, float], None]  # fraction done, best r·r so far
Seed = int | np.random.Generator | None

FEASIBLE = 1e-8  # violation of a constraint, in units of the parameters' widths, that still passes
OUTSIDE = 1e200  # points outside the constraints rank behind all inside (Deb 2000), by their violation


class Reason(Enum):
    """Why a run ended. The values are the sentences that the user reads."""

    CONVERGED = "converged: the best step left changes nothing that matters"
    COLLAPSED = "converged: the swarm has drawn together in one place"
    STALLED = "stopped: no step from here improves the fit, though the slope is not zero"
    BUDGET = "stopped: the allowed iterations are used up"
    INFEASIBLE = "failed: no point was found that meets the constraints"
    NOT_FINITE = "failed: the model gives no finite value where the search begins"
    FAILED = "failed: the solver gave up"
    INTERRUPTED = "interrupted: the best point so far is kept"


@dataclass(frozen=True)
class Outcome:
    """What a run found: θ (p,), its r·r, the work done and why it ended.

    history: best r·r after each iteration. population: the swarm's own best points, or the end of each start
    (m, p). reached, starts: of a multi-start, how many of its starts ended at this optimum.
    """

    theta: Vector
    value: float
    evaluations: int
    iterations: int
    reason: Reason
    history: tuple[float, ...] = ()
    population: Matrix | None = None
    reached: int = 1
    starts: int = 1

    @property
    def converged(self) -> bool:
        """Whether the run ended at an optimum."""
        return self.reason in (Reason.CONVERGED, Reason.COLLAPSED)


class Watch:
    """What one run has seen so far: counts evaluations, keeps the best point, reports progress."""

    def __init__(self, problem: Problem, start: Vector, progress: Progress | None) -> None:
        self.problem, self.progress = problem, progress
        self.theta, self.value = start.copy(), np.inf
        self.evaluations = self.iterations = 0
        self.history: list[float] = []
        self.population: Matrix | None = None

    def values(self, thetas: Matrix) -> Vector:
        """r·r at each row (m,), those outside the constraints ranked behind all others."""
        merits = self.problem.values(thetas)
        if self.problem.constraints:
            merits = np.array([self.merit(t, f) for t, f in zip(thetas, merits, strict=True)])
        self.evaluations += len(merits)
        best = int(np.argmin(merits))
        self.keep(thetas[best], float(merits[best]))
        return merits

    def normal_equations(self, theta: Vector) -> Normal:
        """r·r, Jᵀr, JᵀJ at θ."""
        normal = self.problem.normal_equations(theta)
        self.evaluations += 1
        if np.all((self.problem.lower <= theta) & (theta <= self.problem.upper)):  # else a look beyond
            self.keep(theta, self.merit(theta, normal[0]))
        return normal

    def absorb(self, outcome: Outcome) -> None:
        """Take over what a run inside this one has found."""
        self.evaluations += outcome.evaluations
        self.iterations += outcome.iterations
        self.history += [min(self.value, value) for value in outcome.history]
        self.keep(outcome.theta, self.merit(outcome.theta, outcome.value))

    def tell(self, done: int, of: int) -> None:
        """End of iteration `done`: note the best value, and report it."""
        self.iterations = done
        self.history.append(self.value)
        if self.progress is not None:
            self.progress(min(done / of, 1.0), self.value)

    def outcome(self, reason: Reason) -> Outcome:
        """The best point seen, with the reason to stop."""
        value = self.problem.value(self.theta) if OUTSIDE <= self.value < np.inf else self.value
        if value < self.value and reason is not Reason.INTERRUPTED:
            reason = Reason.INFEASIBLE
        return Outcome(
            self.theta, value, self.evaluations, self.iterations, reason, tuple(self.history), self.population
        )

    def merit(self, theta: Vector, value: float) -> float:
        """r·r for ranking: a point outside the constraints is worse than any inside."""
        if not self.problem.constraints:
            return value
        violation = self.problem.violation(theta)
        return value if violation <= FEASIBLE else OUTSIDE * (1 + min(violation, 1e100))

    def keep(self, theta: Vector, value: float) -> None:
        """Note a point, if it is the best so far."""
        if value < self.value:
            self.theta, self.value = theta.copy(), value


class Method(ABC):
    """An optimiser: settings only, to be used again and again. `a >> b` runs b from a's result."""

    def run(
        self,
        problem: Problem,
        start: ArrayLike | None = None,
        progress: Progress | None = None,
        seed: Seed = None,
    ) -> Outcome:
        """Search from `start` (p,), by default the problem's own, and return the best point seen.

        progress: called with the fraction done and the best r·r. seed: overrides the method's own.
        Ctrl-C ends the run, not the program. Raises InputError for a start outside the bounds.
        """
        begin = problem.start if start is None else _started(problem, start)
        watch = Watch(problem, begin, progress)
        try:
            with np.errstate(all="ignore"):
                outcome = self._search(problem, begin, watch, seed)
        except KeyboardInterrupt:
            outcome = watch.outcome(Reason.INTERRUPTED)
        if progress is not None:
            progress(1.0, outcome.value)
        return outcome

    @abstractmethod
    def _search(self, problem: Problem, start: Vector, watch: Watch, seed: Seed) -> Outcome:
        """Do the work; every evaluation goes through `watch`."""

    @property
    @abstractmethod
    def text(self) -> str:
        """The method in words, for a report."""

    def __rshift__(self, other: Method) -> Chain:
        if not isinstance(other, Method):
            return NotImplemented
        return Chain((*_links(self), *_links(other)))


@dataclass(frozen=True)
class Chain(Method):
    """Methods one after the other, each from the best point of those before it."""

    links: tuple[Method, ...]

    @property
    def text(self) -> str:
        return ", then ".join(link.text for link in self.links)

    def _search(self, problem: Problem, start: Vector, watch: Watch, seed: Seed) -> Outcome:
        reason, last = Reason.CONVERGED, None
        for done, link in enumerate(self.links):
            last = link.run(problem, start, part(watch.progress, done, len(self.links)), seed)
            watch.absorb(last)
            reason, start = last.reason, watch.theta
            if reason is Reason.INTERRUPTED:
                break
        whole = watch.outcome(reason)
        return whole if last is None else replace(
            whole, population=last.population, reached=last.reached, starts=last.starts
        )  # fmt: skip


def part(progress: Progress | None, done: int, of: int) -> Progress | None:
    """Progress of one part out of `of`, after `done` others."""
    if progress is None:
        return None
    return lambda fraction, value: progress((done + fraction) / of, value)


def _links(method: Method) -> tuple[Method, ...]:
    return method.links if isinstance(method, Chain) else (method,)


def _started(problem: Problem, start: ArrayLike) -> Vector:
    theta = np.array(start, dtype=float)
    fits = theta.shape == problem.start.shape
    if fits and np.all((problem.lower <= theta) & (theta <= problem.upper) & np.isfinite(theta)):
        return theta
    return replace(problem, start=theta).start  # says what is wrong with it


def at_least(low: float, **settings: float) -> None:
    """Raise InputError for a setting that is no number, or one below `low`."""
    for name, value in settings.items():
        if isinstance(value, bool) or not isinstance(value, Real):
            raise InputError(f"setting {name} = {value!r}: a number is wanted")
        if not value >= low:
            raise InputError(f"setting {name} = {value:g}: at least {low:g} is wanted")


def whole(low: int, **settings: int) -> None:
    """Raise InputError for a setting that is no whole number, or one below `low`."""
    for name, value in settings.items():
        if not isinstance(value, Integral):
            raise InputError(f"setting {name} = {value!r}: a whole number is wanted")
    at_least(low, **settings)
