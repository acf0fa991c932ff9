"""All effects that ship, in one tuple."""

from modelgen.effects import (
    clearance,
    cycle,
    damping,
    dielectric,
    drift,
    drive,
    eddy,
    electrical,
    friction,
    joint,
    mass,
    mechanical_impedance,
    nonlinear_spring,
    resonance,
    sensor,
    softening,
    stribeck,
    viscoelastic,
)
from modelgen.effects.effect import Effect

CATALOGUE: tuple[Effect, ...] = (
    *eddy.EFFECTS,
    *electrical.EFFECTS,
    *dielectric.EFFECTS,
    *mechanical_impedance.EFFECTS,
    *viscoelastic.EFFECTS,
    *resonance.EFFECTS,
    *nonlinear_spring.EFFECTS,
    *softening.EFFECTS,
    *damping.EFFECTS,
    *drive.EFFECTS,
    *friction.EFFECTS,
    *mass.EFFECTS,
    *stribeck.EFFECTS,
    *clearance.EFFECTS,
    *joint.EFFECTS,
    *drift.EFFECTS,
    *sensor.EFFECTS,
    *cycle.EFFECTS,
)
