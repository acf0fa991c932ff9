"""Standard deviations cover the truth at their nominal rate; what the data leave open is said."""

from statistics import NormalDist

import numpy as np
import pytest
from fit_problems import T, decay, linear, problem
from hypothesis import given, settings
from hypothesis import strategies as st

from modelgen.errors import InputError
from modelgen.fit import IPOPT, PSO, GaussNewton, assess, profile

TRUTH = np.array([3.0, 1.5, 0.5])
CLEAN = TRUTH[0] * np.exp(-TRUTH[1] * T) + TRUTH[2]


@pytest.mark.parametrize("method", [GaussNewton(), IPOPT(), PSO(25, 120)], ids=lambda m: type(m).__name__)
def test_three_sigma_intervals_cover_at_the_nominal_rate(method) -> None:
    rng = np.random.default_rng(42)
    errors = []
    for _ in range(200):
        P = decay(CLEAN + 0.05 * rng.standard_normal(T.size), 0.05, lower=(0, 0.1, -2), upper=(6, 4, 3))
        found = method.run(P)
        errors.append((found.theta - TRUTH) / assess(P, found.theta).std)
    z = np.abs(errors)
    # 600 intervals, three dependent ones a draw: 99.73 % ± 0.4 %, 95.45 % ± 1.5 %, 68.3 % ± 3.3 %
    assert np.mean(z < 3) >= 0.985
    assert np.mean(z < 2) == pytest.approx(0.9545, abs=0.03)
    assert np.mean(z < 1) == pytest.approx(0.683, abs=0.06)


def test_linear_problems_have_the_textbook_covariance() -> None:
    rng = np.random.default_rng(1)
    A = rng.standard_normal((20, 4)) * [1, 1e-6, 1e9, 3]
    known = assess(linear(A, np.zeros(20), -np.inf, np.inf, 1), np.zeros(4))
    wanted = np.linalg.inv((A / np.diag(A.T @ A) ** 0.5).T @ (A / np.diag(A.T @ A) ** 0.5))
    wanted /= np.outer(np.diag(A.T @ A) ** 0.5, np.diag(A.T @ A) ** 0.5)
    np.testing.assert_allclose(known.covariance, wanted, rtol=1e-9)
    np.testing.assert_allclose(np.diag(known.correlation), 1)
    assert known.rank == 4 and known.determined.all() and known.undetermined == ()


def test_noise_is_estimated_when_not_known() -> None:
    rng = np.random.default_rng(2)
    noise = []
    for _ in range(100):
        data = CLEAN + 0.05 * rng.standard_normal(T.size)
        P, unknown = decay(data, 0.05), decay(data, 1.0)
        theta = GaussNewton().run(unknown).theta
        known = assess(unknown, theta, estimate_noise=True)
        noise.append(known.noise**2)
        np.testing.assert_allclose(known.std, assess(P, theta).std * known.noise / 0.05, rtol=1e-9)
    assert np.mean(noise) == pytest.approx(0.05**2, rel=0.08)
    assert np.isnan(assess(linear(np.eye(2), [1, 1], 0, 2, 1), [1, 1], estimate_noise=True).noise)


@pytest.mark.parametrize(
    ("residual", "names", "rank", "says", "nan"),
    [
        (lambda x: (x[0] + 4.8e14 * x[1]) * T + x[2], "R_f S33_im c", 2,
         ["the data don't determine R_f and S33_im apart: only R_f + 4.8e14*S33_im"], [1, 1, 0]),
        (lambda x: x[0] * x[1] * np.exp(-x[2] * T), "N A k", 2,
         ["the data don't determine N and A apart: only N*A"], [1, 1, 0]),
        (lambda x: x[0] ** 2 / x[1] * np.exp(-x[2] * T), "N l k", 2,
         ["the data don't determine N and l apart: only N^2/l"], [1, 1, 0]),
        (lambda x: x[0] * T**2 + x[1], "a b c", 2, ["the data say nothing about c"], [0, 0, 1]),
        (lambda x: (x[0] + x[1] + x[2]) * T + x[3], "a b c d", 2,
         ["the data don't determine a, b and c apart: only a + b + c"], [1, 1, 1, 0]),
        (lambda x: np.append((x[0] + x[1]) * T, x[1] - 2 * x[2]), "a b c", 2,
         ["the data don't determine a, b and c apart: only a + 2*c and b - 2*c"], [1, 1, 1]),
        (lambda x: np.append((x[0] - 3 * x[1]) * T, x[2] * x[3] * T**2), "a b c d", 2,
         ["the data don't determine a and b apart: only a - 3*b",
          "the data don't determine c and d apart: only c*d"], [1, 1, 1, 1]),
    ],
)  # fmt: skip
def test_what_the_data_leave_open_is_said_in_words(residual, names, rank, says, nan) -> None:
    p = len(names.split())
    theta = np.array([2.0, 1.5, 0.7, 3.1])[:p]
    scale = np.ones(p)
    if "S33_im" in names:
        theta[1], scale[1] = -2e-14, 1e-13
    target = residual(theta)
    P = problem(names, -10 * scale, 10 * scale, scale, lambda x: (residual(x) - target) / 1e-3)
    known = assess(P, theta)
    assert list(known.undetermined) == says
    assert known.rank == rank
    assert np.isnan(known.std).tolist() == [bool(x) for x in nan]
    assert known.determined.tolist() == [not x for x in nan]


def test_a_determined_parameter_beside_open_ones_keeps_its_error() -> None:
    P = problem("a b c", -9, 9, 1, lambda x: ((x[0] + x[1]) * T + x[2]) / 0.1)
    alone = problem("s c", -9, 9, 1, lambda x: (x[0] * T + x[1]) / 0.1)
    assert assess(P, [1, 1, 1]).std[2] == pytest.approx(assess(alone, [2, 1]).std[1], rel=1e-6)


def test_data_too_weak_to_tell_count_as_silent() -> None:
    def weak(x):
        return np.append((x[0] + x[1]) * T / 0.1, 1e-3 * x[1])

    inside = assess(problem("a b", -9, 9, 1, weak), [1, 1])
    assert inside.rank == 1 and np.isnan(inside.std).all()
    says = "the data don't determine a and b apart within the bounds: only a + b"
    assert inside.undetermined == (says,)
    known = assess(problem("a b", -9, 9, 1, lambda x: (x[0] * T + 0.001 * x[1]) / 0.1), [1, 1])
    assert known.determined.tolist() == [True, False] and np.isfinite(known.std[0])
    open_ = assess(problem("a b", -np.inf, np.inf, 1, weak), [1, 1])
    assert open_.rank == 2 and open_.std[1] == pytest.approx(1000, rel=1e-3)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10**6))
def test_units_change_std_in_proportion_and_nothing_else(seed: int) -> None:
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((9, 4))
    A[:, 3] = A[:, 0] - 2 * A[:, 1] if seed % 2 else A[:, 3]
    unit = 10.0 ** rng.uniform(-12, 12, 4)
    a = assess(linear(A, np.zeros(9), -np.inf, np.inf, 1), np.zeros(4))
    b = assess(linear(A / unit, np.zeros(9), -np.inf, np.inf, 1), np.zeros(4))
    assert a.rank == b.rank == (3 if seed % 2 else 4)
    np.testing.assert_array_equal(a.determined, b.determined)
    np.testing.assert_allclose(b.std / unit, a.std, rtol=1e-6)


def test_parameters_on_a_bound_are_flagged() -> None:
    A = np.vander(np.linspace(0, 1, 12), 3)
    P = linear(A / 0.1, A @ [1, -0.5, 2] / 0.1, (0, 0, 0), (5, 5, 5), 1)
    for method in (GaussNewton(), IPOPT()):
        known = assess(P, method.run(P).theta)
        assert known.at_bound.tolist() == [False, True, False]


def test_profile_of_a_linear_problem_is_the_linear_interval() -> None:
    rng = np.random.default_rng(3)
    P = linear(rng.standard_normal((12, 3)), rng.standard_normal(12), -np.inf, np.inf, 0)
    best = GaussNewton().run(P).theta
    std = assess(P, best).std
    for level in (0.683, 0.95, 0.9973):
        z = NormalDist().inv_cdf((1 + level) / 2)
        found = profile(P, "x1", best, level=level)
        assert found.low == pytest.approx(best[1] - z * std[1], abs=3e-3 * std[1])
        assert found.high == pytest.approx(best[1] + z * std[1], abs=3e-3 * std[1])
        assert not (found.low_open or found.high_open) and found.better is None


def test_profile_follows_curvature_bounds_and_silence() -> None:
    # r = (ln a − 0)/0.5: the interval of ln a is symmetric, so that of a is exp(± z/2)
    found = profile(problem("a", 1e-3, 100, 1, lambda x: np.log(x) / 0.5), 0, [1.0], level=0.95)
    assert (found.low, found.high) == pytest.approx((np.exp(-0.98), np.exp(0.98)), rel=2e-3)
    found = profile(problem("a", 0.9, 1.1, 1, lambda x: np.log(x) / 0.5), 0, [1.0])
    assert (found.low, found.high, found.low_open, found.high_open) == (0.9, 1.1, True, True)
    product = problem("a b", 0, np.inf, 1, lambda x: np.array([x[0] * x[1] - 1, 0.0]))
    assert profile(product, "b", [1.0, 1.0]).high == np.inf
    with pytest.raises(InputError, match="unknown parameter 'k_d', did you mean 'k_D'"):
        profile(problem("k_D", 0, 1, 0.5, lambda x: x), "k_d", [0.0])


def test_profile_intervals_cover_where_linear_ones_do_not() -> None:
    # few, noisy points on a decay: k is skewed
    rng = np.random.default_rng(9)
    inside = linear_inside = 0
    for _ in range(150):
        P = decay(CLEAN + 0.5 * rng.standard_normal(T.size), 0.5, lower=(0, 0, -5), upper=(50, 50, 5)).fixed(
            2, 0.5
        )
        best = GaussNewton().run(P, [3, 1.5]).theta
        found = profile(P, "k", best)
        inside += found.low <= 1.5 <= found.high
        linear_inside += abs(best[1] - 1.5) <= 1.96 * assess(P, best).std[1]
    assert inside / 150 == pytest.approx(0.95, abs=0.045)
    assert inside >= linear_inside - 4


def test_profile_reports_a_better_optimum() -> None:
    P = problem("a b", -3, 3, 1, lambda x: np.array([x[0] ** 2 - 1, x[0] - 1, x[1]]))
    found = profile(P, "a", [-0.7, 0.0], level=0.999)
    assert found.better is not None and P.value(found.better) < P.value([-0.7, 0.0])


def test_a_small_number_in_a_wide_box_is_on_no_bound() -> None:
    A = np.column_stack([np.ones(50) * 1e6, np.linspace(-1, 1, 50)])
    known = assess(linear(A, A @ [5e-5, 2.0], [0.0, 0.0], [1e6, 5.0], 1), np.array([5e-5, 2.0]))
    assert known.std[0] < 1e-6
    assert not known.at_bound.any()
