"""Currents and delays in the core: solid iron, shorted turns, magnetic after-effect."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from modelgen.effects.effect import AROUND, RARER, Effect, Shape, Strength, Values, add, change, unit_omega
from modelgen.language import Model, Parameter, Port, eddy_factor, exp, j, powj


def _semi_inductance(model: Model, port: Port, p: Mapping[str, Parameter]) -> Model:
    model = unit_omega(model)
    w = port["omega"] / model.parameter("unit_omega")
    return model.extend(port.equation, lambda Z: Z + p["K"] * powj(w, p["n"]))


semi_inductance = Effect(
    "semi_inductance",
    ("electrical_impedance",),
    "eddy currents in solid iron let flux in only through a skin: an impedance K(jω)^n, with n near one half",
    "J. Vanderkooy, JAES 37 (1989) 119; J. R. Wright, JAES 38 (1990) 749",
    (Strength("K", "{port}", text="modulus at ω = 1 rad/s"),),
    _semi_inductance,
    (Shape("n", "1", "1", 0.3, 0.95, 6, log=False, text="exponent; 1/2 for an ideal half-space of iron"),),
    needs=("omega",),
    common=2.0,
)

solid_pole = Effect(
    "semi_inductance",
    ("electrical_impedance",),
    "flux enters a solid pole only through its skin: a part L_3 of the inductance falls with the root of "
    "frequency above ω_3",
    "R. L. Stoll, The Analysis of Eddy Currents (1974), ch. 3: solid cylinder, 2 J1(x)/(x J0(x))",
    (Strength("L_3", "{port}*s", text="inductance by the flux in the pole, at low frequency"),),
    change(lambda Z, at, p: Z + j * at["omega"] * p["L_3"] * eddy_factor(at["omega"] / p["omega_3"])),
    (Shape("omega_3", "rad/s", "omega", 0.01, 1.0, 8, text="where the skin is √2 times the pole's radius"),),
    needs=("omega",),
)

solid_core = Effect(
    "semi_inductance",
    ("inductance",),
    "flux enters a solid core only through its skin: a share of the inductance at low frequency falls "
    "with the root of frequency above ω_c",
    solid_pole.source,
    (Strength("share", "1", bounds=(0.0, 1.0), text="share of the inductance by the flux in the core"),),
    change(lambda L, at, p: L * (1 - p["share"] * (1 - eddy_factor(at["omega"] / p["omega_c"])))),
    (replace(solid_pole.shapes[0], name="omega_c"),),
    needs=("omega",),
    common=RARER,
)


def _plate(at: Port, p: Values) -> Any:
    """jω L_p tanh(s)/s with s = √(jω/ω_p)."""
    s = powj(at["omega"] / p["omega_p"], 0.5)
    faded = exp(-2 * s)
    return j * at["omega"] * p["L_p"] * (1 - faded) / ((1 + faded) * s)


solid_plate = Effect(
    "semi_inductance",
    ("electrical_impedance",),
    "flux enters a solid plate only through its skin: a part L_p of the inductance falls with the root of "
    "frequency above ω_p, L_p tanh(s)/s with s = √(jω/ω_p)",
    "R. L. Stoll, The Analysis of Eddy Currents (1974), ch. 2: plate; J. Vanderkooy, JAES 37 (1989) 119",
    (Strength("L_p", "{port}*s", text="inductance by the flux in the plate, at low frequency"),),
    add(_plate),
    (replace(solid_pole.shapes[0], name="omega_p", text="where the skin is √2 times half the plate"),),
    needs=("omega",),
    common=RARER,
)


def _beside_skin(model: Model, port: Port, p: Values) -> Model:
    model = unit_omega(model)
    unit = model.parameter("unit_omega")
    Y, a = p["Y"] * unit, 1 - p["n_p"]
    return model.extend(port.equation, lambda L: L / (1 + L * Y * powj(port["omega"] / unit, a)))


parallel_semi_inductance = Effect(
    "semi_inductance",
    ("inductance",),
    "eddy currents in solid iron let flux in only through a skin: K(jω)^n in parallel with the inductance",
    "W. M. Leach, JAES 50 (2002) 442; K. Thorborg, C. Futtrup, JAES 59 (2011) 612",
    (Strength("Y", "s/{port}", text="1/K, K the modulus at ω = 1 rad/s"),),
    _beside_skin,
    (Shape("n_p", "1", "1", 0.3, 0.85, 4, log=False, text="exponent; 1/2 for an ideal half-space of iron"),),
    needs=("omega",),
    acts=AROUND,
)

shunted_inductance = Effect(
    "eddy_shunt",
    ("inductance",),
    "eddy currents act as a resistance that shunts the whole inductance, R‖L",
    "E. C. Snelling, Soft Ferrites (1988), ch. 2",
    (Strength("G", "s/{port}", text="1/R of the resistance that shunts the inductance"),),
    change(lambda L, at, p: L / (1 + j * at["omega"] * p["G"] * L)),
    needs=("omega",),
    acts=AROUND,
)

shorted_turn = Effect(
    "eddy_shunt",
    ("electrical_impedance",),
    "a shorted turn, or the pole piece acting as one, shunts a part L_2 of the inductance by a "
    "resistance ω_2 L_2",
    "LR-2 model: M. Dodd, W. Klippel, J. Oclee-Brown, AES Convention 117 (2004) 6261",
    (Strength("L_2", "{port}*s", text="inductance that is shunted"),),
    change(lambda Z, at, p: Z + j * at["omega"] * p["L_2"] / (1 + j * at["omega"] / p["omega_2"])),
    (Shape("omega_2", "rad/s", "omega", 0.3, 3.0, text="R_2/L_2, above which the resistance is left"),),
    needs=("omega",),
    alike=("permeability_relaxation",),  # a part of it that follows late with one time
)

shorted_share = Effect(
    "eddy_shunt",
    ("inductance",),
    "a shorted turn, or the pole piece acting as one, shunts a share of the inductance that there is at low "
    "frequency",
    shorted_turn.source,
    (Strength("share", "1", bounds=(0.0, 1.0), text="share of the inductance that is shunted"),),
    change(lambda L, at, p: L * (1 - p["share"] * j * at["omega"] / (p["omega_s"] + j * at["omega"]))),
    (replace(shorted_turn.shapes[0], name="omega_s"),),
    needs=("omega",),
    common=RARER,
    alike=("permeability_relaxation",),
)

two_turns = Effect(
    "eddy_shunt",
    ("electrical_impedance",),
    "two shorted turns, or a pole piece and a ring, shunt parts of the inductance, each by a resistance",
    "LR-2 model: M. Dodd, W. Klippel, J. Oclee-Brown, AES Convention 117 (2004) 6261; with one section more",
    (
        Strength("L_4", "{port}*s", text="inductance that is shunted first"),
        Strength("L_5", "{port}*s", text="inductance that is shunted at higher frequencies"),
    ),
    change(
        lambda Z, at, p: (
            Z
            + j * at["omega"] * p["L_4"] / (1 + j * at["omega"] / p["omega_4"])
            + j * at["omega"] * p["L_5"] / (1 + j * at["omega"] / (p["ratio"] * p["omega_4"]))
        )
    ),
    (
        Shape("omega_4", "rad/s", "omega", 0.3, 1.0, 6, text="R/L, above which a resistance is left"),
        Shape("ratio", "1", "1", 2.0, 50.0, 3, text="how much later the other does so"),
    ),
    needs=("omega",),
)


def shunted(Z: Any, at: Port, p: Values) -> Any:
    """An impedance with a conductance `G_0` across it, behind the resistance of its leads or its winding."""
    R = dict(at.variables).get("R", 0)
    return R + (Z - R) / (1 + p["G_0"] * (Z - R))


shunted_terminals = Effect(
    "eddy_shunt",
    ("terminals",),
    "a resistance shunts the whole coil behind the resistance of its wire, motion included: eddy currents "
    "that all of its flux drives",
    "E. C. Snelling, Soft Ferrites (1988), ch. 2: core loss as a parallel resistance",
    (Strength("G_0", "1/{port}", text="conductance across the coil"),),
    change(shunted),
    needs=("omega",),
    unless=("capacitance",),  # no coil
    without=("F",),
)

permeability_relaxation = Effect(
    "permeability_relaxation",
    ("inductance",),
    "a part of the inductance follows the field late, with times spread around τ (Cole–Cole): magnetic "
    "after-effect, or eddy currents deep in iron",
    "K. S. Cole, R. H. Cole, J. Chem. Phys. 9 (1941) 341; S. Chikazumi, Physics of Ferromagnetism "
    "(1997), ch. 20",
    (Strength("L_s", "{port}", text="inductance by the relaxing part of the permeability"),),
    add(lambda at, p: p["L_s"] / (1 + powj(at["omega"] * p["tau"], p["a"]))),
    (
        Shape("tau", "s", "time", 0.3, 3.0, text="relaxation time"),
        Shape("a", "1", "1", 0.2, 0.95, 3, log=False, text="1 for one time, less the wider the times spread"),
    ),
    needs=("omega",),
)

EFFECTS = (
    semi_inductance,
    solid_pole,
    solid_core,
    solid_plate,
    parallel_semi_inductance,
    shunted_inductance,
    shorted_turn,
    shorted_share,
    two_turns,
    shunted_terminals,
    permeability_relaxation,
)
