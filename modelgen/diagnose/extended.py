"""The model with what was found: its law in words, and the model itself, written to a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from modelgen.diagnose.refit import Fit
from modelgen.diagnose.setting import Setting
from modelgen.fit.result import Estimate
from modelgen.language import ComplexParameter, Model, Parameter


def extended(
    setting: Setting, best: Fit, after: Sequence[Estimate], out: Path | None
) -> tuple[str, str | None]:
    """The law in words, and the path of the extended model (with its C beside it)."""
    from sympy import I, Symbol

    if not best.hypothesis.added:
        return "", None
    model = _with_values(best.hypothesis.experiment.model, after)
    changed = {s.name for s in model.statements} - {s.name for s in setting.model.statements}
    ports = {a.port.equation for a in best.hypothesis.added}
    law = "; ".join(
        f"{s.name} = {s.expr.xreplace({I: Symbol('j')})}"
        for s in model.statements
        if hasattr(s, "expr")
        and (s.name in ports or (s.name in changed and s.name.rsplit("_", 1)[0] not in ports))
    )
    if out is None:
        return law, None
    from modelgen.codegen import generate
    from modelgen.files import write_atomically
    from modelgen.language.write import to_python

    path = out / f"{setting.model.id}_extended.py"
    note = f"{setting.model.id} with {', '.join(best.ids)}, found by modelgen diagnose"
    write_atomically(path, to_python(model, note=note), parents=True)
    generate(model, out)
    return law, str(path)


def _with_values(model: Model, after: Sequence[Estimate]) -> Model:
    """The extended model with the fitted values as defaults, under an id of its own."""
    values = {e.name.split("[")[0]: e.value for e in after}
    new: list[Parameter | ComplexParameter] = []
    for p in model.parameters:
        if isinstance(p, ComplexParameter):
            new.append(replace(p, re=_fitted(p.re, values), im=_fitted(p.im, values)))
        else:
            new.append(_fitted(p, values))
    return replace(model, id=f"{model.id}_extended", parameters=tuple(new), builder=None, options=())


def _fitted(p: Parameter, values: Mapping[str, float]) -> Parameter:
    """The parameter with its fitted value, and bounds that hold it."""
    value = values.get(p.name, p.default)
    if value is None:
        return p
    return replace(p, default=value, bounds=(min(p.bounds[0], value), max(p.bounds[1], value)))
