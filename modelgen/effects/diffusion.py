"""Diffusion at an electrode: batteries, fuel cells, corrosion. Impedance of a cell: what moves has none."""

from dataclasses import replace

from modelgen.effects.effect import Effect, Shape, Strength, Values, add, unit_omega
from modelgen.language import Model, Port, exp, powj

MOVING = ("mechanical_impedance", "stiffness", "inductance")


def _warburg(model: Model, port: Port, p: Values) -> Model:
    model = unit_omega(model)
    w = port["omega"] / model.parameter("unit_omega")
    return add(lambda at, p: p["W"] / powj(w, 0.5))(model, port, p)


warburg_diffusion = Effect(
    "warburg_diffusion",
    ("electrical_impedance", "terminals"),
    "what reacts at the electrode arrives by diffusion: an impedance W/√(jω), which falls with the "
    "root of frequency at 45°",
    "E. Warburg, Ann. Phys. 303 (1899) 493",
    (Strength("W", "{port}", text="its modulus at ω = 1 rad/s"),),
    _warburg,
    needs=("omega",),
    unless=MOVING,
)


def _bounded(at: Port, p: Values) -> object:
    """R tanh(s)/s with s = √(jωτ)."""
    s = powj(at["omega"] * p["tau"], 0.5)
    faded = exp(-2 * s)
    return p["R_d"] * (1 - faded) / ((1 + faded) * s)


bounded_diffusion = Effect(
    "warburg_diffusion",
    ("electrical_impedance", "terminals"),
    "what reacts at the electrode arrives by diffusion through a layer that ends: R tanh(√(jωτ))/√(jωτ), "
    "a resistance at low frequency",
    "J. Llopis, F. Colom, Proc. 8th CITCE (1956) 414; A. Lasia, Electrochemical Impedance Spectroscopy"
    " (2014), ch. 4",
    (Strength("R_d", "{port}", text="resistance of the layer at low frequency"),),
    add(_bounded),
    (Shape("tau", "s", "time", 0.3, 30.0, text="time of diffusion through the layer"),),
    needs=("omega",),
    unless=MOVING,
)


def _blocked(at: Port, p: Values) -> object:
    """R coth(s)/s with s = √(jωτ)."""
    s = powj(at["omega"] * p["tau_b"], 0.5)
    faded = exp(-2 * s)
    return p["R_b"] * (1 + faded) / ((1 - faded) * s)


blocked_diffusion = replace(
    bounded_diffusion,
    says="what reacts diffuses in a layer that it can't leave, as lithium in an electrode: "
    "R coth(√(jωτ))/√(jωτ), a capacitance at low frequency",
    source="C. Ho, I. D. Raistrick, R. A. Huggins, J. Electrochem. Soc. 127 (1980) 343",
    strengths=(Strength("R_b", "{port}", text="three times the resistance of the layer"),),
    apply=add(_blocked),
    shapes=(replace(bounded_diffusion.shapes[0], name="tau_b"),),
)


def _in_spheres(at: Port, p: Values) -> object:
    """R tanh(s)/(s − tanh(s)) with s = √(jωτ)."""
    s = powj(at["omega"] * p["tau_r"], 0.5)
    faded = exp(-2 * s)
    T = (1 - faded) / (1 + faded)
    return p["R_r"] * T / (s - T)


diffusion_in_spheres = replace(
    blocked_diffusion,
    says="what reacts diffuses in grains that it can't leave: R tanh(s)/(s − tanh s), s = √(jωτ), "
    "a capacitance at low frequency",
    source="J. P. Meyers et al., J. Electrochem. Soc. 147 (2000) 2930: spherical particles",
    strengths=(Strength("R_r", "{port}", text="five times the resistance of a grain"),),
    apply=add(_in_spheres),
    shapes=(replace(bounded_diffusion.shapes[0], name="tau_r", text="time of diffusion through a grain"),),
    common=0.5,
)

EFFECTS = (warburg_diffusion, bounded_diffusion, blocked_diffusion, diffusion_in_spheres)
