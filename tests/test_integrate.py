"""States with a rate: both schemes against CVODES with error control, their orders, and stiffness."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import casadi as ca
import mpmath as mp
import numpy as np
import pytest
from exact import run

from modelgen.codegen import build, build_many, lower
from modelgen.codegen.build import ALL
from modelgen.codegen.emit import emit
from modelgen.codegen.program import build_program
from modelgen.language import Equation, Input, Model, Parameter, State, Symbol, exp, previous, rate_of

t, u = Input("t", "1"), Input("u", "1")
k, mu = Parameter("k", "1", 2.0, (0.1, 1e5)), Parameter("mu", "1", 1.5, (0.0, 1e4))
START = (0.5, -1.0)


def oscillator(substeps: int, stiff: bool) -> Model:
    """Van der Pol's oscillator, driven."""
    x, v = Symbol("x", real=True), Symbol("v", real=True)
    force = Equation("force", mu * (1 - x**2) * v - k * x + exp(-(x**2)) * u)
    states = (
        State("x", START[0], rate=v, substeps=substeps, stiff=stiff),
        State("v", START[1], rate=force.symbol),
    )
    y = Equation("y", x + v / 10)
    return Model("driven", (t, previous(t), u, previous(u)), (k, mu), (force, *states, y), ("y",))


def cvodes(at: Any, drive: Any, values: dict[str, float]) -> tuple[Any, Any]:
    """y and dy/d(k, mu) at each time, by CVODES from knot to knot with the drive linear between them."""
    x, p, s = ca.SX.sym("x", 2), ca.SX.sym("p", 2), ca.SX.sym("s")
    step = ca.SX.sym("step", 3)  # its length, the drive at its ends
    force = p[1] * (1 - x[0] ** 2) * x[1] - p[0] * x[0]
    force += ca.exp(-(x[0] ** 2)) * (step[1] + s * (step[2] - step[1]))
    problem = {"x": x, "p": ca.vertcat(p, step), "t": s, "ode": step[0] * ca.vertcat(x[1], force)}
    tight = {"abstol": 1e-12, "reltol": 1e-12, "max_num_steps": 100_000}
    walk = ca.integrator("walk", "cvodes", problem, 0, 1, tight)
    xs, ps, steps = ca.MX.sym("x", 2), ca.MX.sym("p", 2), ca.MX.sym("step", 3)
    end = walk(x0=xs, p=ca.vertcat(ps, steps))["xf"]
    move = ca.Function("move", [xs, ps, steps], [end, ca.jacobian(end, xs), ca.jacobian(end, ps)])
    state, slope, p_value = np.array(START), np.zeros((2, 2)), [values["k"], values["mu"]]
    rows, slopes = [state], [slope]
    for i in range(1, len(at)):
        new, by_x, by_p = move(state, p_value, [at[i] - at[i - 1], drive[i - 1], drive[i]])
        state, slope = np.array(new).ravel(), np.array(by_x) @ slope + np.array(by_p)
        rows.append(state)
        slopes.append(slope)
    weights = np.array([1.0, 0.1])
    return np.array(rows) @ weights, np.einsum("i,tij->tj", weights, np.array(slopes))


AT = np.linspace(0, 3, 31)
DRIVE = np.sin(3 * AT)


@pytest.fixture(scope="module")
def reference() -> tuple[Any, Any]:
    return cvodes(AT, DRIVE, {"k": 2.0, "mu": 1.5})


@pytest.mark.parametrize("stiff, order, steps", [(False, 4, (2, 4)), (True, 3, (4, 8))])
def test_values_and_derivatives_converge_with_their_order_to_those_of_cvodes(
    reference: Any, stiff: bool, order: int, steps: tuple[int, int]
) -> None:
    errors = []
    for n in steps:
        F = build(oscillator(n, stiff))
        jac = F.jacobian(t=AT, u=DRIVE, k=2.0, mu=1.5)
        y = F(t=AT, u=DRIVE, k=2.0, mu=1.5)
        errors.append([np.abs(y - reference[0]).max(), np.abs(jac - reference[1]).max()])
    coarse, fine = np.array(errors)
    assert np.all(fine < 1e-5)
    assert np.all(coarse / fine > 0.75 * 2**order)


@pytest.mark.parametrize("stiff", [False, True])
def test_a_loop_over_the_parts_of_a_step_gives_what_writing_them_out_gives(
    stiff: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = []
    for most in (4, 5):  # parts that are written out
        monkeypatch.setattr(lower, "UNROLLED", most)
        monkeypatch.setenv("MODELGEN_CACHE", str(tmp_path / str(most)))
        (F,) = build_many([(oscillator(5, stiff), ("k", "mu"))], ALL)
        ready = F.prepare(t=AT, u=DRIVE)
        data, weight = ready.pad(np.sin(AT)[None]), ready.pad(np.ones((1, len(AT))))
        normal = ready.normal([2.0, 1.5], "real", data, weight)
        sums = ready.sumsq(np.array([[2.0, 1.5], [1.0, 0.5]]), "real", data, weight)
        found.append(
            [F(t=AT, u=DRIVE), F.jacobian(t=AT, u=DRIVE), *F.all(t=AT, u=DRIVE).values(), sums, *normal]
        )
    for loop, line in zip(*found, strict=True):
        assert np.abs(loop - line).max() <= 1e-12 * np.abs(line).max()


def test_what_is_remembered_stands_through_the_parts_of_a_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A state of another kind, which moves from sample to sample and depends on a parameter, in the rate."""
    base, kept = oscillator(5, False), Symbol("kept", real=True)
    states = [replace(s, rate=s.rate - mu * kept) if s.name == "v" else s for s in base.statements]
    model = replace(base, statements=(*states, State("kept", 0.0, kept / 2 + mu * Symbol("x", real=True))))
    slopes = []
    for most in (4, 5):
        monkeypatch.setattr(lower, "UNROLLED", most)
        monkeypatch.setenv("MODELGEN_CACHE", str(tmp_path / str(most)))
        (F,) = build_many([(model, ("k", "mu"))], ALL)
        slopes.append(F.jacobian(t=AT, u=DRIVE))
    assert np.abs(slopes[1] - slopes[0]).max() <= 1e-12 * np.abs(slopes[0]).max()


@pytest.mark.parametrize("stiff", [False, True])
def test_a_thousand_parts_take_no_more_c_than_ten(reference: Any, stiff: bool) -> None:
    few, many = (emit(build_program(oscillator(n, stiff), ("k", "mu"))).source for n in (10, 1000))
    assert len(many.splitlines()) == len(few.splitlines()) < 1000
    F = build(oscillator(1000, stiff))
    assert np.abs(F(t=AT, u=DRIVE, k=2.0, mu=1.5) - reference[0]).max() < 1e-8
    assert np.abs(F.jacobian(t=AT, u=DRIVE, k=2.0, mu=1.5) - reference[1]).max() < 1e-8


@pytest.mark.parametrize("stiff", [False, True])
def test_forty_digits_say_the_same(stiff: bool) -> None:
    samples = [{"t": mp.mpf(float(a)), "u": mp.mpf(float(b))} for a, b in zip(AT[:6], DRIVE[:6], strict=True)]
    wanted = [float(e["y"]) for e in run(oscillator(2, stiff), samples)]
    assert build(oscillator(2, stiff))(t=AT[:6], u=DRIVE[:6]) == pytest.approx(wanted, rel=1e-13)


def test_a_stiff_state_stays_in_bounds_where_steps_are_a_thousand_time_constants_long() -> None:
    """dx/dt = k (u − x): x follows u; the explicit scheme explodes."""
    x = State("x", 0.0, rate=k * (u - Symbol("x", real=True)))
    model = Model("lag", (t, previous(t), u, previous(u)), (k,), (x, Equation("y", x)), ("y",))
    implicit = replace(model, statements=(replace(x, stiff=True), Equation("y", x)))
    wanted = DRIVE - np.gradient(DRIVE, AT) / 1e4
    found = build(implicit)(t=AT, u=DRIVE, k=1e4)
    assert found[1:-1] == pytest.approx(wanted[1:-1], abs=2e-4)
    assert not np.all(np.abs(build(model)(t=AT, u=DRIVE, k=1e4)) < 10)


def test_van_der_pol_with_its_jumps_in_stiff_steps() -> None:
    """At mu = 500 it creeps for long and jumps in between, each time where it should."""
    from scipy.integrate import solve_ivp

    at = np.linspace(0, 2, 1601)
    values = {"k": 500.0, "mu": 500.0}
    solution = solve_ivp(
        lambda _, x: [x[1], 500 * ((1 - x[0] ** 2) * x[1] - x[0])], (0, 2), START, "Radau", at, rtol=1e-9
    )
    wanted = solution.y[0] + solution.y[1] / 10
    found = build(oscillator(4, True))(t=at, u=0 * at, **values)
    assert np.abs(found - wanted)[np.abs(np.gradient(wanted)) < 0.02].max() < 0.02
    assert np.sum(np.diff(np.sign(wanted)) != 0) == np.sum(np.diff(np.sign(found)) != 0) >= 2


def test_inputs_run_linearly_without_being_told() -> None:
    """Held over a step, a force that is measured comes half a sample late."""
    x = State("x", 0.0, rate=k * (u - Symbol("x", real=True)))
    told = Model("lag", (t, previous(t), u, previous(u)), (k,), (x, Equation("y", x)), ("y",))
    short = Model("lag", (t, u), (k,), (x, Equation("y", x)), ("y",))
    assert {i.name for i in short.inputs} == {i.name for i in told.inputs}
    assert build(short)(t=AT, u=DRIVE, k=3.0) == pytest.approx(build(told)(t=AT, u=DRIVE, k=3.0), rel=1e-12)


def test_the_rate_of_an_input_runs_linearly_too() -> None:
    """Of a wave of 40 samples, straight lines leave x²/3 = 0.2 %, x = π/40; held over a step, 8 %."""
    q, k = Input("q", "m"), Parameter("k", "1/s", 3.0)
    w = rate_of(q, "w", "m/s")
    x = State("x", 0.0, rate=w - k * Symbol("x", real=True), unit="m")
    t = Input("t", "s")
    f = build(Model("washout", (t, q, w), (k,), (x, Equation("y", x, "m")), ("y",)))
    at = np.arange(401) / 40
    found = f(t=at, q=np.sin(2 * np.pi * at), w=2 * np.pi * np.cos(2 * np.pi * at))
    phasor = 2j * np.pi / (2j * np.pi + 3.0)  # of x over q, once what the start left has gone
    wanted = (phasor * np.exp(2j * np.pi * at)).imag
    assert found[200:] == pytest.approx(wanted[200:], abs=3e-3)


def test_an_equation_without_a_symbol_may_stand_in_a_rate() -> None:
    """A port at which a device has nothing as yet."""
    t, u, C = Input("t", "s"), Input("u", "A"), Parameter("C", "F", 2.0)
    leak = Equation("I_l", 0, "A")
    V = State("V", 0, rate=(u - leak.symbol) / C, unit="V")
    f = build(Model("capacitor", (t, u), (C,), (leak, V), ("V",)))
    time = np.linspace(0, 1, 11)
    assert np.allclose(f.all(t=time, u=np.ones(11))["V"], time / 2)
