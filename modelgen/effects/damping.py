"""Damping in the time domain: dashpots that aren't linear, and the linear one."""

from dataclasses import replace

from sympy import Rational

from modelgen.effects.effect import ANY, RARER, Effect, Shape, Strength, Values, add, unit_of
from modelgen.language import Abs, Max, Model, Parameter, Port, sign

DRAG = "drag with the square of speed, as of a turbulent fluid through an orifice"
TEXTBOOK = "L. S. Jacobsen, Trans. ASME 52 (1930) 169"

viscous_force = Effect(
    "contact_damping",
    ("force",),
    "contacting surfaces lose energy in proportion to their speed: a dashpot",
    "GMM paper, eq. 9 and A1–A12",
    (Strength("R", "{port}/({v})", text="damping coefficient"),),
    add(lambda at, p: p["R"] * at["v"]),
    needs=("v",),
)

quadratic_damping = Effect(
    "quadratic_damping",
    ("force",),
    DRAG,
    TEXTBOOK,
    (Strength("c_2", "{port}/({v})**2", text="drag over speed squared"),),
    add(lambda at, p: p["c_2"] * at["v"] * Abs(at["v"])),
    needs=("v",),
)

asymmetric_damping = Effect(
    "asymmetric_damping",
    ("force",),
    "the dashpot is harder in one direction than in the other, as a damper with valves",
    "J. C. Dixon, The Shock Absorber Handbook (2007), ch. 5",
    (
        Strength(
            "c_a", "{port}/({v})", bounds=ANY, text="half the difference of the two damping coefficients"
        ),
    ),
    add(lambda at, p: p["c_a"] * Abs(at["v"])),
    needs=("v",),
    common=0.5,
)


position_damping = Effect(
    "position_dependent_damping",
    ("force",),
    "the dashpot grows or falls along the stroke, as in a damper with a metering pin or a cylinder that "
    "isn't round",
    "J. C. Dixon, The Shock Absorber Handbook (2007), ch. 5: position-dependent damping",
    (Strength("c_z", "{port}/(({v})*({z}))", bounds=ANY, text="slope of the damping coefficient"),),
    add(lambda at, p: p["c_z"] * at["z"] * at["v"]),
    needs=("z", "v"),
    common=0.5,
)


grooved_damping = replace(
    position_damping,
    says="the dashpot is harder (or softer) at the ends of the stroke than between them, as in a damper with "
    "metering grooves or one whose fluid is squeezed out",
    strengths=(
        Strength("c_z1", "{port}/(({v})*({z}))", bounds=ANY, text="slope of the damping coefficient"),
        Strength("c_z2", "{port}/(({v})*({z})**2)", bounds=ANY, text="half its curvature"),
    ),
    apply=add(lambda at, p: (p["c_z1"] * at["z"] + p["c_z2"] * at["z"] ** 2) * at["v"]),
)


def _pin(side: int) -> Effect:
    """F + ±D max(0, ±(z − z_p)) v."""
    end = "upper" if side > 0 else "lower"
    place = Shape(f"z_{end}", "{z}", "position", 1.0, 1.0, 12, log=False, text="where it begins", within=True)
    return replace(
        position_damping,
        says=f"from a certain displacement on, towards the {end} end, the dashpot grows (or falls) with the "
        "way beyond, as where a metering pin enters its hole",
        strengths=(
            Strength(f"d_{end}", "{port}/(({v})*({z}))", bounds=ANY, text="slope of the damping beyond"),
        ),
        apply=add(
            lambda at, p: p[f"d_{end}"] * Max(0, side * (at["z"] - p[f"z_{end}"])) * at["v"],
        ),
        shapes=(place,),
        common=RARER,
    )


def _power_law_damping(model: Model, port: Port, p: Values) -> Model:
    unit = _unit(model, port)
    v = port["v"]
    return model.with_parameters(unit).extend(
        port.equation, lambda F: F + p["c_n"] * sign(v) * (Abs(v) / unit + 1e-12) ** p["n"]
    )


def _unit(model: Model, port: Port) -> Parameter:
    unit = unit_of(model, port["v"])
    return Parameter("unit_speed", unit, 1.0, (0.5, 2.0), "the unit of speed", known=True)


def _blasius(model: Model, port: Port, p: Values) -> Model:
    unit = _unit(model, port)
    v = port["v"]
    drag = p["c_b"] * v * (Abs(v) / unit + 1e-12) ** Rational(3, 4)
    return model.with_parameters(unit).extend(port.equation, lambda F: F + drag)


smooth_pipe = Effect(
    "quadratic_damping",
    ("force",),
    "drag with speed to the power 7/4, as of a turbulent fluid in a smooth channel",
    "H. Blasius, VDI-Forschungsheft 131 (1913)",
    (Strength("c_b", "{port}/({v})", text="drag at unit speed over speed"),),
    _blasius,
    needs=("v",),
    common=RARER,
)

power_law_damping = Effect(
    "power_law_damping",
    ("force",),
    "the dashpot shear-thins: its force grows with a power of speed below one",
    "N. Makris, M. C. Constantinou, J. Struct. Eng. 117 (1991) 2708; J. C. Dixon, The Shock Absorber "
    "Handbook (2007)",
    (Strength("c_n", "{port}", text="force at unit speed"),),
    _power_law_damping,
    (Shape("n", "1", "1", 0.25, 0.9, 4, log=False, text="exponent; 1: a linear dashpot, 0: friction"),),
    needs=("v",),
    common=0.5,
)

carreau_damping = replace(
    power_law_damping,
    says="the dashpot shear-thins: linear where it is slow, its force grows with a power of speed below one "
    "where it is fast",
    source="P. J. Carreau, Trans. Soc. Rheol. 16 (1972) 99: viscosity falls as (1 + (v/v_c)^2)^((n - 1)/2)",
    strengths=(Strength("c_0", "{port}/({v})", text="damping coefficient where it is slow"),),
    apply=add(lambda at, p: p["c_0"] * at["v"] * (1 + (at["v"] / p["v_c"]) ** 2) ** ((p["m"] - 1) / 2)),
    shapes=(
        Shape("v_c", "{v}", "speed", 0.02, 0.7, 4, text="speed where it begins to thin"),
        Shape("m", "1", "1", 0.1, 0.8, 3, log=False, text="exponent of speed where it is fast"),
    ),
    common=RARER,
)

EFFECTS = (
    viscous_force,
    quadratic_damping,
    asymmetric_damping,
    position_damping,
    grooved_damping,
    _pin(1),
    _pin(-1),
    smooth_pipe,
    power_law_damping,
    carreau_damping,
)
