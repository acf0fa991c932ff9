"""Models of a sample other than Dahl's, against ODE solvers, analytic responses and each other's limits."""

from __future__ import annotations

from collections.abc import Callable
from math import gamma
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import modelgen as mg
import modelgen.models as models
from modelgen.effects import CATALOGUE

NEW = ("kelvin_voigt", "bouc_wen", "lugre", "four_parameter_viscoelastic", "fractional_kelvin_voigt")
OFF = {"k_D": 0.0, "c_D": 0.0, "F_0": 0.0}
A, OMEGA = 2.0, 2.0
T = np.linspace(0, 3 * np.pi, 601)  # three cycles of ω = 2 rad/s
Z = -A * np.cos(OMEGA * T)


def integrate(slope: Callable[[float, Any, float], Any], start: float) -> np.ndarray:
    """x(T) from dx/dt = slope(t, x, dz/dt) by DOP853, restarted where the displacement turns."""
    found = [np.array([start])]
    for k in range(6):
        at = T[100 * k : 100 * (k + 1) + 1]
        done = solve_ivp(
            lambda t, x: slope(t, x, A * OMEGA * np.sin(OMEGA * t)),
            (at[0], at[-1]), [found[-1][-1]], "DOP853", at, rtol=1e-11, atol=1e-12, max_step=0.01,
        )  # fmt: skip
        found.append(done.y[0][1:])
    return np.concatenate(found)


@pytest.mark.parametrize(("n", "sigma"), [(1.0, 1.0), (1.0, 0.5), (1.6, 2.0), (2.0, 0.7), (3.0, 1.0)])
def test_bouc_wen_follows_its_differential_equation(n: float, sigma: float) -> None:
    rho = 1.46
    wanted = integrate(
        lambda t, r, v: rho * v * (1 - np.abs(r) ** n * (sigma * np.sign(v * r) + 1 - sigma)), -0.3
    )
    f = mg.build(models.bouc_wen)
    found = f(t=T, z=Z, **OFF, h_D=1.0, rho=rho, n=n, sigma=sigma, r_0=-0.3)
    assert found == pytest.approx(wanted, abs=2e-10)


def test_bouc_wen_in_few_steps_is_the_same_as_in_many() -> None:
    f, few = mg.build(models.bouc_wen), slice(None, None, 50)
    values = {**OFF, "h_D": 1.0, "rho": 30.0, "n": 2.5, "sigma": 1.5}
    many = f(t=T, z=Z, **values)
    assert f(t=T[few], z=Z[few], z_turn=np.r_[Z[0], Z[few][:-1]], v=0 * T[few], a=0 * T[few], **values) == (
        pytest.approx(many[few], abs=1e-9)
    )


def test_bouc_wen_and_lugre_hold_the_modified_dahl_model() -> None:
    dahl = mg.build(models.modified_dahl)(t=T, z=Z, h_D=0.2309, rho=1.44, c_D=0.09)
    assert mg.build(models.bouc_wen)(t=T, z=Z, h_D=0.2309, rho=1.44, c_D=0.09) == pytest.approx(
        dahl, abs=1e-11
    )
    lugre = {"F_C": 0.2309, "F_S": 0.2309, "sigma_0": 0.2309 * 1.44, "sigma_2": 0.09, "r_0": -1.0}
    assert mg.build(models.lugre)(t=T, z=Z, **lugre) == pytest.approx(dahl, abs=1e-12)


LUGRE = {"sigma_0": 1.5, "sigma_1": 0.05, "F_C": 0.4, "F_S": 0.7, "v_S": 1.0}


def lugre_force(zeta: np.ndarray, v: np.ndarray) -> np.ndarray:
    g = (LUGRE["F_C"] + (LUGRE["F_S"] - LUGRE["F_C"]) * np.exp(-((v / LUGRE["v_S"]) ** 2))) / LUGRE["sigma_0"]
    return LUGRE["sigma_0"] * zeta + LUGRE["sigma_1"] * (v - np.abs(v) * zeta / g)


def test_lugre_follows_its_differential_equation_with_an_error_that_falls_with_the_square_of_the_step() -> (
    None
):
    s, c, h, w = LUGRE["sigma_0"], LUGRE["F_C"], LUGRE["F_S"] - LUGRE["F_C"], LUGRE["v_S"]

    def slope(t: float, x: Any, v: float) -> Any:
        return v - abs(v) * x * s / (c + h * np.exp(-((v / w) ** 2)))

    wanted = lugre_force(integrate(slope, 0.1), A * OMEGA * np.sin(OMEGA * T))
    f, values = mg.build(models.lugre), {"k_D": 0.0, "sigma_2": 0.0, "F_0": 0.0, "r_0": 0.1 * s / c, **LUGRE}
    error = [np.abs(f(t=T[::k], z=Z[::k], **values) - wanted[::k]).max() for k in (1, 2, 4)]
    assert error[0] < 5e-4
    assert error[1] / error[0] > 3 and error[2] / error[1] > 3


def test_lugre_is_exact_at_constant_speed_and_stays_in_bounds_with_stiff_bristles() -> None:
    t = np.linspace(0, 4, 9)
    g = (0.4 + 0.3 * np.exp(-0.25)) / 1.5
    f, values = mg.build(models.lugre), {**OFF, "sigma_2": 0.0, "r_0": 0.0, **LUGRE, "sigma_1": 0.0}
    del values["c_D"]
    assert f(t=t, z=0.5 * t, **values) == pytest.approx(1.5 * g * (1 - np.exp(-0.5 * t / g)), abs=1e-9)
    stiff = f(t=T[::20], z=Z[::20], **{**values, "sigma_0": 1e6})
    assert np.abs(stiff).max() <= LUGRE["F_S"] + 1e-9


def test_kelvin_voigt_is_spring_and_dashpot() -> None:
    found = mg.build(models.kelvin_voigt)(t=T, z=Z, k_D=0.4, c_D=0.1, F_0=1.3)
    assert found == pytest.approx(1.3 + 0.4 * Z + 0.1 * A * OMEGA * np.sin(OMEGA * T), abs=1e-6)


def test_the_maxwell_arm_follows_its_differential_equation() -> None:
    tau = 0.3
    wanted = 0.7 * integrate(lambda t, q, v: v - q / tau, -A)
    f = mg.build(models.four_parameter_viscoelastic)
    found = f(t=T, z=Z, **OFF, k_M=0.7, tau_M=tau)
    assert found == pytest.approx(wanted, abs=2e-4)  # z is linear between samples: error (ω dt)²/12
    spring = f(t=T, z=Z, **OFF, k_M=0.7, tau_M=1e6)
    assert spring == pytest.approx(0.7 * Z, abs=1e-4)


@pytest.mark.parametrize("alpha", [0.16, 0.5, 0.8])
def test_the_springpot_is_the_fractional_derivative_of_a_power(alpha: float) -> None:
    """D^α t² = 2 t^(2−α)/Γ(3−α) (Caputo)."""
    t = np.linspace(0, 20, 4001)
    found = mg.build(models.fractional_kelvin_voigt)(t=t, z=t**2, k_D=0.0, F_0=0.0, C=1.0, alpha=alpha)
    wanted = 2 * t ** (2 - alpha) / gamma(3 - alpha)
    after = 400  # z is linear between samples: error (dt/t)^(2−α)
    assert found[after:] == pytest.approx(wanted[after:], rel=5e-4)


def test_the_springpot_agrees_with_gruenwald_and_letnikov() -> None:
    """D^α z = Σ (−1)^k binom(α, k) z(t − k dt)/dt^α, first order in dt, extrapolated."""
    alpha, t = 0.35, np.linspace(0, 6, 2401)
    z = np.sin(3 * t) ** 2 * t

    def sum_of_differences(every: int) -> np.ndarray:
        x, dt = z[::every], every * t[1]
        weights = np.cumprod(np.r_[1.0, (np.arange(1, len(x)) - 1 - alpha) / np.arange(1, len(x))])
        return np.convolve(weights, x)[: len(x)] / dt**alpha

    wanted = 2 * sum_of_differences(1)[::2] - sum_of_differences(2)
    found = mg.build(models.fractional_kelvin_voigt)(t=t, z=z, k_D=0.0, F_0=0.0, C=1.0, alpha=alpha)[::2]
    assert found == pytest.approx(wanted, abs=5e-4 * np.abs(wanted).max())


@pytest.mark.parametrize("name", NEW)
def test_derivatives_agree_with_differences(name: str) -> None:
    model = getattr(models, name)
    f = mg.build(model)
    values = {p.name: p.default for p in model.scalar_parameters if p.name in f.wrt}
    values |= {k: x for k, x in {"n": 1.7, "sigma": 1.3, "sigma_1": 0.02, "r_0": -0.4}.items() if k in values}
    exact = f.jacobian(t=T[::5], z=Z[::5], **values)
    for k, p in enumerate(f.wrt):
        h = 1e-5 * max(abs(values[p]), 0.1)
        high, low = (f(t=T[::5], z=Z[::5], **{**values, p: values[p] + d}) for d in (h, -h))
        error = np.abs(exact[:, k] - (high - low) / (2 * h)).max()
        assert error < 2e-6 * np.abs(exact[:, k]).max() + 1e-9, p


@pytest.mark.parametrize("name", NEW)
def test_the_catalogue_attaches(name: str) -> None:
    """What fits the modified Dahl model fits these too, but for friction at those that have none."""
    model = getattr(models, name)
    of_dahl = {e.id for e in CATALOGUE if e.fits(models.modified_dahl)}
    fitting = [e for e in CATALOGUE if e.fits(model)]
    friction = {"dahl_exponent", "stribeck_friction", "position_dependent_friction", "asymmetric_friction"}
    friction |= {"rate_dependent_friction", "running_in"}
    missing = {"bouc_wen": {"dahl_exponent"}, "lugre": set()}.get(name, friction)
    assert of_dahl - {e.id for e in fitting} <= missing
    for e in fitting:
        extended = e.extend(model, e.fits(model)[0])
        assert len(extended.parameters) > len(model.parameters)
