"""The model with what was found: its law in words, and the model itself, written to a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import Any

from sympy import sympify

from modelgen.diagnose.hypotheses.refit import Fit
from modelgen.diagnose.hypotheses.setting import Setting
from modelgen.effects.effect import UNIT_OMEGA
from modelgen.fit.result import Estimate
from modelgen.language import Equation, Model, State, powj
from modelgen.language.defaults import with_defaults
from modelgen.language.meant import expressions


def extended(
    setting: Setting, best: Fit, after: Sequence[Estimate], out: Path | None
) -> tuple[str, str | None]:
    """The law in words, and the path of the extended model (with its C beside it)."""
    if not best.hypothesis.added:
        return "", None
    model, kept = _with_values(best.hypothesis.experiment.model, after)
    law = "; ".join(f"{name} = {_readable(x)}" for name, x in _laws(setting.model, model, best))
    if out is None:
        return law, None
    from modelgen.codegen import generate
    from modelgen.language.write import to_python

    path = out / f"{setting.model.id}_extended.py"
    note = f"{setting.model.id} with {', '.join(best.ids)}, found by modelgen diagnose"
    own = [n for a in best.hypothesis.added if a.repeats for n in a.shared]
    if own:
        note += f".\nEach recording has values of its own (per_recording) of {', '.join(own)}"
    if kept:
        as_before = f"{', '.join(kept)} {'is' if len(kept) == 1 else 'are'} as in {setting.model.id}"
        note += f".\nHow the fitted records began is no default: {as_before}"
    generate(model, out, {path: to_python(model, note=note)})
    return law, str(path)


FEW = 3
"""States that are written out; a ladder of relaxation times has dozens."""


def _laws(before: Model, after: Model, best: Fit) -> list[tuple[str, Any]]:
    """What is new in a model: name and expression of each equation and state that was added or changed.

    x_1 is what x was; what several effects in turn have made of it is written out as one.
    """
    known = {s.name for s in before.statements}
    new: dict[str, Any] = {s.name: s for s in after.statements if s.name not in known}
    ports = {a.port.equation for a in best.hypothesis.added}
    few = sum(isinstance(s, State) for s in new.values()) <= FEW
    shown = (Equation, State) if few else (Equation,)
    found = []
    for s in after.statements:
        chain = s.name.rsplit("_", 1)[0] in ports and s.name in new
        if s.name not in {*new, *ports} or chain or not isinstance(s, shown):
            continue
        name, expr = (s.name, s.expr) if isinstance(s, Equation) else _change(s)
        while steps := {x: new[x.name].expr for x in expr.free_symbols if _step(x.name, ports, new)}:
            expr = expr.xreplace(steps)
        found.append((name, expr))
    return found


def _readable(expr: Any) -> Any:
    """An expression as people write it: j, (jω)^α with ω in rad/s, and clip(x, −g, g) for what is held within
    ±g."""
    from sympy import Function, I, Mul, Piecewise, Pow, Symbol

    def clipped(x: Any) -> bool:
        return isinstance(x, Piecewise) and len(x.args) == 3 and x.args[0][0] == -x.args[1][0]

    clip, j = Function("clip"), Symbol("j")
    short = expr.replace(clipped, lambda x: clip(x.args[2][0], x.args[1][0], x.args[0][0]))
    short = short.xreplace({I: j} | {x: 1 for x in short.free_symbols if x.name == UNIT_OMEGA.name})
    return short.replace(powj, lambda w, n: Pow(Mul(j, w, evaluate=False), n, evaluate=False))


def _change(s: State) -> tuple[str, Any]:
    """How a state goes on: its value at a sample from that before, or its rate."""
    return (s.name, s.update) if s.update is not None else (f"d{s.name}/dt", s.rate)


def _step(name: str, ports: set[str], new: Mapping[str, Any]) -> bool:
    """Whether `name` is x_2, x_3, … of a port's equation x."""
    x, _, count = name.rpartition("_")
    return x in ports and name in new and count.isdigit() and int(count) > 1


def _with_values(model: Model, after: Sequence[Estimate]) -> tuple[Model, list[str]]:
    """The extended model with the fitted values as defaults, under an id of its own, and the parameters that
    keep theirs: how several fitted records began, each in its own way, is nothing to another one.

    Of what else each recording has its own value of, it has the median.
    """
    own: dict[str, list[float]] = {}
    for e in after:
        own.setdefault(e.name.partition("[")[0], []).append(e.value)
    several = [n for n in _beginnings(model) if len(own.get(n, ())) > 1]
    kept = [n for n in several if model.parameter(n).default is not None]
    values = {n: median(x) for n, x in own.items() if n not in kept}
    whole = replace(with_defaults(model, values), id=f"{model.id}_extended", builder=None, options=())
    return whole, kept


def _beginnings(model: Model) -> list[str]:
    """Parameters that say how states begin, and nothing else."""
    first = {x.name for s in model.states for x in sympify(s.initial).free_symbols}
    rest = [replace(s, initial=0) if isinstance(s, State) else s for s in model.statements]
    later = {x.name for s in rest for expr in expressions(s) for x in expr.free_symbols}
    return [p.name for p in model.scalar_parameters if p.name in first - later]
