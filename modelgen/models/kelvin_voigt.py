"""Kelvin–Voigt model: a spring and a dashpot side by side, the modified Dahl model (7) without friction."""

from modelgen.language import Equation
from modelgen.models.sample import F_0, c_D, k_D, k_f, sample_model, v_D, z_D

SOURCE = "W. Voigt, Ann. Phys. 283 (1892) 671; MRE paper, sec. 4 and eq. 7 with h_D = 0"

F_r = Equation("F_r", c_D * v_D + k_f * z_D + F_0, "N", "(7)", "force of the sample")

kelvin_voigt = sample_model(
    "kelvin_voigt",
    (k_D, c_D, F_0),
    (k_f, F_r),
    source=SOURCE,
    text="spring and dashpot, force from displacement",
)
