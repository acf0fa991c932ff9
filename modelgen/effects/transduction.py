"""The coupling between the electrical and the mechanical side, which models take for a real constant."""

from dataclasses import replace
from typing import Any

from sympy import Rational

from modelgen.effects.effect import ANY, Effect, Shape, Strength, Values, change
from modelgen.language import Port, j, powj

transduction_loss = Effect(
    "transduction_loss",
    ("transduction",),
    "the transduction itself loses energy: the force follows the field late, by one angle at all frequencies",
    "R. Holland, IEEE Trans. Sonics Ultrason. 14 (1967) 18; K. Uchino, S. Hirose, IEEE Trans. UFFC 48 (2001) "
    "307: piezoelectric loss, φ(1 − j tan θ)",
    (Strength("tan_theta", "1", bounds=ANY, text="tangent of the loss angle"),),
    change(lambda T, at, p: T * (1 - j * p["tan_theta"])),
    needs=("omega",),
    family="transduction",
    common=0.25,
)


def _diffused(T: Any, at: Port, p: Values) -> Any:
    s = powj(at["omega"] * p["tau_d"], Rational(1, 2))
    return T * (1 - p["g_d"] * s / (1 + s))


flux_shielding = Effect(
    "flux_shielding",
    ("transduction",),
    "currents around the gap screen its flux: the force factor falls with frequency, and lags",
    "J. Vanderkooy, JAES 37 (1989) 119; a transformer with one shorted turn, T(1 − g jωτ/(1 + jωτ))",
    (Strength("g", "1", bounds=(0.0, 1.0), text="share of the force factor that is screened"),),
    change(lambda T, at, p: T * (1 - p["g"] * j * at["omega"] * p["tau"] / (1 + j * at["omega"] * p["tau"]))),
    (Shape("tau", "s", "time", 0.3, 3.0, text="time in which the flux follows"),),
    needs=("omega",),
    family="transduction",
    common=0.25,
)

flux_diffusion = replace(
    flux_shielding,
    says="the gap's flux has to enter thick metal: the force factor falls slowly with frequency, and lags",
    source="R. L. Stoll, The Analysis of Eddy Currents (1974), ch. 2: a skin, T(1 − g s/(1 + s)), s = √(jωτ)",
    strengths=(replace(flux_shielding.strengths[0], name="g_d"),),
    apply=change(_diffused),
    shapes=(replace(flux_shielding.shapes[0], name="tau_d", low=0.03, high=30.0),),
)

EFFECTS = (transduction_loss, flux_shielding, flux_diffusion)
