"""What all models of a sample between a shaker and a force sensor share: its motion, its offset, its ports.

A model adds the equations of its force F_r to `motion`; a port is there where its equation is.
"""

from math import inf
from typing import Any

from modelgen.language import (
    Equation,
    Input,
    Model,
    Output,
    Parameter,
    Piecewise,
    Port,
    Statement,
    acceleration_of,
    previous,
    rate_of,
    turning_point_of,
)

TABLE_4 = "MRE paper, Table 4, stage 4, case M0"

t = Input("t", "s", "time")
z = Input("z", "mm", "displacement", range=(-3.0, 3.0))
t_prev, z_prev, z_turn = previous(t), previous(z), turning_point_of(z)
v = rate_of(z, "v", "mm/s")
a = acceleration_of(z, "a", "mm/s**2")

k_D = Parameter("k_D", "N/mm", 0.3834, (0.0, inf), "stiffness; the paper searches from 0 to 1.2", TABLE_4)
c_D = Parameter("c_D", "N*s/mm", 0.0912, (0.0, inf), "damping; the paper searches from 0 to 1.8", TABLE_4)
h_D = Parameter("h_D", "N", 0.0353, (0.0, inf), "Coulomb friction; the paper searches from 0 to 0.7", TABLE_4)
rho = Parameter("rho", "1/mm", 1.46, (1e-9, 1e9), "σ/h_D; the paper searches from 1 to 2", TABLE_4)
F_0 = Parameter("F_0", "N", 1.3, (-inf, inf), "offset in the force", TABLE_4)
r_0 = Parameter("r_0", "1", -1.0, (-1.0, 1.0), "friction state at the first sample", "MRE paper, sec. 4")

z_D = Equation("z_D", z, "mm", "(7)", "displacement of the sample")
v_D = Equation("v_D", v, "mm/s", "(11)", "its velocity")
z_D_prev = Equation("z_D_prev", z_prev, "mm", text="displacement one sample before")
z_D_turn = Equation("z_D_turn", z_turn, "mm", text="displacement where it turns in between, if it does")
motion = (z_D, v_D, z_D_prev, z_D_turn)

rho_f = Equation("rho_f", rho, "1/mm", "(9)", "inverse slip length")
h_f = Equation("h_f", h_D, "N", "(7)", "friction level")
k_f = Equation("k_f", k_D, "N/mm", "(7)", "stiffness of the spring")
F = Equation("F", Equation("F_r", 0, "N").symbol, "N", text="what the force sensor shows")

AT = {"z": z_D, "v": v_D, "z_prev": z_D_prev, "z_turn": z_D_turn, "t": t, "t_prev": t_prev, "a": a}
PORTS = (
    ("displacement", "displacement", "z_D", "z v z_prev z_turn t t_prev a"),
    ("force", "force", "F_r", "z v z_prev z_turn t t_prev a"),
    ("force", "friction", "h_f", "v z z_prev z_turn t t_prev r"),
    ("force", "spring", "k_f", "z v z_prev z_turn t t_prev"),
    ("force", "dahl", "b_f", "z v t"),
    ("force", "slip", "rho_f", "z v t"),
    ("sensor", "sensor", "F", "t t_prev"),
)
"""Name and kind of each port, the equation that it changes, and what an effect may use there."""


def direction(dz: Any) -> Any:
    """1 for a displacement upwards or none, −1 downwards."""
    return Piecewise((1, dz >= 0), (-1, True))


def sample_model(
    id: str, parameters: tuple[Any, ...], statements: tuple[Statement, ...], **more: Any
) -> Model:
    """The model whose force F_r follows from `statements`; t [s], z [mm] → F [N].

    A port of PORTS is left out where `statements` lacks its equation. `more` goes to `Model`.
    """
    whole = (*motion, *statements, F)
    there: dict[str, Any] = {s.name: s for s in whole} | AT
    ports = tuple(
        Port(name, kind, equation, tuple((n, there[n].symbol) for n in using.split()))
        for name, kind, equation, using in PORTS
        if equation in there
    )
    inputs = (t, z, t_prev, z_prev, z_turn, v, a)
    outputs = (Output("F", measured_as=("F_m",)),)
    return Model(id, inputs, parameters, whole, outputs, ports, checked=True, **more)
