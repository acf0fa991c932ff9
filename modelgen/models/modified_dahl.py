"""Modified Dahl model of a magnetorheological elastomer: friction, spring, dashpot (MRE paper, eq. 7–13).

The friction state r follows the exact solution of (8) over each monotonic part of a step, for every exponent
b > 0; explicit Euler steps err by 1e-2 N at 100 samples a cycle. ρ is in 1/mm, printed as s/mm.
"""

from dataclasses import replace
from typing import Any

from sympy import Symbol

from modelgen.language import (
    Equation,
    Input,
    Model,
    Output,
    Parameter,
    Piecewise,
    Port,
    State,
    acceleration_of,
    check_option,
    dahl_step,
    previous,
    rate_of,
    tanh,
    turning_point_of,
)

TABLE_4 = "MRE paper, Table 4, stage 4, case M0"
ANY = float("inf")

t = Input("t", "s", "time")
z = Input("z", "mm", "displacement", range=(-3.0, 3.0))
t_prev, z_prev, z_turn = previous(t), previous(z), turning_point_of(z)
v = rate_of(z, "v", "mm/s")
a = acceleration_of(z, "a", "mm/s**2")

k_D = Parameter("k_D", "N/mm", 0.3834, (0.0, ANY), "stiffness, searched from 0 to 1.2", TABLE_4)
c_D = Parameter("c_D", "N*s/mm", 0.0912, (0.0, ANY), "damping, searched from 0 to 1.8", TABLE_4)
h_D = Parameter("h_D", "N", 0.0353, (0.0, ANY), "Coulomb friction, searched from 0 to 0.7", TABLE_4)
rho = Parameter("rho", "1/mm", 1.46, (1e-3, 1e3), "σ/h_D, searched from 1 to 2", TABLE_4)
F_0 = Parameter("F_0", "N", 1.3, (-ANY, ANY), "offset in the force", TABLE_4)
b = Parameter("b", "1", 1.0, (0.1, 10.0), "exponent, shape of the hysteresis", "MRE paper, eq. 9", known=True)
r_0 = Parameter("r_0", "1", -1.0, (-1.0, 1.0), "friction state at the first sample", "MRE paper, sec. 4")
A_z = Parameter("A_z", "mm", 3.01, (1e-6, 1e6), "amplitude of the cycle before", TABLE_4, known=True)

z_D = Equation("z_D", z, "mm", "(7)", "displacement of the sample")
v_D = Equation("v_D", v, "mm/s", "(11)", "its velocity")
z_D_prev = Equation("z_D_prev", z_prev, "mm", text="displacement one sample before")
z_D_turn = Equation("z_D_turn", z_turn, "mm", text="displacement where it turns in between, if it does")
rho_f = Equation("rho_f", rho, "1/mm", "(9)", "inverse slip length")
b_f = Equation("b_f", b, "1", "(8)", "exponent")


def stroke(r: Any, dz: Any) -> Any:
    """The friction state after a monotonic displacement by `dz` [mm] from state `r`: (8) solved exactly."""
    up = Piecewise((1, dz >= 0), (-1, True))
    return up * (1 - dahl_step(1 - up * r, rho_f * up * dz, b_f))


r_prev = Symbol("r", real=True)  # its value before the step, up to its own update
r_turn = Equation("r_turn", stroke(r_prev, z_D_turn - z_D_prev), "1", "(8)", "friction state where it turns")
r = State("r", r_0, stroke(r_turn, z_D - z_D_turn), unit="1", ref="(8), (9)", text="friction state F_D/h_D")
h_f = Equation("h_f", h_D, "N", "(7)", "friction level")
k_f = Equation("k_f", k_D, "N/mm", "(7)", "stiffness of the spring")
F_D = Equation("F_D", h_f * r, "N", "(7)", "friction force")
F_r = Equation("F_r", F_D + c_D * v_D + k_f * z_D + F_0, "N", "(7), (12)", "force of the sample")
F = Equation("F", F_r, "N", text="what the force sensor shows")


def build(initial: str = "free") -> Model:
    """The model with r(0) = r_0, a parameter ("free"; −1 in the paper), or that of a steady cycle ("steady").

    A steady cycle of amplitude A_z that starts at its lowest point has r(0) = −tanh(ρ A_z); exact for b = 1.
    """
    check_option("initial", initial, ("free", "steady"))
    free = initial == "free"
    start = r_0.symbol if free else -tanh(rho * A_z)
    path = {"z": z_D, "v": v_D, "z_prev": z_D_prev, "z_turn": z_D_turn, "t": t, "t_prev": t_prev}

    def variables(*names: str, **more: Any) -> tuple[tuple[str, Any], ...]:
        return tuple((n, q.symbol) for n, q in {**{n: path[n] for n in names}, **more}.items())

    return Model(
        "modified_dahl",
        inputs=(t, z, t_prev, z_prev, z_turn, v, a),
        parameters=(k_D, c_D, h_D, rho, F_0, b, r_0 if free else A_z),
        statements=(
            z_D, v_D, z_D_prev, z_D_turn, rho_f, b_f, r_turn,
            replace(r, initial=start), h_f, k_f, F_D, F_r, F,
        ),
        outputs=(Output("F", measured_as=("F_m",)),),
        ports=(
            Port("displacement", "displacement", "z_D", variables(*path)),
            Port("force", "force", "F_r", variables(*path, a=a)),
            Port("force", "friction", "h_f", variables("v", "z", "t", r=r)),
            Port("force", "spring", "k_f", variables("z", "v", "z_prev", "z_turn", "t")),
            Port("force", "dahl", "b_f", variables("z", "v", "t")),
            Port("force", "slip", "rho_f", variables("z", "v", "t")),
            Port("sensor", "sensor", "F", variables("t", "t_prev")),
        ),
        source="MRE paper, eq. 7–13",
        text="modified Dahl model of a magnetorheological elastomer, force from displacement",
        options=(("initial", initial),),
        builder=build,
        checked=True,
    )  # fmt: skip


modified_dahl = build()
