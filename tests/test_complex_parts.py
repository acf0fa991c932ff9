"""Complex numbers where real ones are wanted: followed exactly, or refused; never their real part alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import modelgen as mg
from modelgen.errors import InputError
from modelgen.export import exact
from modelgen.language import (
    Equation,
    Implicit,
    Input,
    Model,
    Output,
    Parameter,
    State,
    complex_parameter,
    previous,
)  # fmt: skip
from modelgen.language.functions import eddy_factor, gamma, powj, sinhc

t, u = Input("t", "s"), Input("u", "1")
t_0, u_0 = previous(t), previous(u)
c = complex_parameter("c", "1", 0.8 - 0.3j)
p = Parameter("p", "1", 0.7)
tau = Parameter("tau", "s", 0.5)
U = np.linspace(0.5, 2.0, 4)


def over_u(*statements: Any, id: str = "over_u") -> Model:
    return Model(
        id,
        inputs=(u,),
        parameters=(c, p),
        statements=statements,
        outputs=(Output(statements[-1].name),),
    )


def in_time(*statements: Any, id: str = "in_time") -> Model:
    return Model(
        id, inputs=(t, u, t_0, u_0), parameters=(c, tau), statements=statements, outputs=(Output("F"),)
    )


def value(expr: Any, **at: complex) -> complex:
    return complex(expr.subs({k.symbol: v for k, v in ((c, at.get("c", 0.8 - 0.3j)), (p, 0.7))}).evalf(30))


SLACK = {"rel": 1e-13, "abs": 1e-300}


@pytest.mark.parametrize("eta", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("sign", [-1, 1])
def test_the_small_part_of_a_root_keeps_all_its_digits(eta: float, sign: int) -> None:
    model = over_u(Equation("y", sp.sqrt(sign * (1 - sp.I * u.symbol))), id="root")
    y = mg.build(model, wait=True)(u=np.array([eta]), c_re=0.8, c_im=-0.3, p=0.7)[0]
    wanted = complex(mp.sqrt(mp.mpc(sign, -sign * mp.mpf(eta))))
    assert (y.real, y.imag) == (pytest.approx(wanted.real, **SLACK), pytest.approx(wanted.imag, **SLACK))


@pytest.mark.parametrize("function", [sp.tanh, sp.tan])
@pytest.mark.parametrize("x", [0.9 + 1e-8j, 1e-8 + 0.9j, 1e-8 + 1e-8j, -1e-9 + 1.2j, 30 - 2j, -400 + 1e-3j])
def test_tanh_and_tan_keep_their_small_part(function: Any, x: complex) -> None:
    model = over_u(Equation("y", function(c.symbol * u.symbol)), id=function.__name__)
    y = mg.build(model, wait=True)(u=np.array([1.0]), c_re=x.real, c_im=x.imag, p=0.7)[0]
    with mp.workdps(400):
        wanted = getattr(mp, function.__name__)(mp.mpc(x.real, x.imag))
        wanted = float(wanted.real), float(wanted.imag)
    assert (y.real, y.imag) == (pytest.approx(wanted[0], **SLACK), pytest.approx(wanted[1], **SLACK))


def slopes(model: Model, **inputs: Any) -> tuple[Any, Any]:
    """The Jacobian's columns, and central differences."""
    f = mg.build(model, wait=True)
    at = {q.name: float(q.default or 0.0) for q in model.scalar_parameters}
    J = f.jacobian(**inputs, **at)
    differences = []
    for name in f.wrt:
        h = 1e-6
        above, below = ({**at, name: at[name] + s * h} for s in (1, -1))
        differences.append((f(**inputs, **above) - f(**inputs, **below)) / (2 * h))
    return J, np.stack(differences, axis=-1)


T = np.linspace(0, 3, 61)
SWING = {"t": T, "u": np.sin(2 * T) + 0.2}


@pytest.mark.parametrize(
    "state",
    [
        State("x", 0, sp.Symbol("x") / 2 + sp.re(c.symbol**2 * u.symbol)),
        State("x", sp.Abs(c.symbol), sp.Symbol("x") / 2 + sp.im(c.symbol) * u.symbol),
        State("x", 0, rate=(sp.re(c.symbol**2 * u.symbol) - sp.Symbol("x")) / tau),
    ],
    ids=["update", "initial", "rate"],
)
def test_derivatives_by_both_parts_pass_through_a_state(state: State) -> None:
    J, differences = slopes(in_time(state, Equation("F", state.symbol)), **SWING)
    assert np.abs(differences).max() > 0.1
    assert pytest.approx(differences, abs=1e-8) == J


@pytest.mark.parametrize("part", [sp.re, sp.im, sp.Abs])
def test_a_rate_takes_parts_of_a_complex_equation(part: Any) -> None:
    C = Equation("C", c.symbol**2 * u.symbol)
    x = State("x", 0, rate=(part(C.symbol) - sp.Symbol("x")) / tau)
    drive, number = 1.5 + np.sin(2 * T), {sp.re: np.real, sp.im: np.imag, sp.Abs: np.abs}[part]
    f = mg.build(in_time(C, x, Equation("F", x.symbol)), wait=True)
    y = f(t=T, u=drive, c_re=0.8, c_im=-0.3, tau=0.5)

    def rate(time: float, at: Any) -> Any:
        return (number((0.8 - 0.3j) ** 2 * np.interp(time, T, drive)) - at) / 0.5

    done = solve_ivp(rate, (0, 3), [0.0], t_eval=T, rtol=1e-8, atol=1e-10, max_step=0.02)
    assert y == pytest.approx(done.y[0], abs=1e-5)


def test_a_rate_takes_the_root_of_an_implicit_equation(tmp_path: Path) -> None:
    y = Implicit("y", sp.Symbol("y") ** 3 + sp.Symbol("y") - u.symbol, (-9, 9), "1")
    two = Equation("two", 2)  # holds no symbol
    x = State("x", 0, rate=(two.symbol * y.symbol - sp.Symbol("x")) / tau)
    model = in_time(y, two, x, Equation("F", x.symbol), id="rooted")
    F = mg.build(model, wait=True)(**SWING, c_re=0.8, c_im=-0.3, tau=0.5)

    def rate(time: float, at: Any) -> Any:
        drive = np.interp(time, T, SWING["u"])
        return (2 * brentq(lambda y: y**3 + y - drive, -9, 9) - at) / 0.5

    done = solve_ivp(rate, (0, 3), [0.0], t_eval=T, rtol=1e-8, atol=1e-10, max_step=0.02)
    assert pytest.approx(done.y[0], abs=1e-5) == F
    few = [{"t": float(a), "u": float(b)} for a, b in zip(T[:4], SWING["u"][:4], strict=True)]
    assert [float(row["F"]) for row in exact.run(model, few)] == pytest.approx(F[:4], abs=1e-12)
    J, differences = slopes(model, **SWING)
    assert pytest.approx(differences, abs=1e-8) == J


@pytest.mark.parametrize("pick", [sp.Max, sp.Min])
def test_a_residual_may_end_in_a_choice(pick: Any) -> None:
    y = sp.Symbol("y")
    root = Implicit("y", pick(y - u.symbol, 2 * (y - u.symbol)), (-9, 9), "1")
    f = mg.build(over_u(root, Equation("F", y * p), id="chosen"), wait=True)
    assert f(u=U, c_re=0.8, c_im=-0.3, p=0.7) == pytest.approx(0.7 * U, rel=1e-12)


Y = sp.Symbol("y", real=True)


@pytest.mark.parametrize(
    ("statements", "says"),
    [
        ((Implicit("y", Y * sp.Abs(c.symbol) - u.symbol, (-9, 9), "1"),), "'c', which is complex"),
        ((Implicit("y", Y - u.symbol, (-c.symbol, 9), "1"),), "-c is complex"),
        ((Equation("y", sp.asinh(c.symbol)),), "asinh takes real numbers"),
        ((Equation("y", powj(c.symbol, p)),), "powj takes real numbers"),
        ((Equation("y", powj(u, c.symbol)),), "powj takes real numbers"),
        ((Equation("y", eddy_factor(c.symbol)),), "eddy_factor takes real numbers"),
        ((Equation("y", sinhc(c.symbol)),), "sinhc takes real numbers"),
        ((Equation("y", gamma(c.symbol)),), "gamma takes real numbers"),
        ((Equation("y", sp.Piecewise((1, c.symbol > p.symbol), (2, True))),), "no order"),
    ],
)
def test_what_takes_real_numbers_refuses_complex_ones(statements: Any, says: str) -> None:
    with pytest.raises(InputError, match=says):
        mg.build(over_u(*statements, id="refused"), wait=True)


@pytest.mark.parametrize(
    "state",
    [
        State("x", c.symbol, sp.Symbol("x") / 2),
        State("x", 0, sp.Symbol("x") / 2 + c.symbol * u.symbol),
        State("x", 0, rate=(c.symbol * u.symbol - sp.Symbol("x")) / tau),
    ],
)
def test_a_state_is_real(state: State) -> None:
    with pytest.raises(InputError, match=r"'x': .*complex, wanted a real number"):
        mg.build(in_time(state, Equation("F", state.symbol), id="refused"), wait=True)
