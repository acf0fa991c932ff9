"""The inverse of a model of a motion: from the wanted output to the displacement that gives it.

The MRE paper announces it for the modified Dahl model. There, over one sample of length h, the force is
F(z) = h_D r(z) + k_D z + c_D (z − z_prev)/h + F_0, with r(z) the exact solution of (8) from the state before:
r grows with z in either direction as long as |r| <= 1, and k_D + c_D/h > 0 makes F grow without bound, so
exactly one z gives the wanted force, reversal or not.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import mpmath as mp
import sympy as sp

from modelgen.errors import InputError, did_you_mean
from modelgen.export.exact import DIGITS, run
from modelgen.export.rewrite import step_name
from modelgen.export.values import default_range, trials
from modelgen.language import Equation, Implicit, Input, Model, Output, Parameter, State
from modelgen.language.derived import per
from modelgen.language.quantities import BACKWARD


def inverse(model: Model, output: str = "", drive: str = "") -> Model:
    """The model whose input is the wanted `output`, and whose output is the input `drive` that gives it.

    By default the first output, and the first input after time. Rates of the drive become differences over
    the step; the drive is sought between two new parameters, drive_min and drive_max (an actuator's ends).
    Where the output cannot be had there, no step is taken. At the first sample the drive is drive_0; at one
    at the same time as that before, it stays where it is.
    Raises InputError for a model without memory, or with a rate or an implicit equation of its own.
    """
    z, wanted = _ends(model, output, drive)
    t, last = model.inputs[0], sp.Symbol(f"{z.name}_last", real=True)
    since = t.symbol - sp.Symbol(f"{t.name}_prev", real=True)
    dt = Equation(step_name(model), since, t.unit, text="time since the last")
    memory, derived = _derived(model, z, dt, last)
    low, high = default_range(z)
    limits = [
        Parameter(f"{z.name}_min", z.unit, low, text=f"least {z.text}", known=True),
        Parameter(f"{z.name}_max", z.unit, high, text=f"greatest {z.text}", known=True),
        Parameter(
            f"{z.name}_0", z.unit, 0.5 * (low + high), text=f"{z.text} at the first sample", known=True
        ),
    ]
    target = Input(f"{wanted}_wanted", model[wanted].unit, f"wanted {wanted}", range=_reach(model, wanted, z))
    found = Implicit(
        z.name,
        sp.Piecewise(
            (_expanded(model, derived, wanted) - target.symbol, dt.symbol > 0),
            (z.symbol - last, True),
        ),
        (limits[0].symbol, limits[1].symbol),
        z.unit,
        text=f"{z.text} that gives the wanted {wanted}",
    )
    statements = [dt, found, *derived, *model.statements, *memory(limits[2])]
    kept = [i for i in model.inputs if i.derived is None and i not in (t, z)]
    return Model(
        f"{model.id}_inverse",
        inputs=(t, target, *kept, *_clock(model, t, kept)),
        parameters=(*model.parameters, *limits),
        statements=tuple(statements),
        outputs=(Output(z.name), Output(wanted)),
        source=model.source,
        text=f"inverse of: {model.text or model.id}",
        options=model.options,
        checked=True,  # its residual is a displacement where no time passes and a force elsewhere
    )


def _ends(model: Model, output: str, drive: str) -> tuple[Input, str]:
    """The input that is sought and the name of the output that is wanted."""
    outputs = [o.name for o in model.outputs]
    drives = {i.name: i for i in model.inputs[1:] if i.derived is None}
    if not model.is_time_model or not drives:
        raise InputError(
            f"model '{model.id}' has no motion in time, so there is nothing to invert step by step"
        )
    wanted, name = output or outputs[0], drive or next(iter(drives))
    if wanted not in outputs:
        raise InputError(f"model '{model.id}' has no output '{wanted}'{did_you_mean(wanted, outputs)}")
    if name not in drives:
        raise InputError(f"model '{model.id}' has no input '{name}'{did_you_mean(name, drives)}")
    bad = [
        s.name for s in model.statements if isinstance(s, Implicit) or getattr(s, "rate", None) is not None
    ]
    if bad:
        raise InputError(f"model '{model.id}' cannot be inverted: '{bad[0]}' is itself solved or integrated")
    return drives[name], wanted


def _derived(model: Model, z: Input, dt: Equation, last: Any) -> tuple[Any, list[Equation]]:
    """What was derived from the record of the drive, as equations of the step, and a maker of its memory."""
    kinds = {i.derived[0]: i for i in model.inputs if i.derived and i.derived[1] == z.name}
    unknown = [k for k in kinds if k not in (*BACKWARD, "rate", "acceleration")]
    used = {s.name for x in model.statements for s in _symbols(x)}
    for k in unknown:
        if kinds[k].name in used:
            raise InputError(f"model '{model.id}' cannot be inverted: it needs the {k} of '{z.name}'")
    moving = dt.symbol > 0
    equations = [Equation(kinds[k].name, last, z.unit, text=kinds[k].text) for k in BACKWARD if k in kinds]

    def over_step(change: Any, unit: str, wanted: str) -> Any:
        scale = per(unit, dt.unit, 1, wanted)
        rise = change / dt.symbol if scale == 1 else scale * change / dt.symbol
        return sp.Piecewise((rise, moving), (0, True))

    states = [State(last.name, update=z.symbol, unit=z.unit, text=f"{z.text} of the last sample")]
    if "rate" in kinds or "acceleration" in kinds:
        v = kinds.get("rate") or Input(f"{z.name}_rate", f"({z.unit})/({dt.unit})")
        rate = over_step(z.symbol - last, z.unit, v.unit)
        equations.append(Equation(v.name, rate, v.unit, text=f"{v.text}, over the step"))
        if "acceleration" in kinds and kinds["acceleration"].name in used:
            v_last = sp.Symbol(f"{v.name}_last", real=True)
            bend = kinds["acceleration"]
            equations.append(Equation(bend.name, over_step(v.symbol - v_last, v.unit, bend.unit), bend.unit))
            kept = sp.Piecewise((v.symbol, moving), (v_last, True))
            states.append(State(v_last.name, update=kept, unit=v.unit, text=f"{v.text} over the last step"))

    def memory(start: Parameter) -> list[State]:
        return [replace(s, initial=start.symbol if s.name == last.name else 0) for s in states]

    return memory, equations


def _symbols(statement: Any) -> set[Any]:
    parts = (getattr(statement, k, None) for k in ("expr", "update", "initial"))
    return set().union(*(p.free_symbols for p in parts if p is not None))


def _expanded(model: Model, derived: list[Equation], wanted: str) -> Any:
    """The output as one expression in the drive, the other inputs, and the states before the step."""
    env: dict[Any, Any] = {}
    for s in (*derived, *model.statements):
        expr = s.expr if isinstance(s, Equation) else s.update  # type: ignore[union-attr]
        env[s.symbol] = expr.xreplace(env)
        if s.name == wanted:
            break
    return env[sp.Symbol(wanted, real=True)]


def _clock(model: Model, t: Input, kept: list[Input]) -> list[Input]:
    """The values before of time and of the inputs that stay."""
    have = {i.derived[1]: i for i in model.inputs if i.derived and i.derived[0] == "previous"}
    found = [have.get(t.name) or Input(f"{t.name}_prev", t.unit, derived=("previous", t.name))]
    return found + [have[i.name] for i in kept if i.name in have]


def _reach(model: Model, wanted: str, z: Input) -> tuple[float, float]:
    """Outputs that a motion over half of the drive's range gives at default parameters."""
    low, high = default_range(z)
    middle, quarter = 0.5 * (low + high), 0.25 * (high - low)
    ranges = {z.name: (middle - quarter, middle + quarter)}
    trial = trials(model, {}, ranges, float, steps=True)[0]
    with mp.workdps(DIGITS):
        values = [float(row[wanted]) for row in run(model, trial.samples, **trial.parameters)]
    return min(values), max(values)
