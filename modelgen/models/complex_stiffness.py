"""Stiffness and loss angle of the modified Dahl model in a steady cycle (MRE paper, eq. 4–12, Tab. 2 and 3).

With z = −A_z cos θ, θ = 2πft, b = 1, the friction state runs between ∓tanh(ρ A_z) and both halves of the
cycle are alike, whatever r_0 was. Spring and dashpot are together one complex stiffness K. The offset F_0 is
left out.

As the paper's tables have it, k_s = F_max/A_z by the greatest force of the loop, and loss_angle is the
arcsine of F(z = 0)/F_max; a lock-in amplifier, which shows the first harmonic, tells less and another angle.
"""

from typing import Any

from sympy import Symbol

from modelgen.language import (
    Equation,
    Implicit,
    Input,
    Min,
    Model,
    Output,
    Parameter,
    Port,
    arg,
    asin,
    cos,
    exp,
    im,
    j,
    pi,
    re,
    sign,
    sin,
    tanh,
)
from modelgen.models.sample import c_D, h_D, k_D, rho

f = Input("f", "Hz", "frequency", range=(0.1, 10.0))

A_z = Parameter("A_z", "mm", 0.4, (1e-6, 1e6), "displacement amplitude", "MRE paper, Table 3", known=True)

omega = Equation("omega", 2 * pi * f, "rad/s", text="angular frequency")
K = Equation("K", k_D + j * omega * c_D, "N/mm", "(7)", "complex stiffness of spring and dashpot")
K_re = Equation("K_re", re(K), "N/mm", text="its storage part")
K_im = Equation("K_im", im(K), "N/mm", text="its loss part")
r_m = Equation("r_m", tanh(rho * A_z), "1", "(9)", "friction state where the displacement turns")


def force(c: Any, s: Any, d: Any = 1) -> Any:
    """Force at c = cos θ, s = sin θ: (12) with (9) solved from −d r_m; d = 1 while z grows, else −1."""
    friction = d * h_D * (1 - (1 + r_m) * exp(-rho * A_z * (1 - d * c)))
    return friction + A_z * (K_im * s - K_re * c)


def slope(theta: Any) -> Any:
    """dF/dθ while the displacement grows."""
    friction = h_D * (1 + r_m) * rho * A_z * sin(theta) * exp(-rho * A_z * (1 - cos(theta)))
    return friction + A_z * (K_im * cos(theta) + K_re * sin(theta))


# K alone has its peak at π − arg K, and friction moves it towards π, where it is when nothing is lost.
# Somewhat beyond either end dF/dθ has opposite signs, for every K with 0 <= arg K < π and every h_D >= 0.
beyond = pi - arg(K)
theta_pk = Implicit(
    "theta_pk",
    slope(Symbol("theta_pk", real=True)),
    (9 * beyond / 10, pi + beyond / 10),
    text="phase of the greatest force",
)
F_pk = Equation("F_pk", force(cos(theta_pk), sin(theta_pk)), "N", "(12)", "greatest force on the sample")
A_F = Equation("A_F", F_pk, "N", "(4)", "force amplitude")
k_s = Equation("k_s", A_F / A_z, "N/mm", "(4)", "equivalent stiffness")
c_s = Equation("c_s", A_F / (omega * A_z), "N*s/mm", "(5)", "equivalent damping as printed: holds no loss")
phase_0 = Equation("phase_0", j, text="e^(jθ) where z = 0 is shown: θ = π/2, less what the force is late")
cos_0 = Equation("cos_0", re(phase_0), text="cos θ there")
sin_0 = Equation("sin_0", im(phase_0), text="sin θ there")
direction_0 = Equation("direction_0", sign(sin_0), text="direction of the displacement there")
F_mid = Equation("F_mid", force(cos_0, sin_0, direction_0), "N", "(12)", "force on the sample there")
h_s = Equation("h_s", F_mid, "N", "(6)", "half the width of the loop, at z = 0")
energy_per_cycle = Equation(
    "energy_per_cycle", pi * K_im * A_z**2 + 4 * h_D * (A_z - r_m / rho), "N*mm", text="lost in the sample"
)
cycle: dict[str, Any] = {
    "omega": omega, "amplitude": A_z, "h": h_D, "rho": rho, "theta": theta_pk, "cos_0": cos_0, "sin_0": sin_0,
    "direction_0": direction_0, "F_mid": F_mid, "energy": energy_per_cycle,
}  # fmt: skip
shown: dict[str, Any] = {"omega": omega, "phase_0": phase_0, "h_s": h_s}
# h_s can exceed A_F by rounding alone, where nothing but loss is left
loss_angle = Equation("loss_angle", asin(Min(h_s / A_F, 1)) * 180 / pi, "deg", text="asin(h_s/A_F)")

complex_stiffness = Model(
    "complex_stiffness",
    inputs=(f,),
    parameters=(k_D, c_D, h_D, rho, A_z),
    statements=(
        omega, K, K_re, K_im, r_m, theta_pk, F_pk, A_F, k_s, c_s, phase_0, cos_0, sin_0, direction_0, F_mid,
        h_s, energy_per_cycle, loss_angle,
    ),
    outputs=(Output("k_s"), Output("loss_angle")),
    ports=(
        Port("mechanical", "stiffness", "K", (("omega", omega.symbol), ("amplitude", A_z.symbol))),
        Port("mechanical", "cycle", "F_pk", tuple((n, q.symbol) for n, q in cycle.items())),
        Port("sensor", "shown_cycle", "A_F", tuple((n, q.symbol) for n, q in shown.items())),
    ),
    drops=(("b", 1.0), ("r_0", None), ("F_0", None)),
    source="MRE paper, eq. 4–12, Table 3",
    text="stiffness and loss angle of the modified Dahl model in a steady cycle",
    checked=True,
)  # fmt: skip
