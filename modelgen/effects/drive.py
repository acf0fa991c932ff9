"""Nonlinear laws in an impedance, where the amplitude follows from the drive: first harmonic at constant
force.

A coil fed with constant current pushes with a constant force, here 1. The moving side then has the
amplitude a = 1/(ω|Z|), with Z the impedance at that amplitude: an implicit equation at each frequency.
Sweeps may have been made at levels that nobody wrote down: then each has a strength of its own.
"""

from dataclasses import replace
from typing import Any

from sympy import Symbol

from modelgen.effects.effect import ANY, Effect, Strength, Values
from modelgen.language import Equation, Implicit, Model, Parameter, Port, Statement, im, j, re, sqrt

HARMONIC = (
    "A. H. Nayfeh, D. T. Mook, Nonlinear Oscillations (1979), sec. 4.1; first harmonic at constant force"
)
DRIVE = Parameter(
    "drive", "1", 1.0, (1e-6, 1e6), "level of the drive over that of the other records", known=True
)


def _at_drive(model: Model, port: Port, id: str, solve: Any, term: Any) -> Model:
    """Z + term(u, |Z|²), where u, 1 without the effect, is solve(u, R, X, |Z|²) = ((residual), (bracket))."""
    unit = model[port.equation].unit
    u, square = Symbol(f"{id}_u", real=True), Symbol(f"{id}_Z_2", real=True)

    def between(Z: Any) -> tuple[Statement, ...]:
        R = Equation(f"{id}_R", re(Z), unit, text="mechanical resistance without the effect")
        X = Equation(f"{id}_X", im(Z), unit, text="mechanical reactance without the effect")
        modulus = Equation(square.name, R**2 + X**2, f"({unit})**2", text="their squares' sum")
        residual, bracket = solve(u, R, X, modulus)
        return (
            R,
            X,
            modulus,
            Implicit(u.name, residual, bracket, "1", text="amplitude over that without the effect"),
        )

    return model.with_parameters(DRIVE).extend(
        port.equation, lambda Z: Z + term(u, square), statements=between
    )


def _cubic(model: Model, port: Port, p: Values) -> Model:
    """Z + κ a²/(jω). With a² = u/(ω²|Z|²): u |1 + κ u/(jω³|Z|²Z)|² = 1, and |1 + …| >= R/|Z| always."""
    w, kappa = port["omega"], p["kappa"] * DRIVE**2

    def solve(u: Any, R: Any, X: Any, square: Any) -> tuple[Any, Any]:
        g = kappa * u / (w**3 * square**2)
        return u * ((1 - g * X) ** 2 + (g * R) ** 2) - 1, (0, 2 * square / R**2)

    return _at_drive(model, port, "cubic_stiffness", solve, lambda u, square: kappa * u / (j * w**3 * square))


def _at_levels(effect: Effect, name: str) -> Effect:
    """The same law in sweeps of different levels, which is not known: its strength `name` is each one's own."""
    (strength,) = effect.strengths

    def apply(model: Model, port: Port, p: Values) -> Model:
        return effect.apply(model, port, {strength.name: p[name]})

    return replace(
        effect,
        says=f"{effect.says}; sweeps differ as they were made at different levels",
        strengths=(replace(strength, name=name),),
        apply=apply,
        common=0.5,
        each=True,
        first=True,
    )


cubic_at_drive = Effect(
    "cubic_stiffness",
    ("mechanical_impedance",),
    "the spring hardens (or softens) with the displacement squared: the resonance leans over",
    HARMONIC,
    (Strength("kappa", "{stiffness}**3", bounds=ANY, text="3/4 k_3 times the drive force squared"),),
    _cubic,
    needs=("omega",),
)


def _quadratic(model: Model, port: Port, p: Values) -> Model:
    """Z + δ ωa. With ωa = u/|Z|: u²((R + δ u/|Z|)² + X²)/|Z|² = 1, between 0 and 1."""
    delta = p["delta"] * DRIVE

    def solve(u: Any, R: Any, X: Any, square: Any) -> tuple[Any, Any]:
        return u**2 * ((R + delta * u / sqrt(square)) ** 2 + X**2) / square - 1, (0, 2)

    return _at_drive(model, port, "quadratic_damping", solve, lambda u, square: delta * u / sqrt(square))


quadratic_at_drive = Effect(
    "quadratic_damping",
    ("mechanical_impedance",),
    "drag with the square of speed: the resonance is damped the more the larger the motion",
    HARMONIC,
    (Strength("delta", "{impedance}**2", text="8/(3π) c_2 times the drive force"),),
    _quadratic,
    needs=("omega",),
)

EFFECTS = (
    cubic_at_drive,
    quadratic_at_drive,
    _at_levels(cubic_at_drive, "kappa_each"),
    _at_levels(quadratic_at_drive, "delta_each"),
)
