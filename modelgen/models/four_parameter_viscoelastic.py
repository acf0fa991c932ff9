"""Four-parameter viscoelastic model: spring, dashpot and a Maxwell arm side by side.

Of the arrangements with four constants this is one in which all four can be found: a spring beside a
three-parameter solid (spring in series with Kelvin–Voigt) has the response of a solid with three constants.
The arm's dashpot follows its exact solution for a displacement that is linear between samples.
"""

from math import inf

from sympy import Symbol

from modelgen.language import Equation, Parameter, State, expm1
from modelgen.models.sample import F_0, c_D, k_D, k_f, sample_model, t, t_prev, v_D, z_D, z_D_prev

SOURCE = (
    "W. N. Findley, J. S. Lai, K. Onaran, Creep and Relaxation of Nonlinear Viscoelastic Materials, ch. 5"
)
TINY = 1e-30  # keeps (1 − e^(−x))/x finite at the first sample, where no time has passed

k_M = Parameter("k_M", "N/mm", 0.1, (0.0, inf), "stiffness of the Maxwell arm", SOURCE)
tau_M = Parameter("tau_M", "s", 0.1, (1e-6, 1e6), "its relaxation time, damping over stiffness", SOURCE)
z_rest = Parameter(
    "z_rest", "mm", 0.0, (-inf, inf), "where the arm rested before the record", SOURCE, known=True
)

x = Equation("x", (t - t_prev) / tau_M, "1", text="time step over relaxation time")
foot = Symbol("z_M", real=True)
faded = -expm1(-x)
kept = (z_D_prev - foot) * (1 - faded)
new = (z_D - z_D_prev) * faded / (x + TINY)
z_M = State("z_M", z_rest, z_D - kept - new, unit="mm", text="foot of the arm's spring, moved by its dashpot")
F_M = Equation("F_M", k_M * (z_D - z_M), "N", text="force of the Maxwell arm")
F_r = Equation("F_r", F_M + c_D * v_D + k_f * z_D + F_0, "N", "(7)", "force of the sample")

four_parameter_viscoelastic = sample_model(
    "four_parameter_viscoelastic",
    (k_D, c_D, k_M, tau_M, F_0, z_rest),
    (x, z_M, k_f, F_M, F_r),
    source=SOURCE,
    text="spring, dashpot and a Maxwell arm, force from displacement",
)
