"""A joint that gives between the drive and the sample. Time domain, and samples in a steady cycle."""

from dataclasses import replace
from typing import Any

import sympy
from sympy import Symbol, sympify

from modelgen.effects.clearance import inner, moved
from modelgen.effects.effect import BEFORE, FIRST, RARER, Effect, Shape, Strength, Values, change, unit_of
from modelgen.effects.motion import MOTION, partner
from modelgen.effects.start import at_start, put, undeflected
from modelgen.language import Equation, Max, Min, Model, Parameter, Piecewise, Port, State, sign

SERIES = (
    "a joint or the frame gives: a spring in series with the sample, which sees less motion than is recorded"
)
TEXTBOOK = "springs in series: e.g. J. P. Den Hartog, Mechanical Vibrations (1956), sec. 2.3"

STEPS = 2
"""Of Newton's method: one would do for a linear sample."""


def _tried(model: Model, port: Port, motion: dict[str, Any], mark: str) -> tuple[Equation, ...]:
    """Copies of all statements from the port's motion to the force, for another motion; they change no
    memory.

    The last one is the force. A state's symbol, where its copy doesn't stand before, means its value one
    sample ago.
    """
    names = [s.name for s in model.statements]
    first = max(names.index(port[k].name) for k in MOTION) + 1
    last = names.index(partner(model, port, "force").equation)
    copies: list[Equation] = []
    table: dict[Any, Any] = {}
    for k in MOTION:
        copies.append(Equation(f"{port[k].name}_{mark}", motion[k], unit_of(model, port[k])))
        table[port[k]] = copies[-1].symbol
    for s in model.statements[first : last + 1]:
        expr = s.expr if isinstance(s, Equation) else s.update if isinstance(s, State) else None
        if expr is not None:
            copies.append(Equation(f"{s.name}_{mark}", expr.xreplace(table), s.unit, text=f"{s.name}, tried"))
            table[s.symbol] = copies[-1].symbol
    return tuple(copies)


def _joint(model: Model, port: Port, p: Values) -> Model:
    return _behind(model, port, "", p["c"], 0)


def _damped_joint(model: Model, port: Port, p: Values) -> Model:
    return _behind(model, port, "_k", p["c_k"], p["tau"])


def _loaded_joint(model: Model, port: Port, p: Values) -> Model:
    return _behind(model, port, "_f", p["c_f"], 0, loaded=True)


def _behind(model: Model, port: Port, mark: str, c: Any, tau: Any, loaded: bool = False) -> Model:
    """The sample sees z − d with d + τ d' = c (F(z − d) − F_rest). Each step solves this by Newton's method,
    from where the joint goes if it goes on as before: friction bends much within a step. mark: tells names of
    one law from those of the others. F_rest: what there is where nothing is deflected, the sensor's zero; 0
    in a joint that is loaded by it."""
    z, v, z_prev, z_turn = (inner(model, port, k) for k in MOTION)
    unit, dt = unit_of(model, port["z"]), port["t"] - port["t_prev"]
    name = f"contact_compliance{mark}"
    beside = Parameter(f"{name}_step", unit, 1e-6, (1e-12, 1.0), "step of the slope", known=True)
    d, last, earlier = (Symbol(f"{name}_{n}", real=True) for n in ("d", "slope", "slope_before"))

    def rate_of(new: Any, old: Any = d) -> Any:
        """d' by the backward formula of third order: 11/6 of the last slope less 7/6 of the one before and
        1/3 of the one before that. A dashpot behind the joint shows each error of it."""
        return 11 * (new - old) / dt / 6 - 7 * last / 6 + earlier / 3

    def seen(new: Any, old: Any, rate: Any) -> dict[str, Any]:
        return {"z": z - new, "v": v - rate, "z_prev": z_prev - old, "z_turn": z_turn - old}

    force = partner(model, port, "force")
    at_rest = Equation(
        f"{name}_rest", 0 if loaded else undeflected(model, force), model[force.equation].unit,
        text="the force where nothing is deflected",
    )  # fmt: skip
    tries = [] if loaded else [at_rest]
    rest: Any = 0 if loaded else at_rest.symbol
    new: Any = d + last * dt
    for k in range(STEPS):
        here = _tried(model, port, seen(new, d, rate_of(new)), f"here{mark}_{k}")
        there = _tried(model, port, seen(new + beside, d, rate_of(new + beside)), f"there{mark}_{k}")
        miss = new + tau * rate_of(new) - c * (here[-1] - rest)
        gain = 1 + 11 * tau / dt / 6 - c * (there[-1] - here[-1]) / beside
        step = Equation(f"{name}_try_{k}", new - miss / gain, unit, text="what it gives, tried")
        tries += [*here, *there, step]
        new = step.symbol
    model = model.with_parameters(beside)
    start, rate_start = _settled(model, port, c, tau, beside, 0 if loaded else at_rest.expr)
    before = Equation(f"{name}_before", d, unit, text="what the joint gave one sample before")
    model = _begun_behind(model, port, start)
    gives = State(d.name, start, new, unit=unit, text="what the joint gives")
    speed = f"({unit})/s"
    rate = State(
        f"{name}_rate",
        rate_start,
        rate_of(d, before.symbol),
        unit=speed,
        text="how fast",
    )
    one = State(earlier.name, rate_start, last, unit=speed, text="its mean rate in the step before the last")
    slope = State(
        last.name, rate_start, (d - before.symbol) / dt, unit=speed, text="its mean rate in the last step"
    )
    statements = (*tries, before, gives, rate, one, slope)
    return moved(model, port, statements, seen(d, before.symbol, rate.symbol))


def _settled(model: Model, port: Port, c: Any, tau: Any, beside: Parameter, rest: Any) -> tuple[Any, Any]:
    """What the joint gives at the first sample, and how fast, as if it had followed the motion all along: by
    one step of Newton's method, as an expression without memory has to be short: so a memory of the motion
    counts as relaxed.

    A false start is a jump, and the dashpot behind the joint answers to it with a force that there never was.
    """
    z, v = (at_start(model, port[k]) for k in ("z", "v"))
    whole = model[partner(model, port, "force").equation]
    feet = [s for s in model.statements if isinstance(s, State) and _follows(s, z)]
    relaxed = [s.symbol for s in feet if not sympify(s.initial).has(*BENT)]

    def force(d: Any, rate: Any) -> Any:
        at = z - d
        return at_start(model, whole, {port["z"]: at, port["v"]: v - rate, **dict.fromkeys(relaxed, at)})

    gain = 1 + c * (force(0, 0) - force(beside, 0)) / beside
    rate = v * (1 - 1 / gain)
    return (c * (force(0, rate) - rest) - tau * rate) / gain, rate


BENT = (sympy.Abs, Max, Min, Piecewise, sign)
"""What stands in the start of a state that is no foot of an arm: the greatest stroke so far, play."""


def _follows(s: State, z: Any) -> bool:
    """Whether a state begins where the motion `z` has it, as the feet of a memory's arms do."""
    return sympify(s.initial).has(*z.free_symbols)


def _begun_behind(model: Model, port: Port, d: Any) -> Model:
    """The model in which states that follow the motion begin behind a joint that gives d: a memory that began
    in front of it would be stretched by all that it gives, its fastest arms most."""
    z = at_start(model, port["z"])
    statements = tuple(
        replace(s, initial=put(s.initial, {z: z - d})) if isinstance(s, State) and _follows(s, z) else s
        for s in model.statements
    )
    return replace(model, statements=statements)


soft_joint = Effect(
    "contact_compliance",
    ("displacement",),
    SERIES,
    TEXTBOOK,
    (Strength("c", "{z}/{force}", text="compliance of the joint"),),
    _joint,
    needs=(*MOTION, "t", "t_prev"),
    also=("force",),
    acts=BEFORE,
    common=0.3,
)

loaded_joint = replace(
    soft_joint,
    says=SERIES.replace("which sees less motion", "which sees less motion, by its load at rest, too,"),
    strengths=(replace(soft_joint.strengths[0], name="c_f"),),
    apply=_loaded_joint,
    common=RARER,
)

damped_joint = Effect(
    "contact_compliance",
    ("displacement",),
    SERIES.replace("a spring", "a spring with a dashpot beside it"),
    TEXTBOOK
    + "; W. N. Findley, J. S. Lai, K. Onaran, Creep and Relaxation of Nonlinear Viscoelastic Materials "
    "(1976), sec. 5.3: Kelvin element",
    (Strength("c_k", "{z}/{force}", text="compliance of the joint at rest"),),
    _damped_joint,
    (Shape("tau", "s", "1/omega", 0.03, 1.0, 4, text="dashpot over spring of the joint"),),
    needs=(*MOTION, "t", "t_prev"),
    also=("force",),
    acts=BEFORE,
    common=RARER,
)

joint_in_a_cycle = Effect(
    "contact_compliance",
    ("stiffness",),
    SERIES,
    TEXTBOOK,
    (Strength("c", "1/{port}", text="compliance of the joint"),),
    change(lambda K, at, p: K / (1 + p["c"] * K)),
    needs=("amplitude",),
    acts=BEFORE,
)

joint_at_the_sample = replace(
    joint_in_a_cycle,
    says=SERIES + "; what else is missing is on the drive's side",
    strengths=(replace(joint_in_a_cycle.strengths[0], name="c_s"),),
    apply=change(lambda K, at, p: K / (1 + p["c_s"] * K)),
    common=RARER,
    acts=FIRST,
)

EFFECTS = (soft_joint, loaded_joint, damped_joint, joint_in_a_cycle, joint_at_the_sample)
