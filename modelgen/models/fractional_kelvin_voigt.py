"""Fractional Kelvin–Voigt model: a spring beside a springpot, F = k_D z + C D^α z + F_0, 0 < α < 1.

α = 0 is a spring, 1 a dashpot. The springpot is a ladder of Maxwell arms at fixed rates (trapezoidal rule
over its relaxations in ln s, as `power_law_viscoelasticity`), here closer: 5e-4 from 1.2e-3 to 2e4 rad/s.
C is the modulus at ω = 1 rad/s, so C D^α has the unit of a stiffness. What the sample had been through before
a record is held at rest unless the case gives bounds for `springpot_p0` …; the diagnosis frees them where
that explains far more.
"""

from dataclasses import replace
from math import inf

from modelgen.effects.effect import unit_omega
from modelgen.effects.ladder import Ladder
from modelgen.language import Equation, Parameter
from modelgen.models.sample import F_0, k_D, k_f, sample_model, z_D

SOURCE = (
    "M. Caputo, F. Mainardi, Riv. Nuovo Cimento 1 (1971) 161; F. Mainardi, Fractional Calculus (2010), ch. 3"
)

C = Parameter("C", "N/mm", 0.2, (0.0, inf), "modulus of the springpot at ω = 1 rad/s", SOURCE)
alpha = Parameter("alpha", "1", 0.16, (0.01, 0.99), "its order: 0 for a spring, 1 for a dashpot", SOURCE)

F_r = Equation("F_r", k_f * z_D + F_0, "N", "(7)", "force of spring and offset")
spring = sample_model("fractional_kelvin_voigt", (k_D, C, alpha, F_0), (k_f, F_r), source=SOURCE)
force = next(p for p in spring.ports if p.kind == "force")
DECADES = 9
"""Places along the ladder at which the past of a sample can be given: one in each decade of its rates."""
where = "foot of the arms in decade {} of rates before the record, beyond z_rest"
feet = tuple(
    Parameter(f"springpot_p{k}", "mm", 0.0, (-inf, inf), where.format(k), SOURCE, known=True)
    for k in range(DECADES)
)
arms = Ladder("springpot", unit_omega(spring), force, count=18, step=1.2, feet=feet)

whole = arms.add(C * arms.power_law(alpha), "force of the springpot")
fractional_kelvin_voigt = replace(
    whole.with_parameters(
        *(replace(whole.parameter(n), source=SOURCE) for n in ("unit_omega", "springpot_s_0", "z_rest"))
    ),
    text="spring and springpot, force from displacement",
)
