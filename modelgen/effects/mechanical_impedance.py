"""What hangs on a moving part: dashpots, masses, springs, the air around it. Frequency domain."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from sympy import Rational

from modelgen.effects.effect import (
    RARER,
    Effect,
    Shape,
    Strength,
    Values,
    add_impedance,
    add_stiffness,
    unit_omega,
)
from modelgen.effects.rod import xcotx
from modelgen.language import Model, Port, j, powj

MECHANICAL = ("mechanical_impedance", "stiffness")

contact_damping = Effect(
    "contact_damping",
    MECHANICAL,
    "contacting surfaces lose energy in proportion to their speed: a constant mechanical resistance",
    "GMM paper, eq. 9 and A1–A12",
    (Strength("R", "{impedance}", text="mechanical resistance"),),
    add_impedance(lambda at, p: p["R"]),
    needs=("omega",),
    common=2.0,
)

inertia = Effect(
    "inertia",
    MECHANICAL,
    "a mass moves along that the model leaves out",
    "Newton's second law",
    (Strength("M", "{impedance}*s", text="moving mass"),),
    add_impedance(lambda at, p: j * at["omega"] * p["M"]),
    needs=("omega",),
    common=2.0,
)

added_stiffness = Effect(
    "added_stiffness",
    ("mechanical_impedance",),
    "a spring acts in parallel that the model leaves out",
    "Hooke's law",
    (Strength("K", "{stiffness}", text="stiffness"),),
    add_stiffness(lambda at, p: p["K"]),
    needs=("omega",),
)

radiation_load = Effect(
    "radiation_load",
    ("mechanical_impedance",),
    "sound is radiated into the medium: a mass at low frequency, a resistance ρcS where the wave is "
    "shorter than the "
    "radiator",
    "P. M. Morse, K. U. Ingard, Theoretical Acoustics (1968), sec. 7.1: pulsating sphere, ρcS jka/(1 + jka)",
    (Strength("R", "{impedance}", text="ρcS, resistance at high frequency"),),
    add_impedance(lambda at, p: p["R"] * j * at["omega"] * p["tau"] / (1 + j * at["omega"] * p["tau"])),
    (Shape("tau", "s", "time", 0.1, 0.3, 8, text="a/c, time that sound needs over the radiator's radius"),),
    needs=("omega",),
)

ABOVE = (0.8471, 0.3866, 0.1243, 0.02877, 0.002819, 0.000423)
BELOW = (1.034, 0.5025, 0.1397, 0.03108, 0.00306, 0.000423)
"""A piston's radiation as powers of s = jka from the first on, over 1 and powers of s: passive, and within
2.4 % of 1 − J1(2ka)/ka + j H1(2ka)/ka (Struve's H1) at every ka."""


def _radiated(s: Any) -> Any:
    above, below = (_powers(c, s) for c in (ABOVE, BELOW))
    return above / (1 + below)


def _powers(coefficients: Sequence[float], s: Any) -> Any:
    """Σ c_n sⁿ, n from 1, by Horner's scheme."""
    total: Any = 0
    for c in reversed(coefficients):
        total = (total + c) * s
    return total


piston_load = Effect(
    "radiation_load",
    ("mechanical_impedance",),
    "sound is radiated from a flat piston: a mass at low frequency, a resistance ρcS where the wave is "
    "shorter than its radius, with a ripple between",
    "P. M. Morse, K. U. Ingard, Theoretical Acoustics (1968), sec. 7.4: piston in a wall, "
    "1 − J1(2ka)/ka + j H1(2ka)/ka",
    (Strength("R_p", "{impedance}", text="ρcS, resistance at high frequency"),),
    add_impedance(lambda at, p: p["R_p"] * _radiated(j * at["omega"] * p["tau_p"])),
    (Shape("tau_p", "s", "time", 0.1, 3.0, 10, text="a/c, time that sound needs over the piston's radius"),),
    needs=("omega",),
)

radiated_power = Effect(
    "radiation_load",
    ("mechanical_impedance",),
    "sound is radiated by what is smaller than its wave: a resistance that grows with the square of "
    "frequency, the medium that moves along being counted with the moving mass",
    "L. E. Kinsler et al., Fundamentals of Acoustics (2000), sec. 7.5: ρcS (ka)²/2, of a piston at low ka",
    (Strength("R_w", "{impedance}*s**2", text="resistance over the square of angular frequency"),),
    add_impedance(lambda at, p: p["R_w"] * at["omega"] ** 2),
    needs=("omega",),
)

piston_beyond_its_mass = replace(
    piston_load,
    says="sound is radiated from a flat piston, the medium that moves along at low frequency being counted "
    "with the moving mass, as one that was measured in it holds: a resistance up to ρcS, and less of that "
    "mass where the wave is shorter than the radius",
    strengths=(replace(piston_load.strengths[0], name="R_m"),),
    apply=add_impedance(
        lambda at, p: (
            p["R_m"] * (_radiated(j * at["omega"] * p["tau_m"]) - ABOVE[0] * j * at["omega"] * p["tau_m"])
        )
    ),
    shapes=(replace(piston_load.shapes[0], name="tau_m", points=5),),
    common=0.5,
)


def _viscous(model: Model, port: Port, p: Values) -> Model:
    model = unit_omega(model)
    w = port["omega"] / model.parameter("unit_omega")
    return add_impedance(lambda at, p: p["R_v"] * powj(w, HALF))(model, port, p)


HALF = Rational(1, 2)

viscous_load = Effect(
    "viscous_load",
    MECHANICAL,
    "a viscous fluid is dragged along in a layer that gets thinner with frequency: mass and resistance, "
    "alike and both growing with the root of frequency",
    "G. G. Stokes, Trans. Camb. Phil. Soc. 9 (1851) 8; K. K. Kanazawa, J. G. Gordon, Anal. Chim. Acta 175 "
    "(1985) 99: √(jωρη) S",
    (Strength("R_v", "{impedance}", text="its modulus at ω = 1 rad/s"),),
    _viscous,
    needs=("omega",),
    common=0.2,  # what is immersed in a liquid
)

viscous_film = replace(
    viscous_load,
    says="a film of viscous fluid is sheared between the moving part and a wall: a dashpot, and from the "
    "frequency on at which the layer that is dragged along gets thinner than the film, mass and resistance",
    source="L. D. Landau, E. M. Lifshitz, Fluid Mechanics (1987), § 24: ηS/h x coth x, x² = jωτ, τ = ρh²/η",
    strengths=(Strength("R_h", "{impedance}", text="resistance at low frequency"),),
    apply=add_impedance(lambda at, p: p["R_h"] * xcotx(-j * at["omega"] * p["tau"])),
    shapes=(Shape("tau", "s", "time", 0.1, 30.0, 5, text="time in which drag spreads across the film"),),
    common=RARER,
)

EFFECTS = (
    contact_damping, inertia, added_stiffness, radiation_load, piston_load, radiated_power,
    piston_beyond_its_mass, viscous_load, viscous_film,
)  # fmt: skip
