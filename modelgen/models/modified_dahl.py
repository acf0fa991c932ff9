"""Modified Dahl model of a magnetorheological elastomer: friction, spring, dashpot (MRE paper, eq. 7–13).

The friction state r follows the exact solution of (8) over each monotonic part of a step, for every exponent
b > 0; explicit Euler steps err by 1e-2 N at 100 samples a cycle. ρ is in 1/mm, printed as s/mm.
"""

from dataclasses import replace
from typing import Any

from sympy import Symbol

from modelgen.language import Equation, Model, Parameter, State, check_option, dahl_step, tanh
from modelgen.models.sample import (
    F_0,
    TABLE_4,
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

b = Parameter("b", "1", 1.0, (0.1, 10.0), "exponent, shape of the hysteresis", "MRE paper, eq. 9", known=True)
A_z = Parameter("A_z", "mm", 3.01, (1e-6, 1e6), "amplitude of the cycle before", TABLE_4, known=True)

b_f = Equation("b_f", b, "1", "(8)", "exponent")


def stroke(r: Any, dz: Any) -> Any:
    """The friction state after a monotonic displacement by `dz` [mm] from state `r`: (8) solved exactly."""
    up = direction(dz)
    return up * (1 - dahl_step(1 - up * r, rho_f * up * dz, b_f))


r_prev = Symbol("r", real=True)  # its value before the step, up to its own update
r_turn = Equation("r_turn", stroke(r_prev, z_D_turn - z_D_prev), "1", "(8)", "friction state where it turns")
r = State("r", r_0, stroke(r_turn, z_D - z_D_turn), unit="1", ref="(8), (9)", text="friction state F_D/h_D")
F_D = Equation("F_D", h_f * r, "N", "(7)", "friction force")
F_r = Equation("F_r", F_D + c_D * v_D + k_f * z_D + F_0, "N", "(7), (12)", "force of the sample")


def build(initial: str = "free") -> Model:
    """The model with r(0) = r_0, a parameter ("free"; −1 in the paper), or that of a steady cycle ("steady").

    A steady cycle of amplitude A_z that starts at its lowest point has r(0) = −tanh(ρ A_z); exact for b = 1.
    """
    check_option("initial", initial, ("free", "steady"))
    free = initial == "free"
    start = r_0.symbol if free else -tanh(rho * A_z)
    return sample_model(
        "modified_dahl",
        (k_D, c_D, h_D, rho, F_0, b, r_0 if free else A_z),
        (rho_f, b_f, r_turn, replace(r, initial=start), h_f, k_f, F_D, F_r),
        source="MRE paper, eq. 7–13",
        text="modified Dahl model of a magnetorheological elastomer, force from displacement",
        options=(("initial", initial),),
        drops=(("A_z", None),) if free else (),
        builder=build,
    )


modified_dahl = build()
