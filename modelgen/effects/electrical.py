"""Coils as they are: wires with resistance, stray flux, capacitance between turns, imperfect insulation."""

from dataclasses import replace
from typing import Any

from modelgen.effects.effect import RARER, Effect, Shape, Strength, Values, add, change, unit_omega
from modelgen.effects.rod import over, xcotx
from modelgen.language import Model, Port, eddy_factor, j, powj

lead_resistance = Effect(
    "lead_resistance",
    ("electrical_impedance", "terminals"),
    "leads and contacts add a constant resistance in series",
    "four-wire against two-wire measurement, e.g. Keysight Impedance Measurement Handbook, ch. 3",
    (Strength("R", "{port}", text="series resistance of leads and contacts"),),
    add(lambda at, p: p["R"]),
    needs=("omega",),
)

leakage_inductance = Effect(
    "leakage_inductance",
    ("electrical_impedance", "terminals"),
    "flux that misses the core, or that of the leads, stores energy: an inductance in series",
    "E. C. Snelling, Soft Ferrites (1988), ch. 11",
    (Strength("L", "{port}*s", text="leakage inductance"),),
    add(lambda at, p: j * at["omega"] * p["L"]),
    needs=("omega",),
)

cell_inductance = replace(
    leakage_inductance,
    kinds=("terminals",),
    also=("capacitance", "electrical_impedance"),  # which a capacitance shunts, as in an electrode's circuit
    common=2.0,  # hardly a spectrum of a cell ends without
)

coil_ac_resistance = Effect(
    "coil_ac_resistance",
    ("electrical_impedance",),
    "skin and proximity effect crowd the current in the wire: its resistance grows with the square of "
    "frequency, "
    "above omega_s with the root",
    "H. B. Dwight, Electrical Coils and Conductors (1945), ch. 16: round wire, R x J0(x)/(2 J1(x))",
    (
        Strength(
            "R",
            "{port}",
            text="dc resistance of the wire that takes part, more where turns lie in others' field",
        ),
    ),
    # 1/χ of the same function that describes flux in a rod is the internal impedance of a round wire over
    # its R
    add(lambda at, p: p["R"] * (1 / eddy_factor(at["omega"] / p["omega_s"]) - 1)),
    (
        Shape(
            "omega_s",
            "rad/s",
            "omega",
            0.03,
            1.0,
            9,
            text="1/(μσa²): frequency at which the skin is √2 times as deep as the wire's radius a",
        ),
    ),
    needs=("omega",),
)


SKIN = Strength(
    "tau_s", "s", text="μσa², above whose inverse the skin is thinner than the wire's radius a",
    scale="1/max(omega)", low=0.5, high=100.0, points=8,
)  # fmt: skip

skin_effect = Effect(
    "coil_ac_resistance",
    ("electrical_impedance",),
    "skin effect crowds the current in the wire: all of its resistance grows with the square of frequency, "
    "above 1/τ_s with the root",
    "H. B. Dwight, Electrical Coils and Conductors (1945), ch. 16: round wire, R x J0(x)/(2 J1(x))",
    (SKIN,),
    add(lambda at, p: at["R"] * (1 / eddy_factor(at["omega"] * p["tau_s"]) - 1)),
    needs=("omega", "R"),
    secant=True,  # an inductance at first order
)


def _layered(at: Port, p: Values) -> Any:
    x2 = j * at["omega"] * p["tau_p"]
    own = xcotx(-x2) - 1  # x coth x − 1
    layers = over((p["m"] ** 2 - 1) / 3 * x2, xcotx(-x2 / 4))  # 2 (m² − 1)/3 x tanh(x/2)
    return at["R"] * (own + layers)


layered_winding = Effect(
    "coil_ac_resistance",
    ("electrical_impedance",),
    "current is crowded in a winding of several layers, each in the field of those within",
    "P. L. Dowell, Proc. IEE 113 (1966) 1387, eq. 10: x coth x + 2(m² − 1)/3 x tanh(x/2), x² = jωτ_p",
    (
        Strength(
            "tau_p", "s", text="μσh², above whose inverse the skin is thinner than a layer's height h",
            scale="1/max(omega)", low=0.01, high=30.0, points=8,
        ),
    ),
    add(_layered),
    (Shape("m", "1", "1", 1.0, 30.0, 4, text="layers"),),
    needs=("omega", "R"),
    secant=True,
)  # fmt: skip


def _growing(model: Model, port: Port, p: Values) -> Model:
    model = unit_omega(model)
    w = port["omega"] / model.parameter("unit_omega")
    return model.extend(port.equation, lambda Z: Z + p["K_r"] * w ** p["X_r"])


growing_resistance = Effect(
    "coil_ac_resistance",
    ("electrical_impedance",),
    "the coil's resistance grows with a power of frequency, and its inductance stays as it is",
    "J. R. Wright, JAES 38 (1990) 749: K_r ω^X_r, an empirical law of its own for the real part",
    (Strength("K_r", "{port}", text="resistance at ω = 1 rad/s"),),
    _growing,
    (Shape("X_r", "1", "1", 0.4, 2.5, 6, log=False, text="exponent; 1/2 where the skin is thin, 2 below"),),
    needs=("omega",),
    common=RARER,
)

setting_in = Effect(
    "coil_ac_resistance",
    ("electrical_impedance",),
    "the coil's resistance grows with the square of frequency and above omega_c with a lower power, and its "
    "inductance stays as it is",
    "usual fit of tabulated ac resistances, R_c ((1 + (ω/ω_c)²)^(X/2) − 1)",
    (Strength("R_c", "{port}", text="resistance at ω_c over 2^(X_c/2) − 1"),),
    add(lambda at, p: p["R_c"] * ((1 + (at["omega"] / p["omega_c"]) ** 2) ** (p["X_c"] / 2) - 1)),
    (
        Shape(
            "omega_c",
            "rad/s",
            "omega",
            0.1,
            1.0,
            6,
            text="corner, where the skin is about as deep as the wire",
        ),
        Shape("X_c", "1", "1", 0.4, 1.2, 2, log=False, text="exponent above; 1/2 for a thin skin"),
    ),
    needs=("omega",),
    common=RARER,
)

coil_capacitance = Effect(
    "coil_capacitance",
    ("terminals",),
    "capacitance between turns and in the cable lies across the terminals: the coil resonates with it "
    "and shorts above",
    "G. Grandi, M. K. Kazimierczuk, A. Massarini, U. Reggiani, IEEE Trans. Ind. Appl. 35 (1999) 1162",
    (Strength("C", "s/{port}", text="capacitance across the terminals"),),
    change(lambda Z, at, p: Z / (1 + j * at["omega"] * p["C"] * Z)),
    needs=("omega",),
    unless=("capacitance",),  # the same once more
)


def _lossy(at: Port, p: Values) -> Any:
    Y = j * at["omega"] * p["C_1"] * (1 - j * p["tan_delta"])
    return Y / (1 + Y * p["R_C"])


lossy_capacitance = Effect(
    "coil_capacitance",
    ("terminals",),
    "capacitance between turns and in the cable lies across the terminals, with a loss angle of its "
    "dielectric and a resistance on the way to it",
    "Keysight Impedance Measurement Handbook, ch. 1: capacitor with dielectric loss and series resistance",
    (Strength("C_1", "s/{port}", text="capacitance across the terminals"),),
    change(lambda Z, at, p: Z / (1 + Z * _lossy(at, p))),
    (
        Shape("tan_delta", "1", "1", 1e-3, 0.5, 3, text="tangent of the loss angle"),
        Shape("R_C", "{port}", "port", 1e-3, 1.0, 3, text="resistance in series"),
    ),
    needs=("omega",),
    unless=("capacitance",),
)


def _of_constant_angle(model: Model, port: Port, p: Values) -> Model:
    model = unit_omega(model)
    jw = j * port["omega"]
    C = p["C_n"] * powj(port["omega"] / model.parameter("unit_omega"), -p["n_C"])
    return change(lambda Z, at, p: Z / (1 + jw * C * Z))(model, port, p)


insulation_capacitance = replace(
    lossy_capacitance,
    says="capacitance between turns and in the cable lies across the terminals; its insulation loses the "
    "same share of energy at every frequency, C (jω)^−n, of loss tangent tan(nπ/2)",
    source="A. K. Jonscher, Nature 267 (1977) 673",
    strengths=(Strength("C_n", "s/{port}", text="capacitance at ω = 1 rad/s"),),
    apply=_of_constant_angle,
    shapes=(Shape("n_C", "1", "1", 1e-3, 0.3, 4, text="2/π of the loss angle"),),
)

EFFECTS = (
    lead_resistance,
    leakage_inductance,
    cell_inductance,
    coil_ac_resistance,
    skin_effect,
    layered_winding,
    growing_resistance,
    setting_in,
    coil_capacitance,
    lossy_capacitance,
    insulation_capacitance,
)
