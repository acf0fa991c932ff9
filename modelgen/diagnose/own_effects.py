"""Effects of the user's own, and ports of the user's own models: whether they are of use to each other."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from modelgen.diagnose.hypotheses.addition import Addition
from modelgen.diagnose.hypotheses.hypothesis import make_hypotheses
from modelgen.diagnose.hypotheses.refit import Fit
from modelgen.diagnose.hypotheses.setting import Setting
from modelgen.effects import Effect, Shape, Strength
from modelgen.effects.effect import TURNS
from modelgen.errors import InputError, did_you_mean
from modelgen.language import Model, Port
from modelgen.userfile import told


def check_effects(effects: Sequence[Effect], model: Model, known: set[str]) -> None:
    """Refuse effects for kinds of ports that neither `model` nor the catalogue (`known`) has, and those whose
    law fails. Raises InputError."""
    _check_kinds(effects, model, known)
    _check_laws(effects, model)


def _check_kinds(effects: Sequence[Effect], model: Model, known: set[str]) -> None:
    """Refuse an effect for kinds of ports that neither model nor catalogue knows: it would fit none; and one
    whose turn is none."""
    here = {p.kind for p in model.ports}
    for e in effects:
        if not isinstance(e, Effect):
            raise InputError(f"effects: found {e!r}, wanted an Effect")
        _check_tuples(e)
        if e.acts not in tuple(TURNS):
            raise InputError(f"effect '{e.id}': acts is {e.acts!r}, wanted {', '.join(TURNS.values())}")
        if not (known | here) & set(e.kinds):
            kind = e.kinds[0] if e.kinds else ""
            raise InputError(
                f"effect '{e.id}': no kind of port '{kind}' ({model.id} has {', '.join(sorted(here))})"
                f"{did_you_mean(kind, known | here)}"
            )


TUPLES = (
    "kinds", "strengths", "shapes", "needs", "lacks", "also", "unless", "amid", "without", "alike", "instead",
    "units",
)  # fmt: skip
"""What an effect has several of, or none."""


def _check_tuples(e: Effect) -> None:
    """Refuse an effect of which one thing stands where a tuple of them is wanted: a comma was forgotten."""
    for key in TUPLES:
        given = getattr(e, key)
        if not isinstance(given, tuple | list):
            found = "text" if isinstance(given, str) else f"of type {type(given).__name__}"
            one = repr(given) if isinstance(given, str) else f"{type(given).__name__}(…)"
            raise InputError(f"effect '{e.id}': {key} is {found}, wanted a tuple of them: ({one},)")


def _check_laws(effects: Sequence[Effect], model: Model) -> None:
    """Refuse an effect whose law fails where it is to be added: what can't be built is else left out."""
    for e in effects:
        for port in e.fits(model):
            _check_units(e, model, port)
            try:
                e.extend(model, port)
            except KeyError as missing:
                name = str(missing.args[0])
                have = [*dict(port.variables), *e.parameters(model, port)]
                raise InputError(
                    f"effect '{e.id}': neither port '{port.name}' of {model.id} nor the effect has a '{name}'"
                    f"{did_you_mean(name, have)}"
                ) from None
            except InputError as why:
                raise InputError(f"effect '{e.id}' at port '{port.name}': {why}") from None
            except Exception as error:
                where = f"effect '{e.id}' at port '{port.name}' of {model.id}"
                raise InputError(f"{where}: {told(error)}") from None


UNITS = ("port", "stiffness", "impedance", "force")
"""What a unit may name in braces beside the port's variables."""


def _check_units(e: Effect, model: Model, port: Port) -> None:
    """Refuse an effect a unit of which names what its port has not, or is no unit."""
    where = f"effect '{e.id}' at port '{port.name}' of {model.id}"
    try:
        e.parameters(model, port)
    except KeyError as missing:
        name, have = str(missing.args[0]), (*UNITS, *dict(port.variables))
        raise InputError(f"{where}: no '{{{name}}}' for a unit{did_you_mean(name, have)}") from None
    except (InputError, ValueError, IndexError) as error:
        raise InputError(f"{where}: {error}") from None


def unused(effects: Sequence[Effect], model: Model, additions: Sequence[Addition]) -> tuple[str, ...]:
    """Notes on effects that are none of the `additions` which model and recordings allow: each with the
    reason."""
    tried = {id(a.effect) for a in additions}
    return tuple(f"effect '{e.id}' was not tried: {_why(e, model)}" for e in effects if id(e) not in tried)


def _why(e: Effect, model: Model) -> str:
    """What `model`, or its recordings, lack for `e`."""
    here = {p.kind for p in model.ports}
    if not here & set(e.kinds):
        return f"it is for {_listed(e.kinds)}, and {model.id} has {_listed(sorted(here))}"
    if absent := set(e.also) - here:
        return f"it needs a port {_listed(sorted(absent))} too, and {model.id} has none"
    if present := set(e.unless) & here:
        return f"it is for models without a port {_listed(sorted(present))}"
    if e.fits(model) and e.each and not e.levels:
        return "it differs from sweep to sweep, and these recordings are no repeats of one sweep"
    if e.fits(model):
        searched: tuple[Shape | Strength, ...] = (*e.shapes, *e.strengths)
        scales = (f"{q.name} ('{q.scale}')" for q in searched if q.scale not in ("", "1"))
        return f"the recordings give no range to search in for {', '.join(scales)}"
    port = next(p for k in e.kinds for p in model.ports if p.kind == k)
    have = {n for n, _ in port.variables}
    if absent := set(e.needs) - have:
        wanted, known = _listed(sorted(absent)), _listed(sorted(have))
        return f"it needs {wanted} of port '{port.name}', which has {known}{did_you_mean(min(absent), have)}"
    if barred := set(e.lacks) & have:
        return f"it is for ports without {_listed(sorted(barred))}"
    return f"it is for {_listed(e.units)}, and port '{port.name}' is in '{model[port.equation].unit}'"


def _listed(names: Iterable[str]) -> str:
    return ", ".join(f"'{n}'" for n in names) or "nothing"


SAME, INTEGRATED = 1e-6, 1e-2
"""Part of a recording's model that an effect of no strength may change: rounding, and where states are
integrated what finer steps do."""


def check_nulls(additions: Sequence[Addition], setting: Setting, base: Fit) -> None:
    """Refuse `additions` that change what the model gives where their strength is null: the new model would
    not be the old one with more beside it. Raises InputError."""
    e = base.hypothesis.experiment
    for h in make_hypotheses(setting.model, setting.case, setting.series, [(a,) for a in additions]):
        theta, (a,) = h.place(base.hypothesis, base.theta, {}), h.added
        for k, s in enumerate(e.series):
            before = e.raw(base.theta, k)
            changed = np.abs(h.experiment.raw(theta, k) - before).max()
            size = np.abs(before + s.data).max()
            if not changed <= (INTEGRATED if h.experiment.model.states else SAME) * size:
                null = " and ".join(f"{n} = {x:g}" for n, x in a.nulls.items())
                raise InputError(
                    f"effect '{a.id}' at port '{a.port.name}': with {null} the model has to be as it was, "
                    f"and differs by {100 * changed / size:.3g} % in '{s.name}'"
                )
