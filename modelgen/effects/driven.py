"""Memories and resonances of a motion that is not recorded but follows from what drives the model: an
oscillator under a force, a loudspeaker under a voltage. Where displacement and speed are themselves
integrated, so are these.

Time domain. Ports whose displacement is recorded have laws that are exact between samples (`viscoelastic`,
`friction`).
"""

from dataclasses import replace
from math import inf

from sympy import Symbol

from modelgen.effects.effect import Effect, Shape, Strength, Values, add, unit_of
from modelgen.effects.friction import SLIPPED, coulomb_friction, second_dahl_element
from modelgen.effects.resonance import second_mode
from modelgen.effects.start import at_start
from modelgen.effects.viscoelastic import maxwell_branch
from modelgen.language import Abs, Model, Parameter, Port, State, sign, sqrt

SUBSTEPS = 4
"""Runge–Kutta steps between samples, at least: friction that slips within a tenth of the stroke is still
followed."""
RECORDED = ("z_prev",)
"""What ports have where the displacement is recorded."""


def _maxwell(model: Model, port: Port, p: Values) -> Model:
    """The foot follows z in the time τ. At first it is where z is, but for what stretched it before."""
    unit = unit_of(model, port["z"])
    text = "stretch of the branch at the first sample"
    before = Parameter("maxwell_branch_before", unit, 0.0, (-inf, inf), text)
    z, foot = port["z"], Symbol("maxwell_branch_foot", real=True)
    state = State(
        foot.name,
        at_start(model, z) - before,
        rate=(z - foot) / p["tau"],
        unit=unit,
        text="foot of a Maxwell arm",
        substeps=SUBSTEPS,
    )
    return model.with_parameters(before).extend(
        port.equation, lambda F: F + p["k"] * (z - foot), statements=(state,)
    )


maxwell_driven = Effect(
    "maxwell_branch",
    ("force",),
    maxwell_branch.says,
    maxwell_branch.source,
    (Strength("k", "{port}/({z})", text="stiffness of the branch"),),
    _maxwell,
    (Shape("tau", "s", "time", 1.0, 3.0, text="relaxation time"),),  # faster, it is how inputs run in a step
    needs=("z",),
    lacks=RECORDED,
)


def _second_dahl(model: Model, port: Port, p: Values) -> Model:
    """dr/dt = (v − |v| r)/z_2."""
    v, r = port["v"], Symbol("second_dahl_element_r", real=True)
    state = State(
        r.name,
        SLIPPED,
        rate=(v - Abs(v) * r) / p["z_2"],
        text="state of the second element",
        substeps=SUBSTEPS,
    )
    return model.with_parameters(SLIPPED).extend(
        port.equation, lambda F: F + p["h_2"] * r, statements=(state,)
    )


second_dahl_driven = Effect(
    "second_dahl_element",
    ("force",),
    "contacts stick and slip: a hysteresis that does not depend on speed, beside what the model has",
    second_dahl_element.source,
    (Strength("h_2", "{port}", text="friction force of the second element"),),
    _second_dahl,
    (Shape("z_2", "{v}*s", "displacement", 0.1, 3.0, 6, text="slip length 1/ρ of the second element"),),
    needs=("v",),
    lacks=RECORDED,
)


def _coulomb(model: Model, port: Port, p: Values) -> Model:
    v = port["v"]
    finer = (
        replace(s, substeps=max(s.substeps, SUBSTEPS)) if isinstance(s, State) and s.rate is not None else s
        for s in model.statements
    )
    model = replace(model, statements=tuple(finer))
    return model.extend(port.equation, lambda F: F + p["F_c"] * v / sqrt(v**2 + p["v_0"] ** 2))


coulomb_driven = replace(
    coulomb_friction,
    apply=_coulomb,
    shapes=(replace(coulomb_friction.shapes[0], low=0.003),),
    needs=("v",),
    lacks=RECORDED,
    common=1.0,
)


def _hung(model: Model, port: Port, p: Values) -> Model:
    """M_2 x'' = M_2 (ω_2² (z − x) + (ω_2/Q)(v − x')), which the port feels. At first it moves along."""
    z, v = port["z"], port["v"]
    x, u = (Symbol(f"second_mode_{n}", real=True) for n in ("x", "u"))
    pull = p["omega_2"] * (p["omega_2"] * (z - x) + (v - u) / p["Q"])
    unit, speed = unit_of(model, z), unit_of(model, v)
    states = (
        State(x.name, at_start(model, z), rate=u, unit=unit, text="where the mass is", substeps=SUBSTEPS),
        State(u.name, at_start(model, v), rate=pull, unit=speed, text="its speed", substeps=SUBSTEPS),
    )
    return model.extend(port.equation, lambda F: F + p["M_2"] * pull, statements=states)


hung_mass = Effect(
    "second_mode",
    ("force",),
    second_mode.says,
    second_mode.source,
    (Strength("M_2", "{port}*s**2/({z})", text="mass of the resonator"),),
    _hung,
    (
        Shape("omega_2", "rad/s", "omega", 3.0, 1.5, 16, text="its resonance when its foot is held"),
        Shape("Q", "1", "1", 1.0, 50.0, 3, text="its quality factor"),
    ),
    needs=("z", "v"),
    lacks=RECORDED,
)


def _power_law(model: Model, port: Port, p: Values) -> Model:
    z = port["z"]
    unit = Parameter("unit_level", unit_of(model, z), 1.0, (0.5, 2.0), "the unit of z", known=True)
    return model.with_parameters(unit).extend(
        port.equation, lambda F: F + p["c_z"] * sign(z) * (Abs(z) / unit + TINY) ** p["n_z"]
    )


TINY = 1e-12  # the power's derivative by n stays finite at z = 0

power_law_stiffness = Effect(
    "power_law_stiffness",
    ("force",),
    "what works against z grows with a power of it below one, as the flow out of a tank with the root of its "
    "level",
    "E. Torricelli, De motu gravium (1643): the power 1/2 of an orifice",
    (Strength("c_z", "{port}", text="its value where z is 1 in its unit"),),
    _power_law,
    (Shape("n_z", "1", "1", 0.2, 0.8, 3, log=False, text="exponent; 1 for a linear law"),),
    needs=("z",),
    lacks=RECORDED,
    common=0.5,
)

laminar_then_root = replace(
    power_law_stiffness,
    says="what works against z is in proportion to it at first and grows with its root later, as the flow "
    "through a pipe that is laminar and then turbulent",
    source="I. E. Idelchik, Handbook of Hydraulic Resistance (1986), ch. 1: heads z = a q + b q² in series",
    strengths=(Strength("c_r", "{port}", text="its value where z is three times z_r"),),
    apply=add(lambda at, p: p["c_r"] * sign(at["z"]) * (sqrt(1 + Abs(at["z"]) / p["z_r"]) - 1)),
    shapes=(
        Shape("z_r", "{z}", "displacement", 0.02, 2.0, 4, text="where the one goes over into the other"),
    ),
)

added_stiffness = Effect(
    "added_stiffness",
    ("force",),
    "a spring that the model leaves out, or a leak: what works against z in proportion to it",
    "Hooke's law; Ohm's law",
    (Strength("k_add", "{port}/({z})", text="stiffness, or conductance"),),
    add(lambda at, p: p["k_add"] * at["z"]),
    needs=("z",),
    lacks=RECORDED,
)

EFFECTS = (
    maxwell_driven, second_dahl_driven, coulomb_driven, hung_mass, power_law_stiffness, laminar_then_root,
    added_stiffness,
)  # fmt: skip
