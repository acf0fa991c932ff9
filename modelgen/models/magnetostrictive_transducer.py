"""Longitudinal transducer with a rod of giant magnetostrictive material (GMM paper, eq. 1–13).

Time convention e^{+jωt}: a lossy material has negative imaginary parts. Corrected: the last coefficient in
(5), the sign of χ_i in (6), and K_G* in (9), printed with 1/K in place of K and 1/S'' in place of −S''/|S|².
Passive at all frequencies if, besides Im μ, Im S <= 0, Im(d)² <= μ_0 Im μ Im S.
"""

from dataclasses import replace

from sympy import Integer

from modelgen.language import (
    Abs,
    Condition,
    Equation,
    Input,
    Model,
    Output,
    Parameter,
    Port,
    arg,
    check_option,
    complex_parameter,
    eddy_factor,
    im,
    j,
    pi,
    re,
)
from modelgen.language.meant import meant

ROD = "GMM paper, sec. 2.2"
TABLE_7 = "GMM paper, Table 7"
ASSUMED = "assumed, not in the paper: resonance near its 1600 Hz"

f = Input("f", "Hz", "frequency", range=(100.0, 1e4))

# Any material of this kind; the paper searches μ' 2 to 3, S' 1e-12 to 1e-10, d' 5e-10 to 5e-9 (Table 7).
mu33 = complex_parameter(
    "mu33", "1", 2.814 - 0.137j, (1, 30), (-5, 5), "relative permeability μ_33^σ* (1)", TABLE_7
)
S33 = complex_parameter(
    "S33", "m²/N", 2.547e-11 - 2.178e-13j, (1e-12, 1e-9), (-2e-11, 2e-11), "compliance S_33^H* (1)", TABLE_7
)
d33 = complex_parameter(
    "d33", "m/A", 1.587e-9 - 5.588e-11j, (1e-10, 1e-7), (-1e-8, 1e-8), "constant d_33* (1)", TABLE_7
)
R_0 = Parameter("R_0", "ohm", 3.0, (1e-3, 1e3), "dc resistance of the solenoid", ASSUMED)
M_t = Parameter("M_t", "kg", 1.2501374, (1e-3, 1e3), "equivalent mass of the transducer", ASSUMED)
K_spr = Parameter("K_spr", "N/m", 3e6, (1e3, 1e10), "stiffness of the spring washers, K_mps in (13)", ASSUMED)
R_d = Parameter("R_d", "N*s/m", 6.79, (0.0, 1e4), "structural damping of the plunger", "GMM paper, sec. 3.1")
R_f = Parameter("R_f", "N*s/m", 349.2303, (0.0, 1e4), "damping of the contact surfaces", "GMM paper, Table 3")
N = Parameter("N", "1", 940.0, (1.0, 1e6), "turns of the ac solenoid", ROD, known=True)
A = Parameter("A", "m²", 3.141592653589793e-4, (1e-8, 1.0), "cross-section of the rod", ROD, known=True)
l = Parameter("l", "m", 0.1, (1e-4, 10.0), "length of the rod", ROD, known=True)
f_c = Parameter("f_c", "Hz", 3e4, (1.0, 1e9), "eddy-current cut-off of the slotted rod", ROD, known=True)
k_M2 = Parameter("k_M2", "1", 0.9205, (0.0, 1.0), "k_M², leakage of flux", "GMM paper, eq. 13", known=True)
mu_0 = Parameter("mu_0", "H/m", 1.2566370614359173e-6, (1.25e-6, 1.26e-6), "4π·1e-7 H/m", "SI", known=True)

p = f / f_c
EDDY = {
    "exact": eddy_factor(p),
    "series": 1 - p**2 / 48 + 19 * p**4 / 30720 - j * (p / 8 - 11 * p**3 / 3072 + 473 * p**5 / 4423680),
    "none": Integer(1),
}

omega = Equation("omega", 2 * pi * f, "rad/s", text="angular frequency")
chi = Equation("chi", EDDY["exact"], "1", "(5)", "eddy-current factor χ_r − jχ_i")
chi_r = Equation("chi_r", re(chi), "1", "(5)", "its real part")
chi_i = Equation("chi_i", -im(chi), "1", "(5)", "its loss")
mus = Equation("mus", mu_0 * (mu33.re * chi + j * mu33.im), "H/m", "(6)", "permeability with eddy currents")
k33_2 = Equation("k33_2", d33**2 / (mus * S33), "1", "(7)", "magneto-mechanical coupling, squared")
L_b = Equation("L_b", (1 - k33_2) * mu_0 * mu33.re * N**2 * A / l, "H", "(8)", "inductance when blocked")
R_g1 = Equation("R_g1", omega * (chi_i - mu33.im / mu33.re) * L_b, "ohm", "(8)", "hysteresis, eddy currents")
L_g = Equation("L_g", chi_r * L_b, "H", "(8)", "inductance with eddy currents")
# (R_g1 + jωL_g)/(jω) written without the parts of χ, so that Z is holomorphic in the complex constants
L_G = Equation("L_G", (chi + j * mu33.im / mu33.re) * L_b, "H", "(8)", "inductance L_G* = L_g + R_g1/(jω)")
Z_e = Equation("Z_e", R_0 + j * omega * L_G, "ohm", "(8)", "blocked electrical impedance")
K_G = Equation("K_G", A / (l * S33), "N/m", "(9)", "complex stiffness K_G* = K_g + jωR_g2 of the rod")
K_g = Equation("K_g", re(K_G), "N/m", "(9)", "its stiffness, A S'/(l|S|²)")
R_g2 = Equation("R_g2", im(K_G) / omega, "N*s/m", "(9)", "its elastic loss, −A S''/(ωl|S|²)")
Z_t = Equation(
    "Z_t", j * omega * M_t + (K_spr + K_G) / (j * omega) + R_d + R_f, "N*s/m", "(9)", "mechanical impedance"
)
T_em = Equation("T_em", N * A * d33 / (S33 * l), "N/A", "(10)", "transduction coefficient, T_em = −T_me")
Z = Equation("Z", Z_e + T_em**2 / Z_t, "ohm", "(4), (11)", "electrical impedance")
abs_Z = Equation("abs_Z", Abs(Z), "ohm", text="modulus of the electrical impedance")
phase = Equation("phase", arg(Z) * 180 / pi, "deg", "(12)", "phase of the electrical impedance")
k_eff2 = Equation(
    "k_eff2", k_M2 * k33_2 * K_G / (K_G + K_spr * (1 - k33_2)), "1", "(13)", "effective coupling, squared"
)

# The power that the material takes up, −ω/2 (Im μ |H|² + 2 Im d Re(σH̄) + Im S |σ|²), is none below 0
PASSIVE = (
    Condition("the permeability is lossy", -mu33.im, "(1)"),
    Condition("the compliance is lossy", -S33.im, "(1)"),
    Condition("no power comes from the coupling", mu_0 * mu33.im * S33.im - d33.im**2, "(1)"),
)


def build(eddy: str = "exact", eddy_sign: str = "corrected") -> Model:
    """The transducer with χ by Bessel functions ("exact"), by the series (f < f_c), or χ = 1 ("none").

    eddy_sign="printed" has +jχ_i in (6): eddy currents then generate power. InputError on another value.
    """
    check_option("eddy", eddy, EDDY)
    check_option("eddy_sign", eddy_sign, ("corrected", "printed"))
    factor = EDDY[eddy] if eddy_sign == "corrected" else re(EDDY[eddy]) - j * im(EDDY[eddy])
    at = (("omega", omega.symbol),)
    wound = (*at, ("R", R_0))
    made = Model(
        "magnetostrictive_transducer",
        inputs=(f,),
        parameters=(mu33, S33, d33, R_0, M_t, K_spr, R_d, R_f, N, A, l, f_c, k_M2, mu_0),
        statements=(
            omega, replace(chi, expr=factor), chi_r, chi_i, mus, k33_2, L_b, R_g1, L_g, L_G, Z_e,
            K_G, K_g, R_g2, Z_t, T_em, Z, abs_Z, phase, k_eff2,
        ),
        outputs=(Output("Z"), Output("abs_Z"), Output("phase"), Output("k_eff2")),
        ports=(
            Port("electrical", "electrical_impedance", "Z_e", wound),
            Port("electrical", "inductance", "L_G", at),
            Port("electrical", "terminals", "Z", wound),
            Port("mechanical", "mechanical_impedance", "Z_t", at),
            Port("mechanical", "stiffness", "K_G", (*at, ("l", l))),
        ),
        source="GMM paper, eq. 1–13",
        text="transducer with a giant magnetostrictive rod, electrical impedance",
        options=(("eddy", eddy), ("eddy_sign", eddy_sign)),
        conditions=PASSIVE,
        builder=build,
        checked=True,
    )  # fmt: skip
    return replace(made, **meant(made))  # χ = 1 is real, as those that hold it do not know yet


magnetostrictive_transducer = build()
