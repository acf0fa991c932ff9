"""One problem description: its routes agree, and wrong input is named."""

import numpy as np
import pytest
from fit_problems import T, decay, linear, problem, rosenbrock

from modelgen.errors import InputError
from modelgen.fit import Problem

DATA = 3 * np.exp(-1.5 * T) + 0.5


def test_all_routes_give_the_same_numbers() -> None:
    full, plain = decay(DATA, 0.1), decay(DATA, 0.1, batch=False)
    bare = problem("a k c", 0, 10, 1, full.residual)
    thetas = np.random.default_rng(1).uniform(0.5, 3, (7, 3))
    assert full.provides == {"residual", "linearise", "objective_batch"}
    assert bare.provides == {"residual"}
    np.testing.assert_allclose(full.values(thetas), plain.values(thetas), rtol=1e-13)
    for theta in thetas:
        r, J = full.jacobian(theta)
        assert full.value(theta) == pytest.approx(r @ r, rel=1e-13)
        np.testing.assert_allclose(bare.jacobian(theta)[1], J, atol=1e-8 * np.abs(J).max())
        f, g, A = full.normal_equations(theta)
        np.testing.assert_allclose(g, J.T @ r, rtol=1e-13)
        np.testing.assert_allclose(A, J.T @ J, rtol=1e-13)
        assert f == pytest.approx(r @ r)


def test_differences_stay_within_the_bounds() -> None:
    asked = []

    def residual(x: np.ndarray) -> np.ndarray:
        asked.append(x.copy())
        return np.sqrt(x)

    P = problem("a b", 0, 1, (0, 1), residual)
    P.jacobian(P.start)
    assert np.min(asked) >= 0 and np.max(asked) <= 1


def test_values_that_are_not_finite_count_as_infinite() -> None:
    P = problem("a", 0, 2, 1, lambda x: np.array([np.nan if x[0] > 1 else x[0], 1e200 * x[0]]))
    assert P.value([1.5]) == np.inf
    assert P.value([0.0]) == 0
    with np.errstate(over="ignore"):
        assert P.value([0.5]) == np.inf


def test_fixing_a_parameter_keeps_all_routes() -> None:
    P = rosenbrock()
    held = P.fixed(0, 0.7)
    assert held.names == ("b",) and held.provides == P.provides
    x = np.array([0.3])
    assert held.value(x) == pytest.approx(P.value([0.7, 0.3]))
    np.testing.assert_allclose(held.jacobian(x)[1], P.jacobian([0.7, 0.3])[1][:, 1:])
    assert held.hessian is not None and held.hessian(x)[0, 0] == pytest.approx(100)


def test_a_start_that_is_not_given_is_the_centre() -> None:
    P = Problem(
        ("a", "b", "c"),
        ("1",) * 3,
        [0, 1e-6, 1],
        [4, 1e-2, 50],
        [np.nan] * 3,
        lambda x: np.zeros(3),
        n_data=3,
    )
    np.testing.assert_allclose(P.start, [2, 1e-4, 25.5])


@pytest.mark.parametrize(
    ("lower", "upper", "start", "n", "says"),
    [
        ((0, 3), (1, 1), (0, 1), 5, "parameter 'k_D': bounds [3, 1] are reversed"),
        ((0, 1), (1, 1), (0, 1), 5, "parameter 'k_D': both bounds are 1"),
        ((0, 0), (1, 1), (0, 5), 5, "parameter 'k_D': start 5 is outside its bounds [0, 1]"),
        ((0, np.nan), (1, 1), (0, 0), 5, "parameter 'k_D': a bound is not a number"),
        ((0, 0), (1, np.inf), (0, np.nan), 5, "parameter 'k_D': a start or finite bounds are wanted"),
        ((0, 0), (1, 1), (0, 1), 1, "1 data values cannot determine 2 parameters (rho, k_D)"),
    ],
)
def test_wrong_input_is_named_in_one_line(lower, upper, start, n, says) -> None:
    with pytest.raises(InputError) as error:
        Problem(("rho", "k_D"), ("1", "N"), lower, upper, start, lambda x: x, n_data=n)
    assert says in str(error.value) and "\n" not in str(error.value)


def test_a_search_box_needs_bounds_or_a_scale() -> None:
    low, high = linear(np.eye(2), [0, 0], (0, -np.inf), (np.inf, 9), (2, 3)).box()
    np.testing.assert_allclose(low, [0, -27])
    np.testing.assert_allclose(high, [22, 9])
    with pytest.raises(InputError, match="parameter 'x1'"):
        linear(np.eye(2), [0, 0], -np.inf, np.inf, (1, 0)).box()
