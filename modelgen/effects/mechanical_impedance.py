"""What hangs on a moving part: dashpots, masses, springs, the air around it. Frequency domain."""

from modelgen.effects.effect import Effect, Shape, Strength, add_impedance, add_stiffness
from modelgen.language import j

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

EFFECTS = (contact_damping, inertia, added_stiffness, radiation_load)
