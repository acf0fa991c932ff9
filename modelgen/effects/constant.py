"""What is there all the time and was forgotten: a weight, a preload, a zero that is off."""

from modelgen.effects.effect import ANY, Effect, Strength, add

constant_load = Effect(
    "constant_load",
    ("force",),
    "a constant load, as a weight or a preload",
    "statics; a bias that a model has no parameter for",
    (Strength("F", "{port}", bounds=ANY, text="the load"),),
    add(lambda at, p: p["F"]),
    needs=("t",),
)

zero_error = Effect(
    "zero_error",
    ("sensor",),
    "the zero of what was recorded is off",
    "JCGM 200:2012 (VIM), 4.28: zero error",
    (Strength("y_0", "{port}", bounds=ANY, text="what is shown where there is nothing"),),
    add(lambda at, p: p["y_0"]),
    needs=("t",),
)

EFFECTS = (constant_load, zero_error)
