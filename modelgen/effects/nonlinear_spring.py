"""Springs whose force isn't proportional to displacement: hardening, one-sided, magnets."""

from collections.abc import Callable
from typing import Any

from modelgen.effects.effect import ANY, RARER, Effect, Shape, Strength, Values, add, at_most
from modelgen.language import Abs, Max, Port, exp, sqrt

TEXTBOOK = "A. H. Nayfeh, D. T. Mook, Nonlinear Oscillations (1979), sec. 1.2 and 4.1"
HARDENS = "the spring hardens (or softens) with the displacement squared, alike in both directions"

cubic_stiffness = Effect(
    "cubic_stiffness",
    ("force",),
    HARDENS,
    TEXTBOOK,
    (Strength("k_3", "{port}/{z}**3", bounds=ANY, text="positive for a hardening spring"),),
    add(lambda at, p: p["k_3"] * at["z"] ** 3),
    needs=("z",),
    common=2.0,
)

quintic_stiffness = Effect(
    "cubic_stiffness",
    ("force",),
    "the spring hardens (or softens) with displacement, alike in both directions, by more than its square",
    TEXTBOOK + ": cubic and quintic terms",
    (
        Strength("k_30", "{port}/{z}**3", bounds=ANY, text="cubic term"),
        Strength("k_5", "{port}/{z}**5", bounds=ANY, text="quintic term"),
    ),
    add(lambda at, p: p["k_30"] * at["z"] ** 3 + p["k_5"] * at["z"] ** 5),
    needs=("z",),
    common=0.5,
)

asymmetric_stiffness = Effect(
    "asymmetric_stiffness",
    ("force",),
    "the spring is stiffer in one direction than in the other: an even force, k_2 z²",
    TEXTBOOK,
    (
        Strength(
            "k_2", "{port}/{z}**2", bounds=ANY, text="positive where the spring is stiffer at positive z"
        ),
    ),
    add(lambda at, p: p["k_2"] * at["z"] ** 2),
    needs=("z",),
)


def _one_sided(side: int) -> Effect:
    end, where = ("pos", "positive") if side > 0 else ("neg", "negative")
    return Effect(
        "asymmetric_stiffness",
        ("force",),
        f"the spring hardens (or softens) in one direction alone, with the square of what is {where} of z",
        TEXTBOOK + ": one of two springs is linear",
        (Strength(f"k_{end}", "{port}/{z}**2", bounds=ANY, text="quadratic term on that side"),),
        add(lambda at, p: side * p[f"k_{end}"] * Max(0, side * at["z"]) ** 2),
        needs=("z",),
        common=0.5,
    )


STEEP = 20.0
"""The largest exponent: a search may ask for a spring that nothing would move."""


def _exponential(side: int) -> Effect:
    """F = ±k z_e (e^x − 1 − x), x = ±z/z_e: what a stiffness k (e^x − 1) gives."""
    end, where = ("out", "positive") if side > 0 else ("in", "negative")

    def law(at: Port, p: Values) -> Any:
        x = at_most(side * at["z"] / p[f"z_{end}"], STEEP)
        return side * p[f"k_{end}"] * p[f"z_{end}"] * (exp(x) - 1 - x)

    return Effect(
        "asymmetric_stiffness",
        ("force",),
        "the spring is stiffer in one direction than in the other: its stiffness grows exponentially towards "
        f"{where} z",
        "Y. C. Fung, Am. J. Physiol. 213 (1967) 1532: dF/dz linear in F",
        (Strength(f"k_{end}", "{port}/{z}", bounds=ANY, text="stiffness that grows e-fold over z_e"),),
        add(law),
        (Shape(f"z_{end}", "{z}", "displacement", 0.4, 3.0, 4, text="displacement of e-fold growth, z_e"),),
        needs=("z",),
        common=0.5,
    )


bilinear_stiffness = Effect(
    "asymmetric_stiffness",
    ("force",),
    "the spring has one stiffness in tension and another one in compression: an even force, k_a |z|",
    "S. W. Shaw, P. J. Holmes, J. Sound Vib. 90 (1983) 129",
    (Strength("k_a", "{port}/{z}", bounds=ANY, text="half of what the two stiffnesses differ by"),),
    add(lambda at, p: p["k_a"] * Abs(at["z"])),
    needs=("z",),
)

knee = Effect(
    "asymmetric_stiffness",
    ("force",),
    "the spring has one stiffness in tension and another one in compression, and goes from one to the other "
    "along a bend: an even force, k_b (√(z² + w²) − w)",
    "S. W. Shaw, P. J. Holmes, J. Sound Vib. 90 (1983) 129, with its corner rounded by a hyperbola",
    (Strength("k_b", "{port}/{z}", bounds=ANY, text="half of what the two stiffnesses differ by, far out"),),
    add(lambda at, p: p["k_b"] * (sqrt(at["z"] ** 2 + p["w"] ** 2) - p["w"])),
    (Shape("w", "{z}", "displacement", 0.1, 2.0, 4, text="width of the bend"),),
    needs=("z",),
    common=0.5,
)

CLEARANCE = 0.02
"""The smallest gap over the resting gap: the pull stays finite when a search puts the magnet inside the
stroke."""


def _pull(side: int, strength: str, gap: str, held: int) -> Callable[[Port, Values], Any]:
    """Force that holds the moving side against a magnet's pull, less that at z = 0 where something has `held`
    it there."""
    return lambda at, p: -side * p[strength] * (1 / Max(1 - side * at["z"] / p[gap], CLEARANCE) ** 2 - held)


def _magnet(side: int, held: bool = True) -> Effect:
    end, where = ("upper", "positive") if side > 0 else ("lower", "negative")
    if not held:
        end = f"{end}_free"
    return Effect(
        "magnetic_pull",
        ("force",),
        f"a magnet at {where} z pulls with one over the gap squared"
        + ("" if held else ", and has moved the place of rest"),
        "J. C. Maxwell's stress B²/(2μ_0): e.g. H. H. Woodson, J. R. Melcher, Electromechanical Dynamics "
        "(1968), ch. 3",
        (Strength(f"P_{end}", "{port}", text="pull at z = 0"),),
        add(_pull(side, f"P_{end}", f"g_{end}", int(held))),
        (Shape(f"g_{end}", "{z}", "max(displacement)", 1.02, 10.0, 8, text="gap at z = 0", within=True),),
        needs=("z",),
        units=("N", "N*m", "m/s**2", "rad/s**2"),  # a force, by mass where an equation of motion is
        common=1.0 if held else RARER,
    )


SHORTEST = 0.05
"""The smallest stretch: the force stays finite when a search makes the sample shorter than its stroke."""


def _stretched(side: int) -> Callable[[Port, Values], Any]:
    """Force of an ideal rubber, K l/3 (λ − λ⁻²) with λ = 1 ± z/l, less the spring K z that a base has."""
    end = "up" if side > 0 else "down"

    def force(at: Port, p: Values) -> Any:
        length, z = p[f"l_{end}"], side * at["z"]
        stretch = Max(1 + z / length, SHORTEST)
        return side * p[f"K_{end}"] * (length / 3 * (stretch - stretch**-2) - z)

    return force


def _rubber(side: int) -> Effect:
    end, where = ("up", "positive") if side > 0 else ("down", "negative")
    return Effect(
        "asymmetric_stiffness",
        ("force",),
        f"rubber: softer the more it is stretched, stiffer when pressed; stretched at {where} z",
        "L. R. G. Treloar, The Physics of Rubber Elasticity (1975), ch. 4: f = G A (λ − 1/λ²)",
        (Strength(f"K_{end}", "{port}/{z}", text="stiffness of the rubber, unstretched"),),
        add(_stretched(side)),
        (Shape(f"l_{end}", "{z}", "displacement", 1.05, 10.0, 8, text="length of the sample"),),
        needs=("z",),
        alike=("magnetic_pull",),  # of a magnet that repels
    )


EFFECTS = (
    cubic_stiffness, quintic_stiffness, asymmetric_stiffness, _one_sided(1), _one_sided(-1), _exponential(1),
    _exponential(-1), _rubber(1), _rubber(-1), bilinear_stiffness, knee, _magnet(1), _magnet(-1),
    _magnet(1, held=False), _magnet(-1, held=False),
)  # fmt: skip
