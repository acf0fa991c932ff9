"""The coupling between the electrical and the mechanical side, which models take for a real constant."""

from modelgen.effects.effect import ANY, Effect, Shape, Strength, change
from modelgen.language import j

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

EFFECTS = (transduction_loss, flux_shielding)
