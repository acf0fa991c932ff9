"""What changes while a record is taken: zero points, temperatures."""

from dataclasses import replace
from typing import Any

from sympy import Symbol

from modelgen.effects.effect import ANY, Effect, Shape, Strength, Values, change, unit_of
from modelgen.effects.motion import way
from modelgen.language import Model, Parameter, Piecewise, Port, State, cos, exp, pi, sin

WARMS = "the stiffness changes in the course of the record, as the sample warms up"
SETTLES = Shape(
    "tau", "s", "duration", 0.3, 10.0, 4, text="time in which it settles; long for a steady drift"
)


def _settling(id: str, model: Model, port: Port, tau: Parameter, change: Any) -> Model:
    """The port's quantity x becomes change(x, s), where s grows from 0 as the time since the start, and
    settles at τ."""
    start = State(
        f"{id}_t_0", port["t"], Symbol(f"{id}_t_0", real=True), unit="s", text="time of the first sample"
    )
    s = tau * (1 - exp(-(port["t"] - start) / tau))
    timed = () if any(q.name == start.name for q in model.statements) else (start,)
    return model.extend(port.equation, lambda x: change(x, s), statements=timed)


offset_drift = Effect(
    "offset_drift",
    ("force",),
    "the zero point of the force drifts in the course of the record",
    "first-order settling, e.g. of a strain-gauge bridge as it warms up",
    (Strength("d", "{port}/s", bounds=ANY, text="rate of the drift at the start"),),
    lambda model, port, p: _settling("offset_drift", model, port, p["tau"], lambda F, s: F + p["d"] * s),
    (SETTLES,),
    needs=("t",),
)


def _wandering(model: Model, port: Port, p: Values) -> Model:
    start = State(
        "wander_t_0", port["t"], Symbol("wander_t_0", real=True), unit="s", text="time of the first sample"
    )
    x = 2 * pi * (port["t"] - start) / p["T"]
    waves = sum(p[f"s_{n}"] * sin(n * x) + p[f"c_{n}"] * (1 - cos(n * x)) for n in WAVES)
    return model.extend(port.equation, lambda F: F + waves, statements=(start,))


WAVES = (1, 2)

wandering_zero = Effect(
    "offset_drift",
    ("force",),
    "the zero point of the force wanders in the course of the record, in waves no shorter than half of it",
    "Fourier series beyond the record's length: J. P. Boyd, J. Comput. Phys. 178 (2002) 118",
    tuple(
        Strength(f"{part}_{n}", "{port}", bounds=ANY, text=f"wave {n}, its {name}")
        for n in WAVES
        for part, name in (("s", "sine"), ("c", "one minus its cosine"))
    ),
    _wandering,
    (Shape("T", "s", "cycles", 1.0, 3.0, 3, text="period of the longest wave"),),
    needs=("t",),
    common=0.5,
)

temperature_drift = Effect(
    "temperature_drift",
    ("spring",),
    WARMS,
    "L. R. G. Treloar, The Physics of Rubber Elasticity (1975), ch. 2; Newton's law of cooling",
    (Strength("beta", "1/s", bounds=ANY, text="relative rate of change of the stiffness at the start"),),
    lambda model, port, p: _settling(
        "temperature_drift", model, port, p["tau"], lambda k, s: k * (1 + p["beta"] * s)
    ),
    (SETTLES,),
    needs=("t",),
)


def _in_order(model: Model, port: Port, settled: Parameter, change: Any) -> Model:
    """The port's quantity x becomes change(x, s), where s counts the samples of the sweep as recorded, and
    settles."""
    n = State("sample", 0, Symbol("sample", real=True) + 1, text="samples since the start of the record")
    s = settled * (1 - exp(-n / settled))
    counted = () if any(q.name == n.name for q in model.statements) else (n,)
    return model.extend(port.equation, lambda x: change(x, s), statements=counted)


def _settles_in(name: str) -> Shape:
    return Shape(
        name, "1", "samples", 0.2, 10.0, 4, text="samples in which it settles; many for a steady drift"
    )


coil_warming = Effect(
    "temperature_drift",
    ("electrical_impedance",),
    "the coil warms up during the sweep: its resistance grows from sample to sample",
    "IEC 60751: copper and its like, 0.4 % per kelvin",
    (
        Strength(
            "dR", "{port}", bounds=ANY, text="change of the resistance per sample at the start of the record"
        ),
    ),
    lambda model, port, p: _in_order(model, port, p["n_R"], lambda Z, s: Z + p["dR"] * s),
    (_settles_in("n_R"),),
    needs=("omega",),
    common=0.5,
)

spring_warming = Effect(
    "temperature_drift",
    ("stiffness",),
    "the stiffness changes in the course of the sweep, as the device warms up",
    temperature_drift.source,
    (
        Strength(
            "dK",
            "1",
            bounds=ANY,
            text="relative change of the stiffness per sample at the start of the record",
        ),
    ),
    lambda model, port, p: _in_order(model, port, p["n_K"], lambda K, s: K * (1 + p["dK"] * s)),
    (_settles_in("n_K"),),
    needs=("omega",),
    common=0.5,
)


def _another_stiffness(model: Model, dK: Any) -> Model:
    for q in (q for q in model.ports if q.kind == "stiffness"):
        model = model.extend(q.equation, lambda K: K * (1 + dK))
    return model


OTHER_R = Strength("dR_each", "{port}", bounds=ANY, text="resistance beyond that in the first sweep")
OTHER_K = Strength("dK_each", "1", bounds=ANY, text="relative change of the stiffness since the first sweep")

coil_between = Effect(
    "temperature_drift",
    ("electrical_impedance",),
    "the coil is warmer (or colder) in one sweep than in another: its resistance differs between them",
    coil_warming.source,
    (OTHER_R,),
    change(lambda Z, at, p: Z + p["dR_each"]),
    needs=("omega",),
    common=0.5,
    each=True,
)

spring_between = Effect(
    "temperature_drift",
    ("stiffness",),
    "the stiffness differs between sweeps, as the device warms up or has been moved meanwhile",
    temperature_drift.source,
    (OTHER_K,),
    lambda model, port, p: _another_stiffness(model, p["dK_each"]),
    needs=("omega",),
    common=0.5,
    each=True,
)

device_between = Effect(
    "temperature_drift",
    ("electrical_impedance",),
    "the device is warmer (or colder) in one sweep than in another: resistance and stiffness differ",
    f"{coil_warming.source}; {temperature_drift.source}",
    (replace(OTHER_R, name="dR_both"), replace(OTHER_K, name="dK_both")),
    lambda model, port, p: _another_stiffness(
        model.extend(port.equation, lambda Z: Z + p["dR_both"]), p["dK_both"]
    ),
    needs=("omega",),
    also=("stiffness",),
    common=0.5,
    each=True,
)

WHOLE = (
    "the material gets softer (or harder) in the course of the record, as it warms up: spring and friction"
)


def _softer(model: Model, port: Port, p: Values) -> Model:
    for q in (port, *(q for q in model.ports if q.kind == "friction")):
        at = replace(port, equation=q.equation)  # a port of friction needs not tell the time
        model = _settling("material_warming", model, at, p["tau_w"], lambda x, s: x * (1 + p["beta_w"] * s))
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


dashpot_warming = replace(
    temperature_drift,
    kinds=("force",),
    says="the dashpot gets softer (or harder) in the course of the record, as its fluid or material warms up",
    source="O. Reynolds, Phil. Trans. R. Soc. 177 (1886) 157: viscosity and temperature; Newton's cooling",
    strengths=(
        Strength("dc", "{port}/({v}*s)", bounds=ANY, text="rate of change of the damping at the start"),
    ),
    apply=lambda model, port, p: _settling(
        "dashpot_warming", model, port, p["tau_c"], lambda F, s: F + p["dc"] * s * port["v"]
    ),
    shapes=(replace(SETTLES, name="tau_c"),),
    needs=("t", "v"),
    common=0.5,
)


def _warmed(model: Model, port: Port, p: Values) -> Model:
    """T' = |z'| − T/τ: warmth of dry friction, which is lost as Newton has it; each step exact for its mean
    speed."""
    x = (port["t"] - port["t_prev"]) / p["tau_h"]
    kept = Piecewise(((1 - exp(-x)) / x, x > 0), (1, True))
    T = Symbol("self_heating", real=True)
    unit = unit_of(model, port["z"])
    warmth = State(T.name, 0, T * exp(-x) + way(port) * kept, unit=unit, text="way whose heat is still there")
    return model.extend(port.equation, lambda k: k * (1 + p["beta_h"] * warmth.symbol), statements=(warmth,))


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


def _softer_loop(model: Model, port: Port, p: Values) -> Model:
    for name in (port.equation, port["F_mid"].name, port["energy"].name):
        at = replace(port, equation=name)
        model = _in_order(model, at, p["n_A"], lambda F, s: F * (1 + p["dA"] * s))
    return model


loop_warming = Effect(
    "temperature_drift",
    ("cycle",),
    WHOLE,
    temperature_drift.source,
    (Strength("dA", "1", bounds=ANY, text="relative change of the force per sample at the start"),),
    _softer_loop,
    (_settles_in("n_A"),),
    needs=("F_mid", "energy"),
    common=0.5,
)

EFFECTS = (
    offset_drift, wandering_zero, temperature_drift, material_warming, dashpot_warming,
    self_heating,
    coil_warming, spring_warming, loop_warming, coil_between, spring_between, device_between,
)  # fmt: skip
