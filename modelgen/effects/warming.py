"""What changes in the course of a record as a sample warms up."""

from dataclasses import replace

from sympy import Expr, Symbol

from modelgen.effects.drift import SETTLES, WARMTH, WHOLE, settling
from modelgen.effects.effect import ANY, Effect, Strength, Values, unit_of
from modelgen.effects.motion import partners, way
from modelgen.language import Model, Parameter, Piecewise, Port, State, exp

WARMS = "the stiffness changes in the course of the record, as the sample warms up"

temperature_drift = Effect(
    "temperature_drift",
    ("spring",),
    WARMS,
    WARMTH,
    (Strength("beta", "1/s", bounds=ANY, text="relative rate of change of the stiffness at the start"),),
    lambda model, port, p: settling(
        "temperature_drift", model, port, p["tau"], lambda k, s: k * (1 + p["beta"] * s)
    ),
    (SETTLES,),
    needs=("t",),
)


def _softer(model: Model, port: Port, p: Values) -> Model:
    beta, tau = p.values()
    for q in (port, *partners(model, port, "friction")):
        at = replace(port, equation=q.equation)  # a port of friction needs not tell the time
        model = settling("material_warming", model, at, tau, lambda x, s: x * (1 + beta * s))
    return model


material_warming = replace(
    temperature_drift,
    says=WHOLE,
    strengths=(replace(temperature_drift.strengths[0], name="beta_w"),),
    apply=_softer,
    shapes=(replace(SETTLES, name="tau_w"),),
    also=("friction",),
    common=0.5,
)


own_warming = replace(
    material_warming,
    says=f"{WHOLE}, otherwise in each record",
    strengths=(replace(temperature_drift.strengths[0], name="beta_own"),),
    shapes=(replace(SETTLES, name="tau_own"),),
    each=True,
    first=True,
)


dashpot_warming = replace(
    temperature_drift,
    kinds=("force",),
    says="the dashpot gets softer (or harder) in the course of the record, as its fluid or material warms up",
    source="O. Reynolds, Phil. Trans. R. Soc. 177 (1886) 157: viscosity and temperature; Newton's cooling",
    strengths=(
        Strength("dc", "{port}/({v}*s)", bounds=ANY, text="rate of change of the damping at the start"),
    ),
    apply=lambda model, port, p: settling(
        "dashpot_warming", model, port, p["tau_c"], lambda F, s: F + p["dc"] * s * port["v"]
    ),
    shapes=(replace(SETTLES, name="tau_c"),),
    needs=("t", "v"),
    common=0.5,
)


ALL = "spring, friction and dashpot, all but what force is constant"
COOLER = Strength("d_s", "{port}/s", bounds=ANY, text="less so much of its constant part")

sample_warming = replace(
    temperature_drift,
    kinds=("force",),
    says=f"the material gets softer (or harder) in the course of the record, as it warms up: {ALL}",
    strengths=(
        replace(temperature_drift.strengths[0], name="beta_s", text="relative rate of change"),
        COOLER,
    ),
    apply=lambda model, port, p: settling(
        "sample_warming", model, port, p["tau_s"], lambda F, s: F + (p["beta_s"] * F + p["d_s"]) * s
    ),
    shapes=(replace(SETTLES, name="tau_s"),),
    common=0.5,
)


def _all_softer(model: Model, port: Port, p: Values) -> Model:
    """Rates of spring and friction, and of the dashpot, which feels the same warmth."""
    beta, dc, tau = p.values()
    for q in (*partners(model, port, "spring"), *partners(model, port, "friction")):
        at = replace(port, equation=q.equation)
        model = settling("own_sample", model, at, tau, lambda x, s: x * (1 + beta * s))
    return settling("own_sample", model, port, tau, lambda F, s: F + dc * s * port["v"])


sample_and_dashpot_warming = replace(
    dashpot_warming,
    says=f"{WHOLE} alike, the dashpot by its own measure",
    source=f"{WARMTH}; {dashpot_warming.source}",
    strengths=(
        replace(temperature_drift.strengths[0], name="beta_a", text="relative rate of change at the start"),
        replace(dashpot_warming.strengths[0], name="dc_a"),
    ),
    apply=_all_softer,
    shapes=(replace(SETTLES, name="tau_a"),),
    also=("spring", "friction"),
)

own_sample_warming = replace(
    sample_and_dashpot_warming,
    says=f"{sample_and_dashpot_warming.says}, otherwise in each record",
    strengths=tuple(replace(q, name=f"{q.name}_own") for q in sample_and_dashpot_warming.strengths),
    shapes=(replace(SETTLES, name="tau_a_own"),),
    each=True,
    first=True,
)


def _warmed(model: Model, port: Port, p: Values) -> Model:
    """T' = |z'| − T/τ: warmth of dry friction, which is lost as Newton has it; each step exact for its mean
    speed."""
    beta, tau = p.values()
    way_kept = _kept("self_heating", port, tau, way(port), unit_of(model, port["z"]))
    return model.extend(port.equation, lambda k: k * (1 + beta * way_kept.symbol), statements=(way_kept,))


def _kept(name: str, port: Port, tau: Parameter, step: Expr, unit: str) -> State:
    """The way (or what else makes heat) of which the heat is still there; in the last `step` came so much."""
    x = (port["t"] - port["t_prev"]) / tau
    mean = Piecewise(((1 - exp(-x)) / x, x > 0), (1, True))
    before = Symbol(name, real=True)
    return State(name, 0, before * exp(-x) + step * mean, unit=unit, text="of which the heat is still there")


def _warmed_by_flow(model: Model, port: Port, p: Values) -> Model:
    """T' = v² − T/τ: warmth of a dashpot."""
    beta, d, tau = p.values()
    step = port["v"] ** 2 * (port["t"] - port["t_prev"])
    flow = _kept("flow_heating", port, tau, step, f"({unit_of(model, port['v'])})**2*s")
    return model.extend(port.equation, lambda F: F + (beta * F + d) * flow.symbol, statements=(flow,))


def _warmed_all(model: Model, port: Port, p: Values) -> Model:
    model = _warmed(model, port, p)
    beta, _ = p.values()
    for q in partners(model, port, "friction"):
        model = model.extend(q.equation, lambda x: x * (1 + beta * Symbol("self_heating", real=True)))
    return model


self_heating = replace(
    temperature_drift,
    says="the stiffness changes as the sample warms up by its own losses, the more the more it moves",
    source="Newton's law of cooling; heat of dry friction, as e.g. in J. F. Archard, Wear 2 (1959) 438",
    strengths=(Strength("beta_h", "1/({z})", bounds=ANY, text="relative change of the stiffness per way"),),
    apply=_warmed,
    shapes=(replace(SETTLES, name="tau_h", low=0.05, high=3.0, text="time in which the heat is lost"),),
    needs=("z", "z_prev", "z_turn", "t", "t_prev"),
    common=0.5,
)

material_heating = replace(
    self_heating,
    says="the material gets softer (or harder) as it warms up by its own losses, the more the more it moves: "
    "spring and friction",
    strengths=(
        replace(self_heating.strengths[0], name="beta_m", text="relative change of the force per way"),
    ),
    apply=_warmed_all,
    shapes=(replace(self_heating.shapes[0], name="tau_m"),),
    also=("friction",),
)

viscous_heating = replace(
    self_heating,
    kinds=("force",),
    says="the sample gets softer (or harder) as it warms up by viscous losses, the more the faster it moves: "
    f"{ALL}",
    source="power of a dashpot, c v^2, e.g. S. S. Rao, Mechanical Vibrations, ch. 3; Newton's law of cooling",
    strengths=(
        Strength("beta_v", "1/(({v})**2*s)", bounds=ANY, text="relative change per heat"),
        Strength("d_v", "{port}/(({v})**2*s)", bounds=ANY, text="less so much of its constant part"),
    ),
    apply=_warmed_by_flow,
    shapes=(replace(self_heating.shapes[0], name="tau_v"),),
    needs=("v", "t", "t_prev"),
)

EFFECTS = (
    temperature_drift, material_warming, own_warming, sample_warming, dashpot_warming,
    sample_and_dashpot_warming, own_sample_warming, self_heating, material_heating, viscous_heating,
)  # fmt: skip
