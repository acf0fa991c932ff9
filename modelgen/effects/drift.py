"""What drifts while recordings are taken: zero points over time, temperatures from sweep to sweep."""

from dataclasses import replace
from math import inf
from typing import Any

from sympy import Symbol

from modelgen.effects.effect import ANY, Effect, Shape, Strength, Values, unit_of
from modelgen.language import (
    Equation,
    Max,
    Model,
    Parameter,
    Port,
    State,
    Statement,
    cos,
    exp,
    im,
    pi,
    re,
    sin,
)
from modelgen.language.model import substituted

WHOLE = (
    "the material gets softer (or harder) in the course of the record, as it warms up: spring and friction"
)
WARMTH = "L. R. G. Treloar, The Physics of Rubber Elasticity (1975), ch. 2; Newton's law of cooling"
SETTLES = Shape(
    "tau", "s", "duration", 0.3, 10.0, 4, text="time in which it settles; long for a steady drift"
)


def settling(id: str, model: Model, port: Port, tau: Parameter, change: Any) -> Model:
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
    lambda model, port, p: settling("offset_drift", model, port, p["tau"], lambda F, s: F + p["d"] * s),
    (SETTLES,),
    needs=("t",),
)

own_drift = replace(
    offset_drift,
    says="the zero point of the force drifts in the course of each record, in its own direction",
    strengths=(replace(offset_drift.strengths[0], name="d_own"),),
    apply=lambda model, port, p: settling(
        "own_drift", model, port, p["tau_own"], lambda F, s: F + p["d_own"] * s
    ),
    shapes=(replace(SETTLES, name="tau_own"),),
    common=0.5,
    each=True,
    first=True,
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


def _counted(model: Model, settled: Parameter) -> tuple[Any, tuple[Statement, ...]]:
    """s, which counts the samples of the sweep as recorded, and settles; and the statements it needs."""
    n = State("sample", 0, Symbol("sample", real=True) + 1, text="samples since the start of the record")
    there = any(q.name == n.name for q in model.statements)
    return settled * (1 - exp(-n / settled)), () if there else (n,)


def _in_order(model: Model, port: Port, settled: Parameter, change: Any) -> Model:
    """The port's quantity x becomes change(x, s), s as in `_counted`."""
    s, counted = _counted(model, settled)
    return model.extend(port.equation, lambda x: change(x, s), statements=counted)


def _resists(model: Model, port: Port, more: Any, before: tuple[Statement, ...] = ()) -> Model:
    """`more` resistance of the winding, and as much more of what is in proportion to it, as skin and
    proximity add; in series, where the model does not say which parameter that is."""
    R = dict(port.variables).get("R")
    table = {R: Symbol(f"{R}_warm", real=True)} if isinstance(R, Symbol) else {}
    new = [substituted(q, table) for q in model.statements]
    there = [k for k, (q, was) in enumerate(zip(new, model.statements, strict=True)) if q != was]
    if not there:
        return model.extend(port.equation, lambda Z: Z + more, statements=before)
    unit = unit_of(model, R)
    warm = Equation(table[R].name, Max(R + more, 0), unit, text="resistance as the coil is warm")
    first = there[0]
    ports = tuple(
        replace(q, variables=tuple((n, x.xreplace(table)) for n, x in q.variables)) for q in model.ports
    )
    return replace(model, statements=(*new[:first], *before, warm, *new[first:]), ports=ports)


def _settles_in(name: str) -> Shape:
    return Shape(
        name, "1", "samples", 0.2, 10.0, 4, text="samples in which it settles; many for a steady drift"
    )


def _warming(model: Model, port: Port, p: Values) -> Model:
    s, counted = _counted(model, p["n_R"])
    return _resists(model, port, p["dR"] * s, counted)


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
    _warming,
    (_settles_in("n_R"),),
    needs=("omega",),
    common=0.5,
)


def _heated(model: Model, port: Port, p: Values) -> Model:
    """Z + h T with T' = (1/|Z|² − T)/n in samples, each step exact for the power of its sample."""
    h, n = p.values()
    before, unit = Symbol("coil_heat", real=True), f"({model[port.equation].unit})**-2"

    def between(Z: Any) -> tuple[Statement, ...]:
        kept, power = exp(-1 / n), 1 / (re(Z) ** 2 + im(Z) ** 2)
        P = Equation("coil_power", power, unit, text="power in the coil at constant voltage, over V² R")
        text = "its mean over as many samples as heat stays"
        T = Equation("coil_warmth", before * kept + P.symbol * (1 - kept), unit, text=text)
        return P, T, State(before.name, warm, T.symbol, unit=unit, text="the same one sample before")

    warm = Parameter("temperature_drift_warm", unit, 0.0, (0.0, inf), "the same before the sweep began")
    heat = h * Symbol("coil_warmth", real=True)
    return model.with_parameters(warm).extend(port.equation, lambda Z: Z + heat, statements=between)


coil_heating = Effect(
    "temperature_drift",
    ("terminals",),
    "the coil is heated by the sweep itself, less where its impedance is high: its resistance follows",
    f"{coil_warming.source}; W. Klippel, JAES 52 (2004) 3: power in the coil, thermal time constants",
    (Strength("h", "({port})**3", text="change of the resistance times |Z|², once it is warm"),),
    _heated,
    (Shape("n_h", "1", "samples", 0.005, 3.0, 5, text="samples in which the heat is lost"),),
    needs=("omega", "R"),
    common=0.5,
)

coil_heating_at_levels = replace(
    coil_heating,
    says=f"{coil_heating.says}, otherwise in each sweep",
    strengths=(replace(coil_heating.strengths[0], name="h_each"),),
    shapes=(replace(coil_heating.shapes[0], name="n_each"),),
    each=True,
    first=True,
    levels=True,
)

spring_warming = Effect(
    "temperature_drift",
    ("stiffness",),
    "the stiffness changes in the course of the sweep, as the device warms up",
    WARMTH,
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
    lambda model, port, p: _resists(model, port, p["dR_each"]),
    needs=("omega",),
    common=0.5,
    each=True,
)

spring_between = Effect(
    "temperature_drift",
    ("stiffness",),
    "the stiffness differs between sweeps, as the device warms up or has been moved meanwhile",
    WARMTH,
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
    f"{coil_warming.source}; {WARMTH}",
    (replace(OTHER_R, name="dR_both"), replace(OTHER_K, name="dK_both")),
    lambda model, port, p: _another_stiffness(_resists(model, port, p["dR_both"]), p["dK_both"]),
    needs=("omega",),
    also=("stiffness",),
    common=0.5,
    each=True,
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
    WARMTH,
    (Strength("dA", "1", bounds=ANY, text="relative change of the force per sample at the start"),),
    _softer_loop,
    (_settles_in("n_A"),),
    needs=("F_mid", "energy"),
    common=0.5,
)

EFFECTS = (
    offset_drift, own_drift, wandering_zero,
    coil_warming, coil_heating, coil_heating_at_levels, spring_warming, loop_warming,
    coil_between, spring_between, device_between,
)  # fmt: skip
