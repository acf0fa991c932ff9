"""The optimisers find known optima, at bounds too, whatever the units, and survive bad models and users."""

import os
import signal
import threading
import time

import numpy as np
import pytest
from fit_problems import T, decay, linear, problem, rosenbrock
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares, lsq_linear

from modelgen.errors import InputError
from modelgen.fit import IPOPT, PSO, GaussNewton, Inequality, MultiStart, Problem, Reason

LOCAL = [GaussNewton(), IPOPT()]
ALL = [GaussNewton(), IPOPT(), PSO(30, 80) >> GaussNewton(), MultiStart(starts=4)]
TRUTH = np.array([3.0, 1.5, 0.5])
DATA = TRUTH[0] * np.exp(-TRUTH[1] * T) + TRUTH[2]


def ids(method: object) -> str:
    return type(method).__name__


@pytest.mark.parametrize("method", [*ALL, IPOPT("exact"), IPOPT("limited-memory")], ids=ids)
def test_rosenbrock(method) -> None:
    found = method.run(rosenbrock())
    np.testing.assert_allclose(found.theta, 1, atol=1e-7)
    assert found.converged


@pytest.mark.parametrize("method", ALL, ids=ids)
def test_rosenbrock_stopped_by_a_bound(method) -> None:
    found = method.run(rosenbrock(upper=(0.5, 5)))
    np.testing.assert_allclose(found.theta, [0.5, 0.25], atol=1e-7)
    assert found.converged


@pytest.mark.parametrize(
    "make", [lambda P: P, lambda P: problem("a k c", P.lower, P.upper, P.start, P.residual)]
)
@pytest.mark.parametrize("method", ALL, ids=ids)
def test_exponential_with_and_without_derivatives(method, make) -> None:
    noisy = DATA + 0.1 * np.random.default_rng(3).standard_normal(T.size)
    P = make(decay(noisy, 0.1))
    wanted = least_squares(P.residual, P.start, bounds=(P.lower, P.upper), xtol=1e-15, ftol=1e-15, gtol=1e-15)
    found = method.run(P)
    assert found.value == pytest.approx(2 * wanted.cost, rel=1e-9)
    np.testing.assert_allclose(found.theta, wanted.x, rtol=1e-5)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(2, 8))
def test_bounded_linear_problems_agree_with_bvls(seed: int, p: int) -> None:
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((p + 3, p)) @ np.diag(10.0 ** rng.uniform(-6, 6, p))
    b = rng.standard_normal(p + 3)
    free = np.linalg.lstsq(A, b, rcond=None)[0]
    lower = np.minimum(free, 0) - np.abs(free) * rng.uniform(
        -0.5, 1, p
    )  # some bounds cut the free optimum off
    upper = lower + np.abs(free) * rng.uniform(0.2, 2, p)
    P = linear(A, b, lower, upper, np.nan)
    wanted = lsq_linear(
        A * np.abs(free), b, (lower / np.abs(free), upper / np.abs(free)), method="bvls", tol=1e-14
    )
    found = GaussNewton().run(P)
    assert found.value == pytest.approx(2 * wanted.cost, rel=1e-9)
    np.testing.assert_allclose(found.theta / np.abs(free), wanted.x, atol=1e-5)
    assert found.converged


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(2, 6))
def test_gauss_newton_never_stops_short_of_an_optimum(seed: int, p: int) -> None:
    # strongly coupled and saturating: many a step meets several bounds at once
    rng = np.random.default_rng(seed)
    A, B, b = (
        rng.standard_normal((2 * p, 2 * p)),
        rng.standard_normal((2 * p, p)),
        3 * rng.standard_normal(2 * p),
    )

    def linearise(x):
        y = np.tanh(B @ x)
        return A @ y - b, A @ ((1 - y**2)[:, None] * B)

    P = problem(
        " ".join("abcdef"[:p]), -1, 1, rng.uniform(-1, 1, p), lambda x: linearise(x)[0], linearise=linearise
    )
    found = GaussNewton(max_iter=1000).run(P)
    assume(found.converged)  # a search that used up its steps says so
    f, g, _ = P.normal_equations(found.theta)
    pull = np.where(found.theta <= -1, np.minimum(g, 0), np.where(found.theta >= 1, np.maximum(g, 0), g))
    assert np.abs(pull).max() <= 1e-4 * np.linalg.norm(P.jacobian(found.theta)[1], axis=0).max() * np.sqrt(f)


def test_ipopt_agrees_with_bvls() -> None:
    rng = np.random.default_rng(5)
    A, b = rng.standard_normal((9, 5)), rng.standard_normal(9)
    wanted = lsq_linear(A, b, (-0.1, 0.1), method="bvls")
    found = IPOPT().run(linear(A, b, -0.1, 0.1, 0))
    assert np.any(np.abs(np.abs(wanted.x) - 0.1) < 1e-12)
    np.testing.assert_allclose(found.theta, wanted.x, atol=1e-7)


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.floats(-8, 8), min_size=3, max_size=3),
    st.lists(st.floats(-3, 3), min_size=3, max_size=3),
    st.sampled_from([GaussNewton(), IPOPT(), PSO(25, 200)]),
)
def test_affine_change_of_parameters_does_not_move_the_optimum(decades, shifts, method) -> None:
    noisy = DATA + 0.1 * np.random.default_rng(3).standard_normal(T.size)
    P = decay(noisy, 0.1, batch=False, lower=(0.1, 0.1, -5))
    unit = 10.0 ** np.array(decades)
    shift = np.array(shifts)

    def back(y):
        return y / unit - shift

    Q = Problem(
        P.names, P.units, (P.lower + shift) * unit, (P.upper + shift) * unit, (P.start + shift) * unit,
        lambda y: P.residual(back(y)), lambda y: (P.residual(back(y)), P.jacobian(back(y))[1] / unit),
        n_data=T.size,
    )  # fmt: skip
    a, b = method.run(P), method.run(Q)
    assert b.value == pytest.approx(a.value, rel=1e-6)
    np.testing.assert_allclose(back(b.theta), a.theta, rtol=1e-3 if isinstance(method, PSO) else 1e-6)


@pytest.mark.parametrize(
    "method", [PSO(15, 30), PSO.paper(30), PSO(15, 30, topology="ring"), MultiStart(starts=3)]
)
def test_a_seed_repeats_a_run(method) -> None:
    a, b = (method.run(rosenbrock(), seed=7) for _ in range(2))
    assert a.theta.tolist() == b.theta.tolist() and a.history == b.history
    np.testing.assert_array_equal(a.population, b.population)
    other = method.run(rosenbrock(), seed=8)
    assert other.population.tolist() != a.population.tolist()


@pytest.mark.parametrize("bounds_handling", ["reflect", "clip", "infinite"])
@pytest.mark.parametrize("topology", ["global", "ring"])
def test_swarm_stays_within_the_bounds_and_finds_the_valley(bounds_handling, topology) -> None:
    asked = []

    def batch(X):
        asked.append(X.copy())
        return 100 * (X[:, 1] - X[:, 0] ** 2) ** 2 + (1 - X[:, 0]) ** 2

    P = problem(
        "a b", -2, 2, 0, lambda x: np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]]), objective_batch=batch
    )
    found = PSO(bounds_handling=bounds_handling, topology=topology).run(P)
    assert found.value < 1e-4
    assert np.abs(np.vstack(asked)).max() <= 2
    assert len(asked) <= 501  # the whole swarm in one call
    assert list(found.history) == sorted(found.history, reverse=True)


def test_many_basins_need_a_search() -> None:
    # a sine's frequency: χ² has a basin every 1/T, only one of which fits
    t = np.linspace(0, 10, 60)
    y = np.sin(7.3 * t)
    P = problem("omega phi", (0.1, -2), (20, 2), (2, 0), lambda x: np.sin(x[0] * t + x[1]) - y)
    assert GaussNewton().run(P).value > 1
    for method in (PSO() >> GaussNewton(), MultiStart(starts=60)):
        found = method.run(P)
        np.testing.assert_allclose(found.theta, [7.3, 0], atol=1e-6)
    assert 1 <= found.reached < found.starts == 60


def test_parameters_over_many_decades_are_drawn_by_the_logarithm() -> None:
    P = problem("c", 1e-9, 1, 0.5, lambda x: np.log(x / 1e-6))
    ends = MultiStart(PSO(1, 1, v_max=0, include_start=True), starts=90).run(P).population
    assert 20 <= np.sum(ends < 1e-6) <= 40


@pytest.mark.parametrize("method", ALL, ids=ids)
def test_areas_without_a_finite_value_are_survived(method) -> None:
    def residual(x):
        r = np.array([x[0] - 1, x[1] + 1, 0.1 * x[0] * x[1]])
        if x[0] > 2:
            r[0] = np.nan
        return r if x[1] > -2 else np.full(3, np.inf)

    free = problem("a b", -10, 10, 0, lambda x: np.array([x[0] - 1, x[1] + 1, 0.1 * x[0] * x[1]]))
    P = problem("a b", -10, 10, (1.9, 8), residual)
    found = method.run(P)
    np.testing.assert_allclose(found.theta, GaussNewton().run(free).theta, atol=1e-5)


@pytest.mark.parametrize("method", [*LOCAL, PSO(5, 5), MultiStart(starts=3)], ids=ids)
def test_nothing_finite_is_said(method) -> None:
    found = method.run(problem("a b", -1, 1, 0, lambda x: np.full(3, np.nan)))
    assert found.value == np.inf
    assert found.reason is Reason.NOT_FINITE and not found.converged


@pytest.mark.parametrize("method", [*ALL, PSO(10, 1000)], ids=ids)
def test_ctrl_c_inside_the_model_keeps_the_best_so_far(method) -> None:
    P = rosenbrock()
    calls = [0]

    def linearise(x):
        calls[0] += 1
        if calls[0] > 7:
            raise KeyboardInterrupt
        return P.jacobian(x)

    def residual(x):
        return linearise(x)[0]

    Q = problem("a b", -5, 5, P.start, P.residual)
    Q = Problem(Q.names, Q.units, Q.lower, Q.upper, Q.start, residual, linearise, n_data=2)
    found = method.run(Q)
    assert found.reason is Reason.INTERRUPTED
    assert "interrupted" in found.reason.value
    assert found.value == pytest.approx(P.value(found.theta)) or found.value == np.inf


@pytest.mark.parametrize("method", [*LOCAL, PSO(10, 10**6, tol=0)], ids=ids)
def test_a_real_interrupt_ends_a_long_run(method, capfd) -> None:
    def residual(x):
        time.sleep(0.002)
        return rosenbrock().residual(x)

    P = problem("a b", -5, 5, (-1.2, 1), residual)
    timer = threading.Timer(0.05, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    try:
        found = method.run(P)
    finally:
        timer.join()
    assert found.reason is Reason.INTERRUPTED
    assert np.isfinite(found.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("method", ALL, ids=ids)
def test_what_the_model_raises_is_not_swallowed(method) -> None:
    def residual(x):
        raise InputError("no such thing")

    P = Problem(("a",), ("1",), [0], [1], [0.5], residual, n_data=3)
    with pytest.raises(InputError, match="no such thing"):
        method.run(P)


@pytest.mark.parametrize("method", [GaussNewton(), IPOPT(), PSO(60, 600), MultiStart(starts=3)], ids=ids)
def test_inequality_constraints_hold(method) -> None:
    # nearest point of the disk x² + y² ≤ 1, in units that differ by 1e9, and y ≤ 0.5
    def g(x):
        return 1 - x[0] ** 2 - (1e9 * x[1]) ** 2

    def slope(x):
        return np.array([-2 * x[0], -2e18 * x[1]])

    disk = Inequality("inside the disk", g, slope)
    P = problem(
        "x y",
        (-2, -2e-9),
        (2, 0.5e-9),
        (0.1, 0),
        lambda x: np.array([x[0] - 2, 1e9 * x[1] - 2]),
        constraints=(disk,),
    )
    found = method.run(P)
    np.testing.assert_allclose(
        found.theta * [1, 1e9], [np.sqrt(0.75), 0.5], atol=2e-4 if isinstance(method, PSO) else 1e-6
    )
    assert g(found.theta) > -1e-7


@pytest.mark.parametrize("method", LOCAL, ids=ids)
def test_an_inactive_constraint_changes_nothing_and_an_impossible_one_is_said(method) -> None:
    free = method.run(rosenbrock())
    for offset, wanted in ((10.0, free.theta), (-50.0, None)):
        P = rosenbrock()
        rule = Inequality("a sum", lambda x, c=offset: c - x[0] - x[1], lambda x: -np.ones(2))
        P = Problem(
            P.names,
            P.units,
            P.lower,
            P.upper,
            P.start,
            P.residual,
            P.linearise,
            constraints=(rule,),
            n_data=2,
        )
        found = method.run(P)
        if wanted is None:
            assert found.reason is Reason.INFEASIBLE
        else:
            np.testing.assert_allclose(found.theta, wanted, atol=1e-6)


def test_progress_runs_from_0_to_1() -> None:
    for method in ALL:
        told: list[tuple[float, float]] = []
        method.run(rosenbrock(), progress=lambda f, v, told=told: told.append((f, v)))
        fractions = [f for f, _ in told]
        assert fractions == sorted(fractions) and fractions[-1] == 1 and fractions[0] >= 0
