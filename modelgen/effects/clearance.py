"""Play: displacement that gets lost on its way."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

from sympy import Gt, Lt, Symbol

from modelgen.effects.effect import Apply, Effect, Shape, Strength, Values, unit_of
from modelgen.effects.motion import MOTION, moved_input, moved_rate
from modelgen.language import Abs, Equation, Model, Parameter, Piecewise, Port, State, sign


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


def within(x: Any, g: Any) -> Any:
    """x held within ±g. Not by Max and Min, whose derivatives at g = 0 would depend on the order of their
    arguments."""
    above, below = Gt(x, g, evaluate=False), Lt(x, -g, evaluate=False)  # sympy tries long to decide either
    return Piecewise((g, above), (-g, below), (x, True))


AWAY = Parameter(
    "backlash_away",
    "1",
    0.0,
    (0.0, 2.0),
    "how far from touch the driven side is at the first sample, over half the play: 1 in the middle",
)


def _play(*gaps: Callable[[Values], Any], name: str, dashpot: bool = True) -> Apply:
    """Spring and friction behind the mean of plays with half the gaps ±g; the dashpot moves with those in
    touch, or is driven all the same."""

    def apply(model: Model, port: Port, p: Values) -> Model:
        z, v, z_prev, z_turn = (inner(model, port, k) for k in MOTION)
        names = [name] if len(gaps) == 1 else [f"{name}_{k}" for k in range(len(gaps))]
        drive = (z, z_prev, z_turn)
        plays = [_lagging(model, port, drive, n, g(p)) for n, g in zip(names, gaps, strict=True)]
        model = model.with_parameters(AWAY)
        unit = moved_input(model, port).unit
        before = [
            Equation(f"{n}_before", q.lag.symbol, unit, text="lag at the sample before")
            for n, q in zip(names, plays, strict=True)
        ]
        between = tuple(x for b, q in zip(before, plays, strict=True) for x in (q.turn, b, q.lag))
        behind = {
            "z": z + _mean(q.lag.symbol for q in plays),
            "v": v * _mean(q.touching for q in plays) if dashpot else v,
            "z_prev": z_prev + _mean(b.symbol for b in before),
            "z_turn": z_turn + _mean(q.turn.symbol for q in plays),
        }
        return moved(model, port, between, behind)

    return apply


def _mean(terms: Iterable[Any]) -> Any:
    every = list(terms)
    return sum(every) / len(every)


@dataclass(frozen=True)
class _Lagging:
    """One play: its lag behind the driving side where that turns, and now; 1 where it touches."""

    turn: Equation
    lag: State
    touching: Any


def _lagging(model: Model, port: Port, drive: tuple[Any, Any, Any], name: str, g: Any) -> _Lagging:
    """The play of half the gap g behind the motion `drive`: z now, one sample before, where it turns."""
    z, z_prev, z_turn = drive
    unit = moved_input(model, port).unit
    lag = Symbol(f"{name}_lag", real=True)  # of the driven side behind the driving one, within ±g

    def play(lag: Any, dz: Any) -> Any:
        """The lag after the driving side has gone dz in one direction."""
        return within(lag - dz, g)

    turned = play(lag, z_turn - z_prev)
    turn = Equation(f"{name}_turn", turned, unit, text="lag where the driving side turns")
    state = State(
        lag.name,
        (AWAY - 1) * g * sign(moved_rate(model, port).symbol),
        play(turn.symbol, z - z_turn),
        unit=unit,
        text="lag of the driven side",
    )
    return _Lagging(turn, state, Piecewise((1, Abs(lag) >= g), (0, True)))


backlash = Effect(
    "backlash",
    ("displacement",),
    "the linkage has play: after each reversal the drive crosses the gap before anything follows",
    "M. A. Krasnosel'skii, A. V. Pokrovskii, Systems with Hysteresis (1989), sec. 1.2: play operator",
    (Strength("g", "{z}", text="half of the play", scale="displacement", low=0.01, high=0.3),),
    _play(lambda p: p["g"], name="backlash"),
    needs=MOTION,
    secant=True,
)


loose_spring = Effect(
    "backlash",
    ("displacement",),
    "the linkage of spring and friction has play; the dashpot is driven all the same",
    backlash.source,
    (Strength("g_s", "{z}", text="half of the play", scale="displacement", low=0.01, high=0.3),),
    _play(lambda p: p["g_s"], name="loose", dashpot=False),
    needs=MOTION,
    secant=True,
    common=0.5,
)


def _gapped_friction(model: Model, port: Port, p: Values) -> Model:
    """A slider behind a spring with a gap: the way of the drive ahead of the slider is a play's."""
    play = _lagging(model, port, (port["z"], port["z_prev"], port["z_turn"]), "gapped", p["w_f"])
    ahead = -play.lag.symbol / p["w_f"]
    r = (ahead - within(ahead, p["share"])) / (1 - p["share"])
    return model.with_parameters(AWAY).extend(
        port.equation, lambda F: F + p["h_g"] * r, statements=(play.turn, play.lag)
    )


gapped_friction = Effect(
    "backlash",
    ("force",),
    "friction acts through a linkage with play: after each reversal its force falls to zero, stays there "
    "across the gap, and rises the other way",
    "W. D. Iwan, J. Appl. Mech. 33 (1966) 893: spring and slider; its spring with the dead zone of A. H. "
    "Nayfeh, D. T. Mook, Nonlinear Oscillations (1979), sec. 4.1",
    (Strength("h_g", "{port}", text="friction force"),),
    _gapped_friction,
    (
        Shape("w_f", "{z}", "displacement", 0.02, 0.7, 5, text="way from the middle of the gap to slip"),
        Shape("share", "1", "1", 0.1, 0.95, 3, log=False, text="half of the gap over that way"),
    ),
    needs=("z", "z_prev", "z_turn"),
    common=0.5,
)


def _dead_zone(half_gap: str, dashpot: bool) -> Apply:
    """Within ± the half gap spring and friction rest; the dashpot, too, or it is driven all the same."""

    def apply(model: Model, port: Port, p: Values) -> Model:
        z, v, z_prev, z_turn = (inner(model, port, k) for k in MOTION)
        g = p[half_gap]
        motion = {k: x - within(x, g) for k, x in (("z", z), ("z_prev", z_prev), ("z_turn", z_turn))}
        motion["v"] = Piecewise((v, Abs(z) >= g), (0, True)) if dashpot else v
        return moved(model, port, (), motion)

    return apply


dead_zone = Effect(
    "backlash",
    ("displacement",),
    "spring and friction have free play about the middle: within the gap only the dashpot is felt",
    "A. H. Nayfeh, D. T. Mook, Nonlinear Oscillations (1979), sec. 4.1: dead zone",
    (Strength("g_0", "{z}", text="half of the gap"),),
    _dead_zone("g_0", dashpot=False),
    needs=MOTION,
)

free_play = replace(
    dead_zone,
    says="there is free play about the middle: within the gap nothing is felt",
    strengths=(Strength("g_f", "{z}", text="half of the gap", scale="displacement", low=0.01, high=0.3),),
    apply=_dead_zone("g_f", dashpot=True),
    secant=True,
    common=0.5,
)


SPREAD = (-0.8, -0.4, 0.0, 0.4, 0.8)
"""The middles of five equal parts of a uniform distribution, over its half width."""


def _gap(x: float) -> Callable[[Values], Any]:
    return lambda p: p["g_m"] * (1 + x * p["w"])


gradual_backlash = Effect(
    "backlash",
    ("displacement",),
    "the linkage has play that is taken up gradually, as that of several fits with gaps of their own",
    "L. Prandtl, Z. angew. Math. Mech. 8 (1928) 85; M. Brokate, J. Sprekels, Hysteresis and Phase "
    "Transitions (1996), sec. 2.4: Prandtl–Ishlinskii operator, its plays spread evenly over g_m(1 ± w)",
    (Strength("g_m", "{z}", text="half of the mean play", scale="displacement", low=0.01, high=0.3),),
    _play(*(_gap(x) for x in SPREAD), name="gradual"),
    (Shape("w", "1", "1", 0.2, 1.0, 2, log=False, text="half width of the distribution over its mean"),),
    needs=MOTION,
    secant=True,
    common=0.5,
)


def _slack(model: Model, port: Port, p: Values) -> Model:
    """k (z − c) without what is within ±g of it, less the spring k z of a base; no force at z = 0."""
    g, c = p["g_k"], p["g_k"] * p["c"]
    return model.extend(port.equation, lambda F: F - p["k_g"] * (c + within(port["z"] - c, g)))


slack_spring = Effect(
    "backlash",
    ("force",),
    "the spring has play, as teeth of a gear have: within the gap it is not felt",
    dead_zone.source,
    (Strength("k_g", "{port}/({z})", text="stiffness that is missing within the gap"),),
    _slack,
    (
        Shape("g_k", "{z}", "displacement", 0.02, 0.7, 6, text="half of the gap"),
        Shape("c", "1", "1", -1.0, 1.0, 3, log=False, text="middle of the gap, over half of it"),
    ),
    needs=("z",),
    lacks=("z_prev",),  # there the recorded displacement is
)

EFFECTS = (backlash, loose_spring, dead_zone, free_play, gradual_backlash, gapped_friction, slack_spring)
