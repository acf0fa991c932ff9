"""Play and stops: displacement that gets lost on its way, contacts that close."""

from dataclasses import replace
from typing import Any

from sympy import Symbol

from modelgen.effects.effect import Effect, Shape, Strength, Values, add, at_start, unit_of
from modelgen.language import Abs, Equation, Max, Model, Piecewise, Port, State, sign

MOTION = ("z", "v", "z_prev", "z_turn")


def moved(model: Model, port: Port, between: tuple[Any, ...], motion: dict[str, Any]) -> Model:
    """The model in which the equations of the port's `motion` have new expressions, after the statements
    `between`.

    What they were keeps its expression under the name <name>_<count>, which `motion` and `between` are
    written in.
    """
    names = {port[k].name: inner(model, port, k).name for k in MOTION}
    statements = [replace(s, name=names[s.name]) if s.name in names else s for s in model.statements]
    last = max(n for n, s in enumerate(model.statements) if s.name in names) + 1
    outer = [Equation(port[k].name, motion[k], unit_of(model, port[k])) for k in MOTION]
    return replace(model, statements=(*statements[:last], *between, *outer, *statements[last:]))


def inner(model: Model, port: Port, key: str) -> Symbol:
    """What the port's variable `key` is called once an effect has taken its name."""
    taken = {s.name for s in model.statements}
    count = next(n for n in range(1, 99) if f"{port[key].name}_{n}" not in taken)
    return Symbol(f"{port[key].name}_{count}", real=True)


def _within(x: Any, g: Any) -> Any:
    """x held within ±g. Not by Max and Min, whose derivatives at g = 0 would depend on the order of their
    arguments."""
    return Piecewise((g, x > g), (-g, x < -g), (x, True))


def _backlash(model: Model, port: Port, p: Values) -> Model:
    """Spring, friction and dashpot behind the play."""
    return _play(model, port, p["g"], "backlash", dashpot=True)


def _play(model: Model, port: Port, g: Any, name: str, dashpot: bool) -> Model:
    z, v, z_prev, z_turn = (inner(model, port, k) for k in MOTION)
    unit = unit_of(model, port["z"])
    lag = Symbol(f"{name}_lag", real=True)  # of the driven side behind the driving one, within ±g

    def play(lag: Any, dz: Any) -> Any:
        """The lag after the driving side has gone dz in one direction."""
        return _within(lag - dz, g)

    turned = play(lag, z_turn - z_prev)
    turn = Equation(f"{name}_turn", turned, unit, text="lag where the driving side turns")
    before = Equation(f"{name}_before", lag, unit, text="lag at the sample before")
    state = State(
        lag.name,
        -g * sign(at_start(model, port["v"])),  # in touch from the start
        play(turn.symbol, z - z_turn),
        unit=unit,
        text="lag of the driven side",
    )
    touching = Piecewise((1, Abs(lag) >= g), (0, True)) if dashpot else 1
    motion = {"z": z + lag, "v": v * touching, "z_prev": z_prev + before, "z_turn": z_turn + turn}
    return moved(model, port, (turn, before, state), motion)


backlash = Effect(
    "backlash",
    ("displacement",),
    "the linkage has play: after each reversal the drive crosses the gap before anything follows",
    "M. A. Krasnosel'skii, A. V. Pokrovskii, Systems with Hysteresis (1989), sec. 1.2: play operator",
    (Strength("g", "{z}", text="half of the play", scale="displacement", low=0.01, high=0.3),),
    _backlash,
    needs=MOTION,
)


loose_spring = Effect(
    "backlash",
    ("displacement",),
    "the linkage of spring and friction has play; the dashpot is driven all the same",
    backlash.source,
    (Strength("g_s", "{z}", text="half of the play", scale="displacement", low=0.01, high=0.3),),
    lambda model, port, p: _play(model, port, p["g_s"], "loose", dashpot=False),
    needs=MOTION,
    common=0.5,
)


def _dead_zone(model: Model, port: Port, p: Values) -> Model:
    z, v, z_prev, z_turn = (inner(model, port, k) for k in MOTION)
    g = p["g_0"]
    motion = {k: x - _within(x, g) for k, x in (("z", z), ("z_prev", z_prev), ("z_turn", z_turn))}
    return moved(model, port, (), motion | {"v": v})


dead_zone = Effect(
    "backlash",
    ("displacement",),
    "spring and friction have free play about the middle: within the gap only the dashpot is felt",
    "A. H. Nayfeh, D. T. Mook, Nonlinear Oscillations (1979), sec. 4.1: dead zone",
    (Strength("g_0", "{z}", text="half of the gap", scale="displacement", low=0.01, high=0.3),),
    _dead_zone,
    needs=MOTION,
)


def _stop(side: int) -> Effect:
    end = "upper" if side > 0 else "lower"
    return Effect(
        "end_stop",
        ("force",),
        f"beyond a certain displacement a stop at the {end} end comes into contact: another spring acts, "
        f"on one side only",
        "S. W. Shaw, P. J. Holmes, J. Sound Vib. 90 (1983) 129",
        (Strength(f"k_{end}", "{port}/{z}", text="stiffness of the contact"),),
        add(lambda at, p: side * p[f"k_{end}"] * Max(0, side * (at["z"] - p[f"z_{end}"]))),
        (Shape(f"z_{end}", "{z}", "position", 1.0, 1.0, 12, log=False, text="where the contact begins"),),
        needs=("z",),
    )


EFFECTS = (backlash, loose_spring, dead_zone, _stop(1), _stop(-1))
