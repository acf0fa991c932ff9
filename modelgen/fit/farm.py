"""Work that outgrows one machine: starts, profiles, Monte Carlo and whole cases as tasks of an executor.

Any `concurrent.futures.Executor` will do: threads, processes, a Dask cluster's. A task holds all it needs,
has no effect but its result, and is cut the same way whatever the number of workers: it can be run again
where a worker was lost, and the results are the same.
"""

from __future__ import annotations

import multiprocessing
import pickle
import signal
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache
from multiprocessing import resource_tracker
from typing import TYPE_CHECKING, Any

import numpy as np

from modelgen.errors import InputError, ToolError
from modelgen.fit.gauss_newton import GaussNewton
from modelgen.fit.likelihood import Profile, profile
from modelgen.fit.method import Method, Outcome
from modelgen.fit.pool import cores
from modelgen.fit.problem import Matrix, Problem, Vector
from modelgen.language import Model
from modelgen.recordings import Case

if TYPE_CHECKING:
    from modelgen.codegen import Function
    from modelgen.fit.experiment import Experiment
    from modelgen.fit.result import FitResult

STARTS_A_TASK = 4
DRAWS_A_TASK = 50_000
TIMEOUT = "15s"


@dataclass(frozen=True)
class Farm:
    """Runs the starts of a problem on `executor`. The problem travels as what it is made from."""

    executor: Executor
    origin: bytes

    @classmethod
    def of(cls, executor: Executor, model: Model, case: Case, constrained: bool = False) -> Farm:
        return cls(executor, packed(model, case, constrained))

    def ends(
        self, problem: Problem, inner: Method, begins: Matrix, rng: np.random.Generator
    ) -> list[Outcome]:
        """The outcome from each start, in order; each has a generator of its own."""
        seeds = [int(s) for s in rng.integers(2**63, size=len(begins))]
        box = (problem.lower, problem.upper, problem.start)
        futures = [
            self.executor.submit(_ends, self.origin, box, inner, begins[k:upto], seeds[k:upto])
            for k in range(0, len(begins), STARTS_A_TASK)
            for upto in [k + STARTS_A_TASK]
        ]
        return [end for future in futures for end in future.result()]


def packed(*things: Any) -> bytes:
    """Bytes of a model, a case, …, also of the functions that a user's file defines."""
    import cloudpickle

    return bytes(cloudpickle.dumps([replace(x, builder=None) if isinstance(x, Model) else x for x in things]))


@lru_cache(maxsize=8)
def _problem(origin: bytes) -> Problem:
    ex, _, constrained = _experiment(origin)
    return ex.problem(constrained=constrained)


def _experiment(origin: bytes) -> tuple[Experiment, Case, bool]:
    from modelgen.fit.experiment import experiment
    from modelgen.fit.series import make_series

    model, case, constrained = pickle.loads(origin)
    return experiment(model, case, [make_series(model, case, r) for r in case.fit]), case, constrained


def _ends(
    origin: bytes, box: tuple[Vector, Vector, Vector], inner: Method, begins: Matrix, seeds: Sequence[int]
) -> list[Outcome]:
    problem = replace(_problem(origin), lower=box[0], upper=box[1], start=box[2])
    return [inner.run(problem, begin, None, seed) for begin, seed in zip(begins, seeds, strict=True)]


def profiles(
    model: Model,
    case: Case,
    found: FitResult,
    names: Sequence[str] = (),
    *,
    level: float = 0.95,
    executor: Executor,
) -> list[Profile]:
    """Profile likelihoods of the parameters `names` (all, if none are named) about a fit, one task each.

    Raises InputError for an unknown parameter.
    """
    origin = packed(model, case, False)
    optimum = tuple(e.value for e in found.parameters)
    wanted = [found[n].name for n in names] or [e.name for e in found.parameters]
    futures = [executor.submit(_profile, origin, name, optimum, level) for name in wanted]
    return [f.result() for f in futures]


def _profile(origin: bytes, name: str, optimum: tuple[float, ...], level: float) -> Profile:
    problem, stated = _ended(origin, optimum)
    return profile(problem, name, optimum, level=level, estimate_noise=not stated)


@lru_cache(maxsize=8)
def _ended(origin: bytes, optimum: tuple[float, ...]) -> tuple[Problem, bool]:
    """The problem with which a fit ended at `optimum`, and whether the noise of all recordings is stated."""
    from modelgen.fit.motion import with_motion

    ex, case, constrained = _experiment(origin)
    # the fit took errors of the motion from where it ended without them
    before = GaussNewton().run(ex.problem(constrained=constrained), optimum)
    moved = with_motion(ex, case, case.fit, before.theta)
    return moved.problem(constrained=constrained), all(s.stated for s in ex.series)


def draw_many(function: Function, draws: Mapping[str, Any], executor: Executor) -> Any:
    """The first output of the function's model (m,) at m draws, some thousands a task."""
    (size,) = {len(x) for x in draws.values()}
    origin = packed(function.model)
    futures = [
        executor.submit(_drawn, origin, {n: x[k : k + DRAWS_A_TASK] for n, x in draws.items()})
        for k in range(0, size, DRAWS_A_TASK)
    ]
    return np.concatenate([f.result() for f in futures])


def _drawn(origin: bytes, draws: Mapping[str, Any]) -> Any:
    from modelgen.codegen import build

    (model,) = pickle.loads(origin)
    out = build(model, wait=True)(**draws)
    return np.asarray(out[0] if isinstance(out, tuple) else out)


def fit_cases(
    cases: Sequence[tuple[Model, Case]], method: Any = None, seed: int = 0, *, executor: Executor
) -> list[FitResult | InputError]:
    """Fit each case, a task each, in order. One that cannot be fitted gives its error, and stops no other."""
    futures = [executor.submit(_fitted, packed(model, case, method), seed) for model, case in cases]
    return [f.result() for f in futures]


def _fitted(origin: bytes, seed: int) -> FitResult | InputError:
    from modelgen.fit.fitting import fit

    model, case, method = pickle.loads(origin)
    try:
        return fit(model, case, method, seed)
    except InputError as why:
        return why


@contextmanager
def process_executor(tasks: int) -> Iterator[Executor]:
    """A process for each core that this one may use, at most `tasks`. Raises ToolError when one dies."""
    workers = max(1, min(cores(), tasks))
    others = set(multiprocessing.active_children())
    with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn")) as pool:
        # Ctrl-C is for the process that waits: workers start with it blocked, and keep that
        resource_tracker.ensure_running()  # it would unblock it
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        for _ in range(workers):
            pool.submit(int)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        try:
            yield pool
        except BrokenExecutor as why:
            raise ToolError("a worker process died, as when the memory is full") from why
        except BaseException:
            for worker in set(multiprocessing.active_children()) - others:
                worker.terminate()
            raise


@contextmanager
def dask_executor(address: str) -> Iterator[Executor]:
    """The executor of the Dask cluster at `address`, such as "tcp://10.0.0.1:8786".

    A task whose worker dies is run again on another. Raises InputError when the extra is not installed,
    ToolError when no scheduler answers, or the cluster is lost.
    """
    try:
        from distributed import Client, KilledWorker
        from distributed.comm import CommClosedError
    except ImportError:
        raise InputError(f"--dask {address}: Dask is not installed; pip install distributed") from None
    try:
        client = Client(address, timeout=TIMEOUT)
    except (OSError, ValueError, TimeoutError) as why:
        text = " ".join(str(why).split()) or type(why).__name__
        raise ToolError(f"--dask {address}: no scheduler answers ({text})") from why
    with client:
        try:
            yield client.get_executor(pure=False)
        except (KilledWorker, CommClosedError, CancelledError) as why:
            text = " ".join(str(why).split()) or type(why).__name__
            raise ToolError(f"--dask {address}: the cluster lost the work ({text})") from why
