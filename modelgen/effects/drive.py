"""Nonlinear laws in an impedance, where the amplitude follows from the drive: first harmonic at constant
force or constant voltage.

A coil fed with constant current pushes with a constant force, here 1. The moving side then has the
amplitude a = 1/(ω|Z|), with Z the impedance at that amplitude: an implicit equation at each frequency. Fed
with constant voltage it is braked as well, as by a dashpot Bl²/R: a = 1/(ω|Y|), Y = Z + Bl²/(R + jωL).
Sweeps may have been made at levels that nobody wrote down: then each has a strength of its own.
"""

from dataclasses import replace
from typing import Any

from sympy import Symbol

from modelgen.effects.effect import ANY, RARER, UPON, Effect, Shape, Strength, Values
from modelgen.language import Equation, Implicit, Model, Parameter, Port, Statement, im, j, re, sqrt

UNDAMPED = 1e-12
"""Share of |Z|² that limits the search for the amplitude where nothing else does, R = 0."""
HARMONIC = "A. H. Nayfeh, D. T. Mook, Nonlinear Oscillations (1979), sec. 4.1; first harmonic"
DRIVE = Parameter(
    "drive", "1", 1.0, (1e-6, 1e6), "level of the drive over that of the other records", known=True
)


BRAKE = (
    Shape(
        "R_v",
        "{impedance}",
        "min(port)",
        0.3,
        10.0,
        3,
        text="Bl²/R, by which a drive of constant voltage brakes",
    ),
    Shape("tau_v", "s", "1/max(omega)", 0.1, 10.0, 2, text="L/R of the coil, which delays that"),
)


def _at_drive(model: Model, port: Port, p: Values, id: str, solve: Any, term: Any) -> Model:
    """Z + term(u, |Y|²), where u, 1 without the effect, is solve(u, R, X, |Y|²) = ((residual), (bracket)) and
    Y = R + jX is Z with the brake."""
    unit = model[port.equation].unit
    u, square = Symbol(f"{id}_u", real=True), Symbol(f"{id}_Z_2", real=True)

    def between(Z: Any) -> tuple[Statement, ...]:
        if "R_v" in p:
            Z += p["R_v"] / (1 + j * port["omega"] * p["tau_v"])
        R = Equation(f"{id}_R", re(Z), unit, text="resistance by which the amplitude is limited")
        X = Equation(f"{id}_X", im(Z), unit, text="reactance by which the amplitude is limited")
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
        return u * ((1 - g * X) ** 2 + (g * R) ** 2) - 1, (0, 2 * square / (R**2 + UNDAMPED * square))

    return _at_drive(
        model, port, p, "cubic_stiffness", solve, lambda u, square: kappa * u / (j * w**3 * square)
    )


cubic_at_drive = Effect(
    "cubic_stiffness",
    ("mechanical_impedance",),
    "the spring hardens (or softens) with the displacement squared: the resonance leans over",
    HARMONIC,
    (Strength("kappa", "{stiffness}**3", bounds=ANY, text="3/4 k_3 times the drive force squared"),),
    _cubic,
    needs=("omega",),
    acts=UPON,
)


def _quadratic(model: Model, port: Port, p: Values) -> Model:
    """Z + δ ωa. With ωa = u/|Z|: u²((R + δ u/|Z|)² + X²)/|Z|² = 1, between 0 and 1."""
    delta = p["delta"] * DRIVE

    def solve(u: Any, R: Any, X: Any, square: Any) -> tuple[Any, Any]:
        return u**2 * ((R + delta * u / sqrt(square)) ** 2 + X**2) / square - 1, (0, 2)

    return _at_drive(model, port, p, "quadratic_damping", solve, lambda u, square: delta * u / sqrt(square))


quadratic_at_drive = Effect(
    "quadratic_damping",
    ("mechanical_impedance",),
    "drag with the square of speed: the resonance is damped the more the larger the motion",
    HARMONIC,
    (Strength("delta", "{impedance}**2", text="8/(3π) c_2 times the drive force"),),
    _quadratic,
    needs=("omega",),
    acts=UPON,
)


def _otherwise(effect: Effect, mark: str, says: str, brake: bool, each: bool) -> Effect:
    """The same law with a `mark` on its parameters' names: braked by the drive, or in sweeps of levels that
    are not known, with a strength of each one's own."""
    (strength,) = effect.strengths
    shapes = tuple(replace(q, name=f"{q.name}{mark}") for q in BRAKE) if brake else ()

    def apply(model: Model, port: Port, p: Values) -> Model:
        return effect.apply(model, port, {n.removesuffix(mark): q for n, q in p.items()})

    return replace(
        effect,
        says=effect.says + says,
        strengths=(replace(strength, name=f"{strength.name}{mark}"),),
        apply=apply,
        shapes=shapes,
        common=(RARER if brake else 1.0) * (0.5 if each else 1.0),
        each=each,
        first=each,
    )


VOLTAGE, LEVELS = ", at constant voltage", "; sweeps differ as they were made at different levels"
LAWS = (cubic_at_drive, quadratic_at_drive)
EFFECTS = (
    *LAWS,
    *(_otherwise(e, "_v", VOLTAGE, True, False) for e in LAWS),
    *(_otherwise(e, "_each", LEVELS, False, True) for e in LAWS),
    *(_otherwise(e, "_v_each", VOLTAGE + LEVELS, True, True) for e in LAWS),
)
