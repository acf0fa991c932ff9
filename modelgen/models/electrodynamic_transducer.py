"""Moving-coil transducer (Thiele–Small): the GMM paper's two-port, eq. 2–4, with a coil in a magnet's gap."""

from modelgen.language import Equation, Input, Model, Output, Parameter, Port, j, pi

TEXTBOOK = "L. L. Beranek, Acoustics, ch. 3; R. H. Small, JAES 20 (1972) 383"

f = Input("f", "Hz", "frequency", range=(10.0, 2e4))

R_e = Parameter("R_e", "ohm", 6.0, (1e-3, 1e4), "resistance of the coil", TEXTBOOK)
L_e = Parameter("L_e", "H", 5e-4, (1e-9, 10.0), "inductance of the blocked coil", TEXTBOOK)
Bl = Parameter("Bl", "N/A", 6.0, (1e-4, 1e4), "force factor", TEXTBOOK)
M_m = Parameter("M_m", "kg", 0.015, (1e-9, 1e3), "moving mass", TEXTBOOK)
K_m = Parameter("K_m", "N/m", 2e3, (1e-3, 1e10), "stiffness of the suspension", TEXTBOOK)
R_m = Parameter("R_m", "N*s/m", 1.0, (0.0, 1e6), "mechanical resistance", TEXTBOOK)

omega = Equation("omega", 2 * pi * f, "rad/s", text="angular frequency")
L_E = Equation("L_E", L_e, "H", text="inductance of the blocked coil, complex where its core loses energy")
Z_e = Equation("Z_e", R_e + j * omega * L_E, "ohm", "(8)", "blocked electrical impedance")
K_M = Equation("K_M", K_m, "N/m", text="stiffness of the suspension, complex where it loses energy")
Z_m = Equation("Z_m", R_m + j * omega * M_m + K_M / (j * omega), "N*s/m", "(9)", "mechanical impedance")
T_em = Equation("T_em", Bl, "N/A", "(4)", "force factor, complex where currents screen its flux")
Z = Equation("Z", Z_e + T_em**2 / Z_m, "ohm", "(4)", "electrical impedance, with T_me = −T_em")

at = (("omega", omega.symbol),)
wound = (*at, ("R", R_e))
electrodynamic_transducer = Model(
    "electrodynamic_transducer",
    inputs=(f,),
    parameters=(R_e, L_e, Bl, M_m, K_m, R_m),
    statements=(omega, L_E, Z_e, K_M, Z_m, T_em, Z),
    outputs=(Output("Z"),),
    ports=(
        Port("electrical", "electrical_impedance", "Z_e", wound),
        Port("electrical", "inductance", "L_E", at),
        Port("electrical", "terminals", "Z", wound),
        Port("mechanical", "mechanical_impedance", "Z_m", at),
        Port("mechanical", "stiffness", "K_M", at),
        Port("transduction", "transduction", "T_em", at),
    ),
    source=TEXTBOOK,
    text="moving-coil transducer, electrical impedance",
    checked=True,
)
