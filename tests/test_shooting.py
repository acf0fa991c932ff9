"""Multiple shooting: the segments are the model, and it finds what running the model through does not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import modelgen as mg
from modelgen.cli.methods import read_method
from modelgen.errors import InputError
from modelgen.fit import IPOPT, GaussNewton, Problem
from modelgen.fit.experiment import Experiment, experiment
from modelgen.fit.segments import Segments, segments
from modelgen.fit.series import make_series, signature_of
from modelgen.language import Equation, Input, Model, Parameter, State, Symbol, previous
from modelgen.recordings import load_case, read_case_file

t, V = Input("t", "s"), Symbol("v", real=True)
w, mu = Parameter("w", "1/s", 6.0, (0.5, 50.0)), Parameter("mu", "1/s", 1.0, (-20.0, 20.0))
X, x_0 = Parameter("X", "mm", 1.0, (0.01, 100.0)), Parameter("x_0", "mm", 0.1, (-10.0, 10.0))
x = State("x", x_0, rate=V, unit="mm")
v = State("v", 0, rate=mu * (1 - (x / X) ** 2) * V - w**2 * x, unit="mm/s")
y = Equation("y", x, "mm")
van_der_pol = Model("van_der_pol", (t, previous(t)), (w, mu, X, x_0), (x, v, y), ("y",))


def recorded(folder: Path, model: Model, columns: str, table: Any, sigma: float) -> Experiment:
    """`table` as the only recording of a case of `model`."""
    np.savetxt(folder / "record.csv", table, delimiter=",", header=columns, comments="")
    noise = f"[noise]\n{model.outputs[0].name} = {sigma}\n"
    (folder / "case.toml").write_text(f'model = "{model.id}"\n{noise}[[recording]]\nfile = "record.csv"\n')
    case = load_case(read_case_file(folder / "case.toml"), signature_of(model))
    return experiment(model, case, [make_series(model, case, r) for r in case.fit])


@pytest.fixture(scope="module")
def oscillator(tmp_path_factory: pytest.TempPathFactory) -> Experiment:
    """25 periods of a self-excited oscillation that grows from almost nothing."""
    at = np.arange(1000) / 50.0
    clean = mg.build(van_der_pol)(t=at, w=8.0, mu=2.0, X=1.0, x_0=0.1)
    table = np.column_stack([at, clean + 0.05 * np.random.default_rng(1).standard_normal(at.size)])
    return recorded(tmp_path_factory.mktemp("vdp"), van_der_pol, "t [s],y [mm]", table, 0.05)


@pytest.fixture(scope="module")
def elastomer(tmp_path_factory: pytest.TempPathFactory) -> Experiment:
    """Some cycles of the modified Dahl model."""
    at = np.arange(900) / 200.0
    z = -3 * np.cos(4.4 * at) * (0.6 + 0.4 * np.cos(0.7 * at))
    F = mg.build(mg.models.modified_dahl)(t=at, z=z, k_D=0.68, c_D=0.137, h_D=0.231, rho=1.44, r_0=-0.7)
    F = F + 0.005 * np.random.default_rng(3).standard_normal(at.size)
    table = np.column_stack([at, z, F])
    return recorded(tmp_path_factory.mktemp("d"), mg.models.modified_dahl, "t [s],z [mm],F [N]", table, 0.005)


def joined(cut: Segments, theta: Any) -> tuple[Any, Any]:
    """All segments one after the other, each from where the last one ended, and each one's first states."""
    legs, starts, end = [], [], np.zeros(cut.states)
    for k in range(len(cut.parts)):
        starts.append(end)
        legs.append(cut.run(k, theta, end))
        end = legs[-1].end
    return legs, starts


@pytest.mark.parametrize("case", ["oscillator", "elastomer"])
def test_segments_joined_are_the_whole(case: str, request: pytest.FixtureRequest) -> None:
    ex = request.getfixturevalue(case)
    problem = ex.problem()
    most = max(s.n for s in ex.series) - 1
    for count in (1, 2, 7, most):
        legs, _ = joined(segments(ex, count), problem.start)
        whole = np.concatenate([leg.residual for leg in legs])
        assert np.allclose(whole, problem.residual(problem.start), rtol=1e-9, atol=1e-9), count
    with pytest.raises(InputError, match=f"shooting = {most + 1}: .* into {most} segments at most"):
        IPOPT(shooting=most + 1).run(problem)


@pytest.mark.parametrize("case", ["oscillator", "elastomer"])
def test_slopes_of_a_segment(case: str, request: pytest.FixtureRequest) -> None:
    """By θ and by the states it begins with, against central differences."""
    ex = request.getfixturevalue(case)
    theta, cut = ex.problem().start, segments(ex, 5)
    legs, starts = joined(cut, theta)
    for k in (0, 3):
        at = np.concatenate([theta, starts[k]])
        for i, value in enumerate(at):
            step = np.zeros(at.size)
            step[i] = 1e-6 * max(1.0, abs(value))
            up, down = (cut.run(k, p[: theta.size], p[theta.size :]) for p in (at + step, at - step))
            for found, a, b in (
                (legs[k].residual_slope, up.residual, down.residual), (legs[k].end_slope, up.end, down.end)
            ):  # fmt: skip
                wanted = (a - b) / (2 * step[i])
                assert np.allclose(found[:, i], wanted, rtol=1e-5, atol=1e-6 * max(1.0, np.abs(wanted).max()))


def test_both_ways_agree_at_the_optimum(elastomer: Experiment) -> None:
    problem = elastomer.problem()
    once, shot = (m.run(problem) for m in (IPOPT(), IPOPT(shooting=12)))
    assert once.converged and shot.converged
    assert np.allclose(shot.theta, once.theta, rtol=1e-6) and shot.value == pytest.approx(
        once.value, rel=1e-9
    )


def test_it_arrives_where_running_through_does_not(oscillator: Experiment) -> None:
    """From far off, a long oscillation has a valley for every wrong count of periods."""
    problem: Problem = oscillator.problem()
    start = np.array([5.0, -1.0, 2.0, 0.5])
    shot = IPOPT(shooting=40).run(problem, start)
    assert shot.converged and shot.value / problem.n_data < 1.2
    assert np.allclose(shot.theta[:3], [8.0, 2.0, 1.0], rtol=0.02)
    assert GaussNewton().run(problem, start).value > 100 * shot.value


def test_only_what_has_states_is_cut() -> None:
    line = Problem(("a",), ("1",), [0.0], [1.0], [0.5], lambda q: q - 0.2, n_data=1)
    with pytest.raises(InputError, match="only for a model with states"):
        IPOPT(shooting=3).run(line)
    with pytest.raises(InputError, match="shooting = -1"):
        IPOPT(shooting=-1)


def test_methods_by_their_text() -> None:
    assert read_method("pso(30) >> ipopt(shooting=20)") == mg.PSO(30) >> mg.IPOPT(shooting=20)
    assert read_method("PSO(particles=30)") == mg.PSO(30)
    for text, says in {
        "ipopt(20)": r"takes no number, but ipopt\(shooting=20\)",
        "ipopt(shoting=2)": "no setting 'shoting', did you mean 'shooting'",
        "ipopt(shooting=)": "whole number is wanted for shooting",
        "ipopt(shooting=-3)": r"wanted ipopt or ipopt\(shooting=N\), N a whole number from 0",
        "pso(x)": r"wanted pso or pso\(N\), N a whole number from 0",
        "gauss-newton(a=3)": "no setting 'a'; it has none",
    }.items():
        with pytest.raises(InputError, match=says):
            read_method(text)
