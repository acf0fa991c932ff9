"""Capacitances as they are: dielectrics that lose energy, relax and conduct."""

from modelgen.effects.eddy import shunted
from modelgen.effects.effect import Effect, Shape, Strength, Values, add, change, unit_omega
from modelgen.language import Model, Port, j, powj

BOUNDED = (0.0, 1.0)


def _constant_angle(model: Model, port: Port, p: Values) -> Model:
    model = unit_omega(model)
    w = port["omega"] / model.parameter("unit_omega")
    return change(lambda C, at, p: C * powj(w, -p["n"]))(model, port, p)


dielectric_loss = Effect(
    "dielectric_loss",
    ("capacitance",),
    "the dielectric loses the same share of its energy at every frequency, and its permittivity falls by a "
    "power law: C (jω)^−n, of loss tangent tan(nπ/2); of an electrode, a constant-phase element",
    "A. K. Jonscher, Nature 267 (1977) 673; K. S. Cole, R. H. Cole, J. Chem. Phys. 9 (1941) 341",
    (Strength("n", "1", bounds=BOUNDED, text="2/π of the loss angle; C is that at ω = 1 rad/s"),),
    _constant_angle,
    needs=("omega",),
    family="dielectric",
    common=2.0,
)

complex_permittivity = Effect(
    "dielectric_loss",
    ("capacitance",),
    "the dielectric loses the same share of its energy at every frequency: a complex permittivity, "
    "ε(1 − j tan δ)",
    "IEEE Std 176-1987, sec. 6.4; R. Holland, IEEE Trans. Sonics Ultrason. 14 (1967) 18",
    (Strength("tan_delta", "1", bounds=BOUNDED, text="tangent of the loss angle"),),
    change(lambda C, at, p: C * (1 - j * p["tan_delta"])),
    needs=("omega",),
    family="dielectric",
    common=2.0,
)

dielectric_relaxation = Effect(
    "dielectric_relaxation",
    ("capacitance",),
    "a part of the polarisation follows the field late, with times spread around τ (Cole–Cole)",
    "P. Debye, Polar Molecules (1929); K. S. Cole, R. H. Cole, J. Chem. Phys. 9 (1941) 341",
    (Strength("C_s", "{port}", text="capacitance by the relaxing part of the permittivity"),),
    add(lambda at, p: p["C_s"] / (1 + powj(at["omega"] * p["tau"], p["a"]))),
    (
        Shape("tau", "s", "time", 0.3, 3.0, text="relaxation time"),
        Shape("a", "1", "1", 0.4, 1.0, 3, log=False, text="1 for one time, less the wider the times spread"),
    ),
    needs=("omega",),
    family="dielectric",
)

leakage_conductance = Effect(
    "leakage_conductance",
    ("capacitance",),
    "the dielectric conducts, or its surface does: a resistance lies across the capacitance",
    "Keysight Impedance Measurement Handbook, ch. 1: capacitor with leakage resistance",
    (Strength("G", "{port}/s", text="conductance across the capacitance"),),
    add(lambda at, p: p["G"] / (j * at["omega"])),
    needs=("omega",),
)


leaking_terminals = Effect(
    "leakage_conductance",
    ("terminals",),
    "a resistance lies across the device, behind that of its leads: a dielectric or a surface that conducts",
    leakage_conductance.source,
    (Strength("G_0", "1/{port}", text="conductance across the device"),),
    change(shunted),
    needs=("omega",),
    unless=("capacitance",),
    amid=("F",),
    alike=("eddy_shunt",),
)

EFFECTS = (
    dielectric_loss,
    complex_permittivity,
    dielectric_relaxation,
    leakage_conductance,
    leaking_terminals,
)
