"""LuGre model with a spring: bristles that bend and slip, at a level that falls with speed (Stribeck).

dζ/dt = v − |v| ζ/g(v), g = (F_C + (F_S − F_C) e^(−(v/v_S)²))/σ_0,
F = σ_0 ζ + σ_1 dζ/dt + σ_2 v + k_D z + F_0.
The state is r = σ_0 ζ/F_C. Over each monotonic part of a step it follows the exact solution for the step's
mean speed, so it is stable for any stiffness of the bristles. With F_S = F_C and σ_1 = 0 it is the
modified Dahl model, h_D = F_C, ρ = σ_0/F_C.
"""

from math import inf
from typing import Any

from sympy import Symbol

from modelgen.language import Abs, Equation, Parameter, Piecewise, State, dahl_step, exp
from modelgen.models.sample import (
    F_0,
    direction,
    k_D,
    k_f,
    sample_model,
    t,
    t_prev,
    v_D,
    z_D,
    z_D_prev,
    z_D_turn,
)

SOURCE = "C. Canudas de Wit et al., IEEE Trans. Autom. Control 40 (1995) 419"

sigma_0 = Parameter("sigma_0", "N/mm", 0.34, (1e-6, inf), "stiffness of the bristles", SOURCE)
sigma_1 = Parameter("sigma_1", "N*s/mm", 0.0, (0.0, inf), "damping of the bristles", SOURCE)
sigma_2 = Parameter("sigma_2", "N*s/mm", 0.0912, (0.0, inf), "viscous damping", SOURCE)
F_C = Parameter("F_C", "N", 0.2309, (1e-6, inf), "Coulomb friction", SOURCE)
F_S = Parameter("F_S", "N", 0.3, (1e-6, inf), "friction at rest", SOURCE)
v_S = Parameter("v_S", "mm/s", 1.0, (1e-6, inf), "Stribeck velocity", SOURCE)
r_0 = Parameter("r_0", "1", 0.0, (-inf, inf), "friction state at the first sample", SOURCE)

b_f = Equation("b_f", 1, "1", text="exponent of the way into slip")
h_f = Equation("h_f", F_C, "N", text="friction level at speed")
rho_f = Equation("rho_f", sigma_0 / F_C, "1/mm", text="inverse slip length at speed")


def level(v: Any) -> Any:
    """Friction at speed v over Coulomb friction."""
    return 1 + (F_S / F_C - 1) * exp(-((v / v_S) ** 2))


way = Abs(z_D_turn - z_D_prev) + Abs(z_D - z_D_turn)
dt = t - t_prev
speed = Equation(
    "speed", Piecewise((way / dt, dt > 0), (Abs(v_D), True)), "mm/s", text="mean speed of the step"
)
g_step = Equation("g_step", level(speed), "1", text="friction at that speed over Coulomb friction")


def stroke(r: Any, dz: Any) -> Any:
    """The friction state after a monotonic displacement by `dz` [mm] from state `r`."""
    up = direction(dz)
    return up * g_step * (1 - dahl_step(1 - up * r / g_step, rho_f * up * dz / g_step, b_f))


before = Symbol("r", real=True)
r_turn = Equation("r_turn", stroke(before, z_D_turn - z_D_prev), "1", text="friction state where it turns")
r = State("r", r_0, stroke(r_turn, z_D - z_D_turn), unit="1", text="friction state σ_0 ζ/F_C")
bend = Equation(
    "bend", v_D - Abs(v_D) * r / level(v_D), "mm/s", text="speed at which the bristles bend, dζ/dt"
)
F_b = Equation("F_b", h_f * r + sigma_1 * bend, "N", text="force of the bristles")
F_r = Equation("F_r", F_b + sigma_2 * v_D + k_f * z_D + F_0, "N", "(7)", "force of the sample")

lugre = sample_model(
    "lugre",
    (k_D, sigma_0, sigma_1, sigma_2, F_C, F_S, v_S, F_0, r_0),
    (rho_f, b_f, speed, g_step, r_turn, r, bend, h_f, k_f, F_b, F_r),
    source=SOURCE,
    text="LuGre friction with a spring, force from displacement",
)
