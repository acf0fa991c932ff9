"""Mass that moves along, in the time domain."""

from modelgen.effects.effect import Effect, Strength, add

inertia_force = Effect(
    "inertia",
    ("force",),
    "a mass moves along that the model leaves out: a force in proportion to acceleration",
    "Newton's second law",
    (Strength("M", "{port}*s**2/{z}", text="moving mass"),),
    add(lambda at, p: p["M"] * at["a"]),
    needs=("a", "z"),
    common=2.0,
)

EFFECTS = (inertia_force,)
