"""Friction whose level changes with speed, place or way while its stiffness before slip stays (LuGre's law
without bristle damping)."""

from collections.abc import Callable
from dataclasses import replace
from math import inf
from typing import Any

from sympy import Symbol

from modelgen.effects.effect import ANY, Apply, Effect, Shape, Strength, Values
from modelgen.effects.friction import LEAST, STRENGTHENING, asymmetric_friction, position_friction
from modelgen.effects.motion import partner, way
from modelgen.effects.start import at_start
from modelgen.language import Abs, Equation, Max, Model, Port, State, exp, log, sign


def _level(name: str, rise: Callable[[Any, Values], Any], stiff: bool = True) -> Apply:
    """ṙ = ρ(v − |v| r/g(v)) with level g = 1 + `rise`(|v|, p), which is called `name`; `stiff`: see there."""
    return lambda model, port, p: _levelled(model, port, name, rise(Abs(port["v"]), p), stiff)


def _levelled(model: Model, port: Port, name: str, rise: Any, stiff: bool = True) -> Model:
    """ṙ = ρ(v − |v| r/g) with level g = 1 + rise: the state is carried as r/g, which slips at 1.

    Friction becomes h g, the inverse slip length ρ/g; when g changes, r/g changes so that the force does not.
    Without a `stiff` start the slip length stays instead: ṙ = ρ(g v − |v| r).
    """
    state = port["r"].name
    slip = partner(model, port, "slip").equation
    g, g_prev = Symbol(name, real=True), Symbol(f"{name}_prev", real=True)
    level = Equation(g.name, 1 + rise, text="level of friction at this speed")
    held = Symbol(f"{name}_last", real=True)
    before = Equation(g_prev.name, held, text="level at the sample before")
    last = State(held.name, at_start(model, level.expr), g, text="level, kept for the next sample")
    names = [s.name for s in model.statements]
    first = min(names.index(slip), names.index(port.equation))
    new = (level, before, last)
    model = replace(model, statements=(*model.statements[:first], *new, *model.statements[first:]))
    model = _carried(model, state, g_prev / g)
    if stiff:
        model = model.extend(slip, lambda rho: rho / g)
    return model.extend(port.equation, lambda h: h * g)


def _carried(model: Model, state: str, ratio: Any) -> Model:
    """The model in which the old value of `state` is multiplied by `ratio` where its new one is computed from
    it."""
    old = Symbol(state, real=True)
    names = [s.name for s in model.statements]
    for name in names[: names.index(state) + 1]:
        model = _rescaled(model, name, state, old, ratio)
    return model


def _rescaled(model: Model, name: str, state: str, old: Any, ratio: Any) -> Model:
    s = model[name]
    if name == state:
        assert isinstance(s, State)
        new = replace(s, update=s.update.xreplace({old: old * ratio}))
        return replace(model, statements=tuple(new if x.name == name else x for x in model.statements))
    return model.substitute(name, {old: old * ratio})


stribeck_slip = Effect(
    "stribeck_friction",
    ("friction",),
    "friction falls with speed, as a film of lubricant or of wear builds up; its stiffness before slip stays",
    "C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky, IEEE Trans. Autom. Control 40 (1995) 419",
    (Strength("beta", "1", text="rise of the friction at rest over that at speed"),),
    _level("stribeck_g", lambda v, p: p["beta"] * exp(-v / p["v_s"])),
    (Shape("v_s", "{v}", "speed", 0.02, 1.0, 8, text="Stribeck velocity"),),
    needs=("v", "r"),
)

stribeck_bell = Effect(
    "stribeck_friction",
    ("friction",),
    "friction falls with speed as a bell, flat about rest, as a film of lubricant builds up; its stiffness "
    "before slip stays",
    stribeck_slip.source + ": exp(−(v/v_s)²)",
    (Strength("beta_2", "1", text="rise of the friction at rest over that at speed"),),
    _level("stribeck_bell_g", lambda v, p: p["beta_2"] * exp(-((v / p["v_2"]) ** 2))),
    (Shape("v_2", "{v}", "speed", 0.02, 1.0, 8, text="Stribeck velocity"),),
    needs=("v", "r"),
    common=0.5,
)

stribeck_follows = replace(
    stribeck_slip,
    says="friction falls with speed, as a film of lubricant or of wear builds up; it follows over its slip "
    "length, which stays",
    strengths=(replace(stribeck_slip.strengths[0], name="beta_f"),),
    apply=_level("stribeck_f", lambda v, p: p["beta_f"] * exp(-v / p["v_f"]), stiff=False),
    shapes=(replace(stribeck_slip.shapes[0], name="v_f"),),
    common=0.5,
)

strengthening_slip = Effect(
    "rate_dependent_friction",
    ("friction",),
    "friction grows with speed, in proportion at first, then with its logarithm; its stiffness before slip "
    "stays",
    STRENGTHENING,
    (Strength("a", "1", text="rise of the friction where the speed grows e-fold"),),
    _level("strengthening_g", lambda v, p: p["a"] * log(1 + v / p["v_a"])),
    (Shape("v_a", "{v}", "speed", 0.01, 3.0, 6, text="speed at which the logarithm begins"),),
    needs=("v", "r"),
    common=0.5,
    instead=("stribeck_friction",),
)

strengthening_follows = replace(
    strengthening_slip,
    says="friction grows with speed, in proportion at first, then with its logarithm; it follows over its "
    "slip length, which stays",
    strengths=(replace(strengthening_slip.strengths[0], name="a_s"),),
    apply=_level("strengthening_s", lambda v, p: p["a_s"] * log(1 + v / p["v_as"]), stiff=False),
    shapes=(replace(strengthening_slip.shapes[0], name="v_as"),),
)


def _relaxing(model: Model, port: Port, p: Values) -> Model:
    """ṙ = ρ(v − |v| r) − λ r: half of the relaxation before each step of slip and half after it (Strang)."""
    state = port["r"].name
    half = exp(-p["lambda_r"] * (port["t"] - port["t_prev"]) / 2)
    model = _carried(model, state, half)
    s = model[state]
    assert isinstance(s, State)
    relaxed = replace(s, update=s.update * half)
    return replace(model, statements=tuple(relaxed if x.name == state else x for x in model.statements))


relaxing_friction = Effect(
    "maxwell_branch",
    ("friction",),
    "the friction's contacts creep: what they carry relaxes with one time constant, so that slow motion "
    "meets less of it",
    "K. C. Valanis, Arch. Mech. 23 (1971) 517: intrinsic time of path and clock; G. Strang, SIAM J. "
    "Numer. Anal. 5 (1968) 506",
    (Strength("lambda_r", "1/s", text="relaxation rate of the friction"),),
    _relaxing,
    needs=("r", "t", "t_prev"),
)


def _along(model: Model, port: Port, p: Values) -> Model:
    z = port["z"]
    return _levelled(model, port, "position_g", Max(p["kappa_1"] * z + p["kappa_2"] * z**2, LEAST - 1))


position_slip = Effect(
    "position_dependent_friction",
    ("friction",),
    "friction grows or falls along the stroke, as a wedge or a guide gets tighter; its stiffness before slip "
    "stays",
    position_friction.source,
    (
        Strength("kappa_1", "1/({z})", bounds=ANY, text="relative slope of the friction level"),
        Strength("kappa_2", "1/({z})**2", bounds=ANY, text="half its relative curvature"),
    ),
    _along,
    needs=("z", "r"),
    common=0.5,
)


def _one_way(model: Model, port: Port, p: Values) -> Model:
    return _levelled(model, port, "asymmetric_g", p["delta_v"] * sign(port["z"] - port["z_turn"]))


asymmetric_slip = replace(
    asymmetric_friction,
    says="friction is greater in one direction than in the other; its stiffness before slip stays",
    strengths=(replace(asymmetric_friction.strengths[0], name="delta_v"),),
    apply=_one_way,
    needs=("z", "z_turn", "r"),
)


def _worn(model: Model, port: Port, name: str, s_r: Any) -> tuple[Model, Any]:
    """`model` with the share of the first roughness that is left after the way so far, and its symbol."""
    left = Symbol(name, real=True)
    rough = State(name, 1, left * exp(-way(port) / s_r), text="share of the first roughness that is left")
    slip = partner(model, port, "slip").equation
    return model.before(slip, rough), left


def _run_in(model: Model, port: Port, p: Values) -> Model:
    model, left = _worn(model, port, "running_in", p["s_h"])
    return model.extend(port.equation, lambda h: h * (1 + p["rise_h"] * left))


def _run_in_slip(model: Model, port: Port, p: Values) -> Model:
    model, left = _worn(model, port, "running_in_slip", p["s_r"])
    return _levelled(model, port, "running_in_g", p["rise"] * left)


RUNS_IN = (
    "friction falls (or rises) with the way that surfaces have slid on each other, as they run in or wear"
)

running_in = Effect(
    "running_in",
    ("friction",),
    f"{RUNS_IN}; its stiffness before slip stays",
    "P. J. Blau, Wear 271 (2011) 2: running-in",
    (Strength("rise", "1", bounds=(-0.95, inf), text="friction at the start over that at last, less 1"),),
    _run_in_slip,
    (Shape("s_r", "{z}", "displacement", 1.0, 300.0, 6, text="way over which the difference falls to 1/e"),),
    needs=("z", "z_prev", "z_turn", "r"),
    common=0.5,
)

running_in_whole = replace(
    running_in,
    says=f"{RUNS_IN}; so does its stiffness before slip",
    strengths=(replace(running_in.strengths[0], name="rise_h"),),
    apply=_run_in,
    shapes=(replace(running_in.shapes[0], name="s_h"),),
)

EFFECTS = (
    stribeck_slip, stribeck_bell, stribeck_follows, strengthening_slip, strengthening_follows,
    position_slip, asymmetric_slip, running_in, running_in_whole, relaxing_friction,
)  # fmt: skip
