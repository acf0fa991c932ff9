"""Friction: slip laws other than Dahl's, and friction levels that change with speed, place and direction."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from sympy import Symbol

from modelgen.effects.clearance import within
from modelgen.effects.effect import ANY, RARER, Effect, Shape, Strength, Values, add, change
from modelgen.language import Abs, Equation, Max, Model, Parameter, Port, State, exp, log, sign, sqrt, tanh

DAHL = "P. R. Dahl, Aerospace Corp. TOR-0158(3107-18)-1 (1968); MRE paper, eq. 8–9"
STRENGTHENING = (
    "J. H. Dieterich, J. Geophys. Res. 84 (1979) 2161; J. R. Rice, N. Lapusta, K. Ranjith, J. Mech. Phys. "
    "Solids 49 (2001) 1865: velocity strengthening"
)
LEAST = 0.02
"""Level that friction does not fall below along the stroke: below zero it would drive the motion."""
SLIPPED = Parameter(
    "second_dahl_element_past", "1", 0.0, (-1.0, 1.0), "state of the second element at the first sample"
)
LUBRICATED = replace(SLIPPED, name="stribeck_friction_past")


def _slipping(
    model: Model, port: Port, h: Any, name: str, stroke: Callable[[Any, Any], Any], past: Parameter = SLIPPED
) -> Model:
    """`model` with another friction h r, whose state r is `stroke`(r, dz) after a monotonic displacement dz,
    and `past` at the first sample."""
    turn = Equation(f"{name}_turn", stroke(Symbol(name, real=True), port["z_turn"] - port["z_prev"]))
    r = State(name, past, stroke(turn.symbol, port["z"] - port["z_turn"]), text="state of the second element")
    model = model.with_parameters(past)
    return model.extend(port.equation, lambda F: F + h * r, statements=(turn, r))


def _second_dahl(model: Model, port: Port, p: Values) -> Model:
    def stroke(r: Any, dz: Any) -> Any:
        """Exact for b = 1."""
        return sign(dz) + (r - sign(dz)) * exp(-Abs(dz) / p["z_2"])

    return _slipping(model, port, p["h_2"], "second_dahl_element_r", stroke)


second_dahl_element = Effect(
    "second_dahl_element",
    ("force",),
    "a second kind of contact slips with a stiffness of its own, beside the first",
    DAHL + "; W. D. Iwan, J. Appl. Mech. 33 (1966) 893",
    (Strength("h_2", "{port}", text="friction force of the second element"),),
    _second_dahl,
    (Shape("z_2", "{z}", "displacement", 0.01, 1.0, 8, text="slip length 1/ρ of the second element"),),
    needs=("z", "z_prev", "z_turn"),
)


def _slider(model: Model, port: Port, p: Values) -> Model:
    def stroke(r: Any, dz: Any) -> Any:
        return within(r + dz / p["z_j"], 1)

    return _slipping(model, port, p["h_j"], "second_slider_r", stroke)


second_slider = Effect(
    "second_dahl_element",
    ("force",),
    "a second kind of contact sticks on a spring of its own and slips all at once",
    "J. H. Griffin, J. Eng. Power 102 (1980) 329; W. D. Iwan, J. Appl. Mech. 33 (1966) 893: Jenkins element",
    (Strength("h_j", "{port}", text="friction force of the second element"),),
    _slider,
    (Shape("z_j", "{z}", "displacement", 0.02, 1.0, 8, text="way from rest to slip"),),
    needs=("z", "z_prev", "z_turn"),
    common=RARER,
)

SLIDERS = 10
DECADES = 1.35  # from the first that slips to the last one: the others have their slip lengths between


def _many_sliders(model: Model, port: Port, p: Values) -> Model:
    """Σ h_k r_k, each r_k a slider's, with slip lengths z_k from z_i down, evenly in log z_k; h_k ∝ z_k^q."""
    ratios = [10 ** (-DECADES * k / (SLIDERS - 1)) for k in range(SLIDERS)]
    shares = [x ** p["q"] for x in ratios]
    model = model.with_parameters(SLIPPED)
    ways = (port["z_turn"] - port["z_prev"], port["z"] - port["z_turn"])
    statements: list[Equation | State] = []
    total: Any = 0
    for k, (ratio, share) in enumerate(zip(ratios, shares, strict=True)):
        name = f"sliders_r_{k}"
        slip = ratio * p["z_i"]
        turn = Equation(f"{name}_turn", within(Symbol(name, real=True) + ways[0] / slip, 1))
        rest = within(SLIPPED.symbol / ratio, 1)  # all have come the same way
        r = State(name, rest, within(turn.symbol + ways[1] / slip, 1), text="state of a slider")
        statements += [turn, r]
        total += share * r.symbol
    h = p["h_i"] / sum(shares)
    return model.extend(port.equation, lambda F: F + h * total, statements=tuple(statements))


many_sliders = replace(
    second_slider,
    says="a contact slips bit by bit: it has many spots, each on a spring of its own, with slip lengths that "
    "spread over decades",
    source="W. D. Iwan, J. Appl. Mech. 33 (1966) 893; D. J. Segalman, J. Appl. Mech. 72 (2005) 752: slip "
    "lengths spread by a power law",
    strengths=(Strength("h_i", "{port}", text="friction force of all of them"),),
    apply=_many_sliders,
    shapes=(
        Shape("z_i", "{z}", "displacement", 0.05, 3.0, 4, text="way from rest to slip of the last spot"),
        Shape("q", "1", "1", 0.0, 3.0, 3, log=False, text="power of the slip length with which force grows"),
    ),
)


dahl_exponent = Effect(
    "dahl_exponent",
    ("dahl",),
    "the friction's way into slip has another shape than an exponential: dr/dz = ρ(1 − r sgn v)^b with b ≠ 1",
    DAHL,
    (Strength("b", "1", 1.0, (0.2, 5.0), text="exponent over that of the model"),),
    change(lambda b, at, p: b * p["b"]),
)


stribeck_friction = Effect(
    "stribeck_friction",
    ("friction",),
    "friction falls with speed, as a film of lubricant or of wear builds up; so does its stiffness "
    "before slip",
    "R. Stribeck, Z. VDI 46 (1902) 1341; B. Armstrong-Hélouvry et al., Automatica 30 (1994) 1083",
    (Strength("beta_h", "1", text="rise of the friction at rest over that at speed"),),
    change(lambda h, at, p: h * (1 + p["beta_h"] * exp(-Abs(at["v"]) / p["v_h"]))),
    (Shape("v_h", "{v}", "speed", 0.02, 1.0, 8, text="Stribeck velocity"),),
    needs=("v",),
)

stribeck_level = replace(
    stribeck_friction,
    says=stribeck_friction.says.replace("speed,", "speed as a bell, flat about rest,", 1),
    source=stribeck_friction.source + ": exp(−(v/v_b)²)",
    strengths=(Strength("beta_b", "1", text="rise of the friction at rest over that at speed"),),
    apply=change(lambda h, at, p: h * (1 + p["beta_b"] * exp(-((at["v"] / p["v_b"]) ** 2)))),
    shapes=(Shape("v_b", "{v}", "speed", 0.02, 1.0, 8, text="Stribeck velocity"),),
    common=0.5,
)

coulomb_friction = Effect(
    "coulomb_friction",
    ("force",),
    "dry friction: a force against the motion that does not depend on speed",
    "C. A. Coulomb, Théorie des machines simples (1785)",
    (Strength("F_c", "{port}", text="friction force"),),
    add(lambda at, p: p["F_c"] * at["v"] / sqrt(at["v"] ** 2 + p["v_0"] ** 2)),
    (Shape("v_0", "{v}", "speed", 0.001, 0.1, 4, text="speed below which friction is not yet developed"),),
    needs=("v", "z_prev"),
    common=0.5,
)

smooth_friction = replace(
    coulomb_friction,
    source=coulomb_friction.source + "; its level is reached as tanh(v/v_t)",
    strengths=(Strength("F_t", "{port}", text="friction force"),),
    apply=add(lambda at, p: p["F_t"] * tanh(at["v"] / p["v_t"])),
    shapes=(replace(coulomb_friction.shapes[0], name="v_t"),),
)

stribeck_force = Effect(
    "stribeck_friction",
    ("force",),
    "friction falls with speed, as a film of lubricant builds up: what there is at rest beside that at speed",
    stribeck_friction.source,
    (Strength("F_s", "{port}", text="rise of the friction at rest over that at speed"),),
    add(
        lambda at, p: p["F_s"] * at["v"] / sqrt(at["v"] ** 2 + p["v_r"] ** 2) * exp(-Abs(at["v"]) / p["v_f"])
    ),
    (
        Shape("v_f", "{v}", "speed", 0.02, 0.5, 5, text="Stribeck velocity"),
        Shape("v_r", "{v}", "speed", 0.001, 0.1, 3, text="speed below which friction is not yet developed"),
    ),
    needs=("v",),
    unless=("friction",),
    common=0.5,
)


def _lubricated(model: Model, port: Port, p: Values) -> Model:
    """ṙ = (v − |v| r/g)/z_l with level g(|v|): exact where it does not change within a sample."""
    level = p["s_l"] + (1 - p["s_l"]) * exp(-Abs(port["v"]) / p["v_l"])

    def stroke(r: Any, dz: Any) -> Any:
        slipping = level * sign(dz)
        return slipping + (r - slipping) * exp(-Abs(dz) / (p["z_l"] * level))

    return _slipping(model, port, p["F_l"], "stribeck_friction_r", stroke, LUBRICATED)


stribeck_element = Effect(
    "stribeck_friction",
    ("force",),
    "another contact sticks on bristles of its own, and its friction falls with speed, as a film of "
    "lubricant builds up",
    "C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky, IEEE Trans. Autom. Control 40 (1995) 419, "
    "without bristle damping",
    (Strength("F_l", "{port}", text="friction at rest"),),
    _lubricated,
    (
        Shape("v_l", "{v}", "speed", 0.03, 1.0, 3, text="Stribeck velocity"),
        Shape("z_l", "{z}", "displacement", 0.003, 0.3, 3, text="slip length at rest"),
        Shape("s_l", "1", "1", 0.1, 0.9, 2, log=False, text="friction at speed over that at rest"),
    ),
    needs=("v", "z", "z_prev", "z_turn"),
    common=RARER,
)

position_friction = Effect(
    "position_dependent_friction",
    ("friction",),
    "friction grows or falls along the stroke, as a guide gets tighter",
    "B. Armstrong-Hélouvry, Control of Machines with Friction (1991), ch. 4",
    (Strength("kappa", "1/({z})", bounds=ANY, text="relative slope of the friction level"),),
    change(lambda h, at, p: h * Max(1 + p["kappa"] * at["z"], LEAST)),
    needs=("z",),
    common=0.5,
)

rate_dependent_friction = Effect(
    "rate_dependent_friction",
    ("friction",),
    "friction grows with speed, in proportion at first, then with its logarithm; so does its stiffness "
    "before slip",
    STRENGTHENING,
    (Strength("a_h", "1", text="rise of the friction where the speed grows e-fold"),),
    change(lambda h, at, p: h * (1 + p["a_h"] * log(1 + Abs(at["v"]) / p["v_h"]))),
    (Shape("v_h", "{v}", "speed", 0.01, 3.0, 6, text="speed at which the logarithm begins"),),
    needs=("v",),
    common=0.5,
    instead=("stribeck_friction",),
)

asymmetric_friction = Effect(
    "asymmetric_friction",
    ("friction",),
    "friction is greater in one direction than in the other",
    "B. Armstrong-Hélouvry, Control of Machines with Friction (1991), ch. 4",
    (
        Strength(
            "delta", "1", bounds=(-0.95, 0.95), text="half the difference of the two levels over their mean"
        ),
    ),
    change(lambda h, at, p: h * (1 + p["delta"] * sign(at["r"]))),
    needs=("r",),
    common=0.5,
)

uneven_friction = replace(
    asymmetric_friction,
    kinds=("force",),
    says="dry friction is greater in one direction than in the other",
    strengths=(Strength("F_d", "{port}", bounds=ANY, text="half the difference of the two levels"),),
    apply=add(lambda at, p: p["F_d"] * Abs(at["v"]) / sqrt(at["v"] ** 2 + p["v_0"] ** 2)),
    shapes=coulomb_friction.shapes,
    needs=("v", "z_prev"),
    unless=("friction",),
)

EFFECTS = (
    second_dahl_element, second_slider, many_sliders, dahl_exponent, stribeck_friction, stribeck_level,
    coulomb_friction, smooth_friction, stribeck_force, stribeck_element, position_friction,
    rate_dependent_friction, asymmetric_friction, uneven_friction,
)  # fmt: skip
