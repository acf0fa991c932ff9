"""All effects that ship, in one tuple."""

from modelgen.effects import (
    clearance,
    damping,
    drift,
    eddy,
    electrical,
    friction,
    mechanical_impedance,
    nonlinear_spring,
    resonance,
    sensor,
    softening,
    viscoelastic,
)
from modelgen.effects.effect import Effect

CATALOGUE: tuple[Effect, ...] = (
    *eddy.EFFECTS,
    *electrical.EFFECTS,
    *mechanical_impedance.EFFECTS,
    *viscoelastic.EFFECTS,
    *resonance.EFFECTS,
    *nonlinear_spring.EFFECTS,
    *softening.EFFECTS,
    *damping.EFFECTS,
    *friction.EFFECTS,
    *clearance.EFFECTS,
    *drift.EFFECTS,
    *sensor.EFFECTS,
)
