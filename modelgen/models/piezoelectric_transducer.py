"""Piezoelectric transducer at one of its resonances (Van Dyke's circuit), with its mechanical side in
mechanical units."""

from modelgen.language import Equation, Input, Model, Output, Parameter, Port, j, pi

MASON = "W. P. Mason, Electromechanical Transducers and Wave Filters (1948), ch. 6"
VAN_DYKE = "K. S. Van Dyke, Proc. IRE 16 (1928) 742; IEEE Std 176-1987"

f = Input("f", "Hz", "frequency", range=(1e3, 1e6))

C_0 = Parameter("C_0", "F", 1e-9, (1e-15, 1e-3), "capacitance of the clamped element", VAN_DYKE)
phi = Parameter("phi", "N/V", 0.1, (1e-6, 1e3), "force factor, force of the clamped element per volt", MASON)
M_m = Parameter("M_m", "kg", 1e-3, (1e-12, 1e3), "moving mass", MASON)
K_m = Parameter("K_m", "N/m", 4e8, (1e-3, 1e14), "stiffness of the shorted element", MASON)
R_m = Parameter("R_m", "N*s/m", 10.0, (0.0, 1e8), "mechanical resistance", MASON)

omega = Equation("omega", 2 * pi * f, "rad/s", text="angular frequency")
C_E = Equation("C_E", C_0, "F", text="capacitance, complex where the dielectric loses energy")
K_M = Equation("K_M", K_m, "N/m", text="stiffness, complex where it loses energy")
Z_m = Equation("Z_m", R_m + j * omega * M_m + K_M / (j * omega), "N*s/m", text="mechanical impedance")
Phi = Equation("Phi", phi, "N/V", text="force factor, complex where the transduction loses energy")
Y = Equation("Y", j * omega * C_E + Phi**2 / Z_m, "1/ohm", text="admittance, Phi by Phi N/V and A/(m/s)")
Z = Equation("Z", 1 / Y, "ohm", text="electrical impedance")

at = (("omega", omega.symbol),)
piezoelectric_transducer = Model(
    "piezoelectric_transducer",
    inputs=(f,),
    parameters=(C_0, phi, M_m, K_m, R_m),
    statements=(omega, C_E, K_M, Z_m, Phi, Y, Z),
    outputs=(Output("Z"),),
    ports=(
        Port("electrical", "capacitance", "C_E", at),
        Port("electrical", "terminals", "Z", at),
        Port("mechanical", "mechanical_impedance", "Z_m", at),
        Port("mechanical", "stiffness", "K_M", at),
        Port("transduction", "transduction", "Phi", at),
    ),
    source=VAN_DYKE,
    text="piezoelectric transducer at one resonance, electrical impedance",
    checked=True,
)
