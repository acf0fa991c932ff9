"""Basins, Sobol' indices, information, Monte Carlo, and parameters that one recording cannot tell apart."""

from dataclasses import replace

import numpy as np
import pytest

from modelgen.codegen import build
from modelgen.errors import InputError
from modelgen.fit import PSO, GaussNewton, Problem
from modelgen.fit.fitting import fit
from modelgen.fit.likelihood import basin
from modelgen.fit.montecarlo import propagate, spread
from modelgen.fit.sensitivity import cloud, fisher, recorded, sobol
from modelgen.models.contact_damping import contact_damping
from modelgen.papers.gmm.truth import MODEL, TRUE, case
from modelgen.recordings import Noise

A = np.array([[1.0, 0.0], [0.8, 0.6], [0.0, 0.5]])


def linear() -> Problem:
    """r = Aθ with its optimum, 0, in the middle of the box."""
    low = np.array([-10.0, -10.0])
    return Problem(
        ("a", "b"),
        ("1", "1"),
        low,
        -low,
        np.array([1.0, 1.0]),
        lambda t: A @ t,
        lambda t: (A @ t, A),
        n_data=3,
    )


def test_basin_is_the_projection_of_the_ellipse() -> None:
    covariance = np.linalg.inv(A.T @ A)
    for k, name in enumerate("ab"):
        low, high = basin(linear(), name, [0.0, 0.0], 4.0)
        assert (low, high) == pytest.approx(
            (-2 * covariance[k, k] ** 0.5, 2 * covariance[k, k] ** 0.5), rel=1e-3
        )
    with pytest.raises(InputError, match="there is no basin"):
        basin(linear(), "a", [1.0, 1.0], 0.5)


def test_a_searchs_cloud_stays_inside_the_basin() -> None:
    problem, seen = recorded(linear(), 3)
    PSO(40, 60).run(problem)
    points = cloud(problem, seen)
    assert len(points.rms) == 61 * 40
    low, high = basin(linear(), "a", [0.0, 0.0], 3 * 4.0)
    assert 0.6 * (high - low) < points.width("a", 2.0) < high - low


def test_information_with_others_known_and_unknown() -> None:
    found = fisher(linear(), [1.0, 2.0], 0.1)
    covariance = 0.01 * np.linalg.inv(A.T @ A)
    assert found.together == pytest.approx(np.sqrt(np.diag(covariance)) / [1, 2])
    assert found.alone == pytest.approx(0.1 / np.linalg.norm(A, axis=0) / [1, 2])


def test_sobol_indices_of_a_product() -> None:
    """ln(x²y²) = 2 ln|x| + 2 ln|y|: half each, without interaction."""
    pytest.importorskip("SALib")
    box = np.array([-1.0, -1.0])
    problem = Problem(
        ("x", "y"), ("1", "1"), box, -box, box / 2, lambda t: np.array([t[0] * t[1], 0.0]), n_data=2
    )
    for share in sobol(problem, 4096):
        assert (share.first, share.total) == pytest.approx((0.5, 0.5), abs=0.06)


def test_monte_carlo_of_the_contact_model_is_linear_for_small_spreads() -> None:
    function = build(contact_damping, ("R_q_1", "H"))
    slope = np.ravel(function.jacobian())
    at = {p.name: p.default for p in contact_damping.scalar_parameters}
    std = {"R_q_1": 1e-4 * at["R_q_1"], "H": 1e-4 * at["H"]}
    rng = np.random.default_rng(0)
    drawn = {n: at[n] + s * rng.standard_normal(4000) for n, s in std.items()}
    found = spread(propagate(function, drawn), 0.95)
    assert found.std == pytest.approx(np.hypot(*(slope * list(std.values()))), rel=0.05)
    assert found.high - found.low == pytest.approx(2 * 1.96 * found.std, rel=0.05)
    assert found.lost == 0 and found.mean == pytest.approx(float(function()), rel=1e-4)


def test_shortest_interval_of_a_skewed_quantity_begins_where_it_does() -> None:
    values = np.random.default_rng(1).exponential(size=200_000)
    found = spread(values, 0.95)
    assert found.low < 1e-3 and found.high == pytest.approx(-np.log(0.05), rel=0.02)


def test_a_fit_says_that_damping_and_compliance_are_one_and_what_separates_them() -> None:
    data = replace(case(damping={"R_d": 6.79}), noise=Noise(relative={"Z": 1e-4}))
    free = fit(MODEL, data, GaussNewton())
    assert free["S33_im"].std > 0.3 * abs(TRUE["S33_im"])
    (note,) = (n for n in free.notes if "one parameter" in n)
    assert (
        "R_f" in note and "S33_im" in note and "second recording with M_t" in note and "R_f measured" in note
    )
    known = fit(MODEL, replace(case(), noise=Noise(relative={"Z": 1e-4})), GaussNewton())
    assert known["S33_im"].std < 0.02 * abs(TRUE["S33_im"])
    assert not any("one parameter" in n for n in known.notes)
