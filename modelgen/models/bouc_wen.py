"""Bouc–Wen model with a spring and a dashpot, in the normalised form that has no redundant constants.

dr/dz = ρ (1 − |r|ⁿ (σ sgn(v r) + 1 − σ)), F = h_D r + c_D v + k_D z + F_0. With n = σ = 1 it is the
modified Dahl model. The usual constants are, for a state of unit z_0, A = ρ z_0, β = σ ρ/z_0ⁿ⁻¹ and
γ = (1 − σ) ρ/z_0ⁿ⁻¹.

The state follows the exact solution over each monotonic part of a step, for every n >= 1.
"""

from typing import Any

from sympy import Symbol

from modelgen.language import Equation, Parameter, State, bouc_wen_step
from modelgen.models.sample import (
    F_0,
    c_D,
    direction,
    h_D,
    h_f,
    k_D,
    k_f,
    r_0,
    rho,
    rho_f,
    sample_model,
    v_D,
    z_D,
    z_D_prev,
    z_D_turn,
)

SOURCE = "R. Bouc, Acustica 24 (1971) 16; Y. K. Wen, J. Eng. Mech. Div. ASCE 102 (1976) 249"
NORMAL = f"{SOURCE}; F. Ikhouane, J. Rodellar, Systems with Hysteresis (2007), ch. 4"

n = Parameter("n", "1", 1.0, (1.0, 10.0), "sharpness of the way into slip", NORMAL)
sigma = Parameter("sigma", "1", 1.0, (0.5, 10.0), "1/2: unloading is elastic; more: it is softer", NORMAL)


def stroke(r: Any, dz: Any) -> Any:
    """The hysteretic state after a monotonic displacement by `dz` [mm] from state `r`."""
    up = direction(dz)
    return up * bouc_wen_step(up * r, rho_f * up * dz, n, sigma)


before = Symbol("r", real=True)
r_turn = Equation("r_turn", stroke(before, z_D_turn - z_D_prev), "1", text="state where it turns")
r = State("r", r_0, stroke(r_turn, z_D - z_D_turn), unit="1", text="hysteretic state")
F_r = Equation("F_r", h_f * r + c_D * v_D + k_f * z_D + F_0, "N", "(7)", "force of the sample")

bouc_wen = sample_model(
    "bouc_wen",
    (k_D, c_D, h_D, rho, n, sigma, F_0, r_0),
    (rho_f, r_turn, r, h_f, k_f, F_r),
    source=NORMAL,
    text="Bouc–Wen hysteresis with a spring and a dashpot, force from displacement",
)
