"""A joint that gives between the drive and the sample. Time domain, and samples in a steady cycle."""

from typing import Any

from sympy import Symbol

from modelgen.effects.clearance import MOTION, inner, moved
from modelgen.effects.effect import Effect, Strength, Values, at_start, change, unit_of
from modelgen.language import Equation, Model, Parameter, Port, State

SERIES = (
    "a joint or the frame gives: a spring in series with the sample, which sees less motion than is recorded"
)
TEXTBOOK = "springs in series: e.g. J. P. Den Hartog, Mechanical Vibrations (1956), sec. 2.3"


def _tried(model: Model, port: Port, motion: dict[str, Any], mark: str) -> tuple[Equation, ...]:
    """Copies of all statements from the port's motion to the force, for another motion; they change no
    memory.

    The last one is the force. A state's symbol, where its copy doesn't stand before, means its value one
    sample ago.
    """
    names = [s.name for s in model.statements]
    first = max(names.index(port[k].name) for k in MOTION) + 1
    last = names.index(next(p.equation for p in model.ports if p.kind == "force"))
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
    """The sample sees z − d with d = c F(z − d). Each step takes F as linear in d, by F at the last d and
    beside it."""
    z, v, z_prev, z_turn = (inner(model, port, k) for k in MOTION)
    unit, dt = unit_of(model, port["z"]), port["t"] - port["t_prev"]
    beside = Parameter("contact_compliance_step", unit, 1e-6, (1e-12, 1.0), "step of the slope", known=True)
    d = Symbol("contact_compliance_d", real=True)

    def seen(new: Any, old: Any, rate: Any) -> dict[str, Any]:
        return {"z": z - new, "v": v - rate, "z_prev": z_prev - old, "z_turn": z_turn - old}

    # d' by the second-order backward formula, 3/2 of the last slope less 1/2 of the one before
    last = Symbol("contact_compliance_slope", real=True)
    here = _tried(model, port, seen(d, d, -last / 2), "here")
    there = _tried(model, port, seen(d + beside, d, 3 * beside / dt / 2 - last / 2), "there")
    miss = d - p["c"] * here[-1]
    gain = 1 - p["c"] * (there[-1] - here[-1]) / beside
    start = p["c"] * at_start(model, model[next(q.equation for q in model.ports if q.kind == "force")])
    before = Equation("contact_compliance_before", d, unit, text="what the joint gave one sample before")
    gives = State(d.name, start, d - miss / gain, unit=unit, text="what the joint gives")
    speed = f"({unit})/s"
    rate = State(
        "contact_compliance_rate", 0, 3 * (d - before) / dt / 2 - last / 2, unit=speed, text="how fast"
    )
    slope = State(last.name, 0, (d - before) / dt, unit=speed, text="its mean rate in the last step")
    statements = (*here, *there, before, gives, rate, slope)
    return moved(model.with_parameters(beside), port, statements, seen(d, before.symbol, rate.symbol))


soft_joint = Effect(
    "contact_compliance",
    ("displacement",),
    SERIES,
    TEXTBOOK,
    (Strength("c", "{z}/{force}", text="compliance of the joint"),),
    _joint,
    needs=(*MOTION, "t", "t_prev"),
    also=("force",),
    common=0.3,
)

joint_in_a_cycle = Effect(
    "contact_compliance",
    ("stiffness",),
    SERIES,
    TEXTBOOK,
    (Strength("c", "1/{port}", text="compliance of the joint"),),
    change(lambda K, at, p: K / (1 + p["c"] * K)),
    needs=("amplitude",),
)

EFFECTS = (soft_joint, joint_in_a_cycle)
