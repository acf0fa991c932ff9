"""Fits that run whole in C: the same optimum as step by step, whatever the number of threads."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from fit_problems import T, decay
from hypothesis import given, settings
from hypothesis import strategies as st

import modelgen.models as models
from modelgen.codegen import build
from modelgen.codegen.fitters import sources
from modelgen.fit import PSO, GaussNewton, MultiStart, Problem, Reason
from modelgen.fit.compiled import Compiled, compiled
from modelgen.fit.experiment import Layout
from modelgen.fit.series import Series
from modelgen.fit.together import Together
from modelgen.fit.whitener import Whitener

SIX = ("mu33_re", "mu33_im", "S33_re", "S33_im", "d33_re", "d33_im")
LOW = np.array([2.0, -0.5, 1e-11, -1e-12, 5e-10, -5e-10])
HIGH = np.array([3.0, 0.0, 1e-10, 0.0, 5e-9, 0.0])


@cache
def impedance(measure: str = "complex", recordings: int = 1) -> tuple[Problem, Compiled]:
    """The transducer's six material constants from recordings with 1 % noise."""
    function = build(models.magnetostrictive_transducer, SIX)
    ready = [function.prepare(f=np.linspace(1200 + 100 * k, 2200, 101)) for k in range(recordings)]
    rng = np.random.default_rng(0)
    truth = ready[0].p[function.free]
    data = [r.values(truth, measure) * (1 + 0.01 * rng.normal(size=(1, r.n))) for r in ready]
    weight = [np.full_like(y, 3.0) for y in data]
    place, held = np.tile(np.arange(6), (recordings, 1)), np.zeros((recordings, 6))
    layout = Layout(SIX, SIX, (), place, held, ())
    rows = tuple(range(len(data[0])))
    series = [
        Series("", "fit", {}, y, measure, rows, "", Whitener(w)) for y, w in zip(data, weight, strict=True)
    ]
    sums = compiled(ready, series, [s.whitener for s in series], layout)

    def residual(theta: np.ndarray) -> np.ndarray:
        parts = zip(ready, data, weight, strict=True)
        return np.concatenate([((r.values(theta, measure) - y) * w).ravel() for r, y, w in parts])

    def linearise(theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        slopes = [r.jacobian(theta, measure)[1].transpose(0, 2, 1).reshape(-1, 6) * 3.0 for r in ready]
        return residual(theta), np.concatenate(slopes)

    problem = Problem(SIX, ("1",) * 6, LOW, HIGH, truth, residual, linearise, n_data=101)
    return problem, sums


def _colours(n: int) -> dict[str, Whitener]:
    """Every way of whitening n samples of two channels."""
    rng = np.random.default_rng(1)
    even, turn = np.full((2, n), 3.0), 2.0 * np.exp(1j * rng.uniform(0, 6, n))
    root = Together.of(rng.normal(size=(n, 5)))
    ar = np.array([1.0, -0.6, 0.2, 0.05])
    band = rng.uniform(0.05, 0.2, (4, n)) + np.array([[1.0], [0], [0], [0]])
    share = (rng.uniform(size=n) > 0.1).astype(float)
    return {
        "turned": Whitener(turn),
        "correlated": Whitener(turn, root=root),
        "coloured": Whitener(even, ar=ar),
        "one weight for all": Whitener(even[:1], ar=ar, undo=rng.uniform(0.5, 1, n)),
        "banded, samples masked": Whitener(turn, ar=ar, band=band, share=share),
    }


@pytest.mark.parametrize("colour", _colours(3))
@pytest.mark.parametrize("rows", [(0, 1), (1, 0)])
def test_whitening_in_c_is_whitening(colour: str, rows: tuple[int, ...]) -> None:
    """Residuals, columns and their sums, against `Whitener.apply`; one parameter is held in the first."""
    function = build(models.magnetostrictive_transducer, SIX)
    ready = [function.prepare(f=np.linspace(1200, 2200, n)) for n in (61, 40)]
    truth = ready[0].p[function.free]
    data = [r.values(truth, "complex")[list(rows)] + 0.3 for r in ready]
    whiteners = [_colours(r.n)[colour] for r in ready]
    series = [Series("", "fit", {}, y, "complex", rows, "", w) for y, w in zip(data, whiteners, strict=True)]
    place, held = np.array([[0, 1, 2, -1, 4, 5], range(6)]), np.full((2, 6), truth[3])
    sums = compiled(ready, series, whiteners, Layout(SIX, SIX, (), place, held, ()))
    theta = truth * 1.01
    r, J = [], []
    for k, (one, s, w) in enumerate(zip(ready, series, whiteners, strict=True)):
        out, jac = one.jacobian(np.where(place[k] < 0, held[k], theta), "complex")
        r.append(w.apply(out[list(rows)] - s.data).ravel())
        J.append(w.apply(jac[list(rows)]).transpose(0, 2, 1).reshape(-1, 6) * (place[k] >= 0))
    e, slopes = np.concatenate(r), np.concatenate(J)
    size = np.linalg.norm(slopes, axis=0)
    assert sums.residuals(theta) == pytest.approx(e, abs=1e-12 * np.abs(e).max())
    assert np.allclose(
        sums.columns(theta, [4, 0]) / size[[4, 0]], slopes[:, [4, 0]] / size[[4, 0]], atol=1e-12
    )
    both = np.array([theta, truth])
    assert np.array_equal(sums.residuals(both), [sums.residuals(t) for t in both])
    assert np.array_equal(sums.columns(both, [4, 0]), [sums.columns(t, [4, 0]) for t in both])
    value, g, A = sums.normal(theta)
    assert value == pytest.approx(e @ e, rel=1e-12)
    assert sums.values(theta[None]) == pytest.approx([e @ e], rel=1e-12)
    assert g / size == pytest.approx(slopes.T @ e / size, abs=1e-11 * np.linalg.norm(e))
    assert A / np.outer(size, size) == pytest.approx(slopes.T @ slopes / np.outer(size, size), abs=1e-11)


@pytest.mark.parametrize("measure", ["complex", "modulus"])
def test_sums_in_c_are_those_of_the_residual(measure: str) -> None:
    problem, compiled = impedance(measure, 3)
    theta = LOW + 0.4 * (HIGH - LOW)
    r, J = problem.jacobian(theta)
    value, g, A = compiled.normal(theta)
    assert value == pytest.approx(r @ r, rel=1e-12)
    assert compiled.values(theta[None]) == pytest.approx([r @ r], rel=1e-12)
    size = np.linalg.norm(J, axis=0)
    assert g / size == pytest.approx(J.T @ r / size, rel=1e-9, abs=1e-9 * np.linalg.norm(r))
    assert A / np.outer(size, size) == pytest.approx(J.T @ J / np.outer(size, size), abs=1e-11)


def test_a_parameter_held_is_one_column_less() -> None:
    problem, compiled = impedance()
    theta = LOW + 0.4 * (HIGH - LOW)
    fixed = replace(problem, compiled=compiled).fixed(2, float(theta[2]))
    assert fixed.compiled is not None
    value, g, A = compiled.normal(theta)
    keep = np.arange(6) != 2
    found = fixed.compiled.normal(theta[keep])
    assert found[0] == value
    assert np.array_equal(found[1], g[keep]) and np.array_equal(found[2], A[np.ix_(keep, keep)])


@pytest.mark.parametrize("seed", range(4))
def test_a_whole_descent_in_c_ends_where_one_step_by_step_does(seed: int) -> None:
    problem, compiled = impedance()
    start = LOW + (HIGH - LOW) * np.random.default_rng(seed).random(6)
    by_steps = GaussNewton().run(problem, start)
    whole = GaussNewton().run(replace(problem, compiled=compiled), start)
    assert whole.reason is by_steps.reason is Reason.CONVERGED
    assert whole.value == pytest.approx(by_steps.value, rel=1e-9)
    assert whole.value == min(whole.history) and len(whole.history) == whole.iterations


def test_the_number_of_threads_changes_no_bit() -> None:
    problem, compiled = impedance()
    starts = LOW + (HIGH - LOW) * np.random.default_rng(1).random((300, 6))
    box, settings_ = (problem.lower, problem.upper, problem.width), (500, 1e-13, 0.1)
    one, three = (compiled.descend(starts, box, settings_, threads=n) for n in (1, 3))
    assert all(np.array_equal(a, b) for a, b in zip(one, three, strict=True))
    many = np.tile(starts, (20, 1))
    assert np.array_equal(compiled.values(many, threads=1), compiled.values(many, threads=3))


def test_a_swarm_in_c_is_the_swarm_that_asks() -> None:
    """The same flight when the problem is compiled and when each iteration's values are asked for."""
    problem, compiled = impedance()
    asked = replace(problem, objective_batch=compiled.values)
    swarm = PSO(30, 60, seed=5)
    a, b = swarm.run(asked), swarm.run(replace(asked, compiled=compiled))
    assert np.array_equal(a.theta, b.theta) and a.value == b.value
    assert a.evaluations == b.evaluations and a.history == b.history
    assert a.population is not None and np.array_equal(a.population, b.population)


def test_the_swarm_and_many_starts_find_the_optimum_of_the_box() -> None:
    problem, compiled = impedance()
    quick = replace(problem, compiled=compiled)
    best = GaussNewton().run(quick).value
    many = MultiStart(starts=60).run(quick)
    assert many.value == pytest.approx(best, rel=1e-9) and many.starts == 60
    assert (PSO(60, 400, seed=1) >> GaussNewton()).run(quick).value == pytest.approx(best, rel=1e-9)


@pytest.mark.parametrize("damping", [0.1, 1.0])
def test_descents_that_walls_hold_find_a_way_behind_them(damping: float) -> None:
    """Two in three starts end in corners where the resonance is out of sight; behind the walls it is not."""
    problem, compiled = impedance()
    quick = replace(problem, compiled=compiled)
    starts = LOW + (HIGH - LOW) * np.random.default_rng(2).random((200, 6))
    near, far = (GaussNewton(damping=damping, beyond=b).descents(quick, starts) for b in (False, True))
    best = far.value.min() * (1 + 1e-6)
    assert np.mean(near.value <= best) < 0.5 and np.mean(far.value <= best) >= 0.99
    assert np.all(far.value <= near.value) and np.all((far.theta >= LOW) & (far.theta <= HIGH))
    held = near.theta[np.argmax(near.value)]
    whole, by_steps = (GaussNewton(beyond=True).run(p, held) for p in (quick, problem))
    assert whole.value == min(whole.history) == pytest.approx(by_steps.value, rel=1e-9)
    assert abs(whole.evaluations - by_steps.evaluations) <= 2  # what ends a descent may be rounding
    assert whole.value < 0.01 * near.value.max()


def test_an_optimum_on_a_wall_is_kept() -> None:
    """Beyond the wall there is less to find only outside: the end at the wall stands, whatever the budget."""
    bent = decay(2 * np.exp(-1.5 * T) - 0.5, 1.0)  # wants c = -0.5, the wall is at 0
    plain = GaussNewton().run(bent)
    for budget in (plain.iterations + 1, plain.iterations + 5, 500):
        found = GaussNewton(budget, beyond=True).run(bent)
        np.testing.assert_allclose(found.theta, plain.theta, atol=1e-6)
        assert found.value == pytest.approx(plain.value, rel=1e-9) and found.reason is Reason.CONVERGED
        assert found.iterations <= budget


NASTY = (0.0, 1.0, -1.0, 1e300, 1e-310, 5e-324, np.inf, -np.inf, np.nan, 2.5)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.sampled_from(NASTY), min_size=6, max_size=6))
def test_no_number_makes_it_crash_or_hang(theta: list[float]) -> None:
    _, compiled = impedance()
    value = compiled.values(np.array([theta]))[0]
    assert value >= 0
    box = (np.full(6, -np.inf), np.full(6, np.inf), np.ones(6))
    ends = compiled.descend(np.array([theta]), box, (50, 1e-13, 0.1))
    assert ends.iterations[0] <= 50 and not ends.value[0] > value
    box = (np.full(6, -1.0), np.full(6, 1.0), np.ones(6))
    ends = compiled.descend(np.clip([theta], -1, 1), box, (50, 1e-13, 0.1), beyond=True)
    assert ends.iterations[0] <= 50 and not np.any(np.abs(ends.theta) > 1)


MAIN = """
#include "modelgen_fit.h"
#include <stdio.h>

/* y = a exp(-b t): residuals and slopes written by hand, in the place of a generated kernel. */
#include <math.h>
static void decay(size_t n, size_t stride, const double *work, const double *p, const double *data,
    const double *weight, double *normal)
{
    (void)stride;
    for (int k = 0; k < 6; ++k) { normal[k] = 0.0; }
    for (size_t i = 0; i < n; ++i) {
        const double x = exp(-p[1] * work[i]);
        const double e = weight[i] * (p[0] * x - data[i]);
        const double da = weight[i] * x, db = -weight[i] * p[0] * work[i] * x;
        normal[0] += da * da; normal[1] += da * db; normal[2] += db * db;
        normal[3] += da * e; normal[4] += db * e; normal[5] += e * e;
    }
}

int main(void)
{
    double t[20], y[20], w[20], p[2] = { 0.0, 0.0 }, held[2] = { 0.0, 0.0 }, local[8];
    const size_t column[2] = { 0, 1 };
    const int64_t place[2] = { 0, 1 };
    for (int i = 0; i < 20; ++i) { t[i] = 0.1 * i; y[i] = 2.5 * exp(-1.3 * t[i]); w[i] = 1.0; }
    const mg_recording r = { decay, NULL, 20, 20, 2, 2, t, p, y, w, column, place, held, local };
    double theta[2] = { 1.0, 0.1 }, doubles[MG_LM_DOUBLES(2)];
    const double lower[2] = { 0.0, 0.0 }, upper[2] = { 10.0, 10.0 }, width[2] = { 10.0, 10.0 };
    int ints[MG_LM_INTS(2)];
    mg_lm s = { 0 };
    s.max_iter = 50; s.tol = 1e-13; s.damping = 0.1;
    s.lower = lower; s.upper = upper; s.width = width;
    mg_lm_place(&s, 2, theta, doubles, ints);
    const int status = mg_lm_run(&s, &r, 1, NULL);
    printf("%d %.12f %.12f\\n", status, theta[0], theta[1]);
    return 0;
}
"""


@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
def test_the_fitter_stands_alone_in_strict_c(tmp_path: Path) -> None:
    """As on a controller: no allocation, a workspace on the stack, no warning, sanitizers silent."""
    for name, text in {**sources(), **sources("noise"), "main.c": MAIN}.items():
        (tmp_path / name).write_text(text)
    strict = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror"]
    guards = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    subprocess.run(
        ["gcc", *strict, *guards, "main.c", "modelgen_fit.c", "modelgen_noise.c", "-lm"],
        cwd=tmp_path,
        check=True,
    )
    done = subprocess.run([str(tmp_path / "a.out")], capture_output=True, text=True, check=True)
    status, a, b = done.stdout.split()
    assert status == "1" and float(a) == pytest.approx(2.5) and float(b) == pytest.approx(1.3)
